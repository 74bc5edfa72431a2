// SPDX-License-Identifier: Apache-2.0
//
// The seated elephant calf. Big masses first (body, legs, skull), blended softly; then the parts
// that should stay distinct (trunk, ears, feet), blended tightly; then what a carver cuts last
// (eyes, nails, folds). All measures are in mm and chosen by eye from previews.

#include "elephant.h"

namespace tallow::sculpt {

namespace {

constexpr double kPi = 3.14159265358979323846;

const Frame kWorld{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

/// Ellipsoid with centre c.
double blob(Vec p, Vec c, Vec r) { return ellipsoid(p - c, r); }

/// `d` united with a limb; skips limbs too far away to matter.
double add_limb(double d, const Limb& limb, Vec p, double k) {
    if (limb.lower_bound(p) >= d + k) return d;
    return smooth_union(d, limb.nearest(p).distance, k);
}

/// A line in the skin, cut through the points of `chain` (on the left side, x > 0, if on both).
struct Fold {
    bool on_head;  // chain is in head coordinates
    bool on_both_sides;
    double width, depth;
    std::vector<Vec> chain;  // need not lie on the surface exactly
};

// clang-format off
const std::vector<Fold> kFolds{
    // Over the eye, under the eye, corner of the mouth.
    {true, true, 0.70, 0.30, {{6.6, 1.0, 2.6}, {6.2, 2.6, 3.4}, {5.0, 3.2, 4.6}, {3.6, 2.4, 6.2}}},
    {true, true, 0.70, 0.25, {{6.4, -0.6, 3.0}, {5.2, -1.7, 4.4}, {4.0, -1.0, 6.0}}},
    {true, true, 0.70, 0.55, {{1, -4.6, 8.2}, {2.2, -4.8, 6.6}, {3.4, -4.4, 4.8}, {5, -2.6, 3.4}}},
    // Knees of the front legs.
    {false, true, 0.40, 0.14, {{3.2, 9.4, 11}, {5.0, 8.9, 13}, {6.8, 9.2, 11}}},
    {false, true, 0.45, 0.18, {{2.6, 8.2, 11}, {5.0, 7.7, 13}, {7.4, 8.3, 11}}},
    {false, true, 0.40, 0.14, {{3.4, 6.7, 12}, {5.2, 6.6, 13}, {7.0, 7.2, 11}}},
    {false, true, 0.40, 0.15, {{2.4, 5.3, 11}, {4.6, 5.1, 13}, {7.0, 5.6, 10.5}}},
    // Knees and ankles of the hind legs.
    {false, true, 0.45, 0.18, {{13.4, 10, 6.2}, {11, 12, 6.6}, {8.2, 10.5, 7}}},
    {false, true, 0.45, 0.20, {{14.0, 8, 7.2}, {11, 11, 8.0}, {7.6, 8.5, 8}}},
    {false, true, 0.45, 0.18, {{14.0, 6, 9.4}, {11, 9, 9.8}, {8, 6.5, 9.4}}},
    // Where the thigh folds against the belly, above that, behind the elbow, across the rump.
    {false, true, 0.90, 0.40, {{10.5, 15.5, -5}, {10, 15.6, -1.5}, {9.5, 14.4, 2}, {8, 12.5, 5}}},
    {false, true, 0.70, 0.15, {{9.5, 17.0, -3.5}, {9, 17.0, -0.8}, {9, 15.8, 1.8}}},
    {false, true, 0.80, 0.28, {{8.5, 21.5, .5}, {8.8, 19, -.6}, {9, 16.6, .6}, {8.5, 14.6, 3.4}}},
    {false, true, 0.80, 0.30, {{9.5, 3.4, -8.5}, {8, 4, -11}, {5.5, 4, -13}, {2.6, 5.4, -14}}},
    // Nape, nape, throat.
    {false, false, 0.80, 0.16, {{-5, 25.0, -2}, {-2, 24.2, -4}, {2, 24.2, -4}, {5, 25.0, -2}}},
    {false, false, 0.70, 0.12, {{-4, 23.4, -3}, {-1, 22.6, -5}, {2, 22.8, -5}, {4.5, 23.6, -3}}},
    {false, false, 0.70, 0.25, {{-4.5, 22.2, 7}, {-1, 21.2, 9}, {2, 21.2, 9}, {5, 22.4, 7}}},
    // Hair of the tail's tuft.
    {false, false, 0.28, 0.16, {{11.9, 2.4, -9.8}, {11.4, 2.6, -8.4}, {11.5, 2.0, -6.2}}},
    {false, false, 0.28, 0.16, {{12.1, 2.4, -9.8}, {12.1, 2.6, -8.4}, {12.1, 2.0, -6.2}}},
    {false, false, 0.28, 0.16, {{12.4, 2.4, -9.8}, {12.8, 2.6, -8.4}, {12.8, 2.0, -6.2}}},
};
// clang-format on

}  // namespace

Elephant::Elephant()
    : head_(look_along({0.3, 29.6, 5.6}, {0.30, 0.10, 1}, {0.09, 1, 0})),
      tail_({{{0.5, 9.5, -12.5}, 1.8},
             {{1.0, 6.0, -14.6}, 1.2},
             {{3.0, 2.4, -15.2}, 1.0},
             {{6.5, 1.2, -14.6}, 0.85},
             {{10.0, 1.1, -12.6}, 0.75},
             {{12.2, 1.2, -9.6}, 0.7}}),
      trunk_({{{0, 0.4, 3.6}, 4.3},
              {{-0.1, -0.8, 7.4}, 3.25},
              {{-0.6, -2.8, 10.5}, 2.6},
              {{-1.7, -3.6, 13.4}, 2.2},
              {{-3.2, -1.8, 15.8}, 1.9},
              {{-4.5, 1.6, 16.4}, 1.7},
              {{-5.4, 4.8, 15.4}, 1.55},
              {{-6.0, 7.4, 15.2}, 1.45},
              {{-6.6, 9.3, 16.8}, 1.5}}),
      ear_outline_({{-2.0, -1.0, 0},
                    {-0.5, -4.0, 0},
                    {2.8, -5.4, 0},
                    {5.2, -8.8, 0},
                    {8.2, -9.6, 0},
                    {10.0, -6.6, 0},
                    {12.4, -3.0, 0},
                    {13.4, 2.0, 0},
                    {12.0, 7.0, 0},
                    {8.0, 9.4, 0},
                    {3.5, 8.0, 0},
                    {0.5, 6.2, 0},
                    {-2.2, 4.0, 0}}),
      ear_veins_(
          {Limb({{{0, 2, 0}, 0.9}, {{4, 4, 0}, 0.7}, {{8, 5.5, 0}, 0.55}, {{10, 7, 0}, 0.4}}),
           Limb({{{0, 1, 0}, 0.9}, {{5, 1.5, 0}, 0.7}, {{9, 1, 0}, 0.55}, {{12, 2, 0}, 0.4}}),
           Limb({{{0, 0, 0}, 0.9}, {{4, -1.5, 0}, 0.7}, {{7, -4, 0}, 0.55}, {{7.5, -8, 0}, 0.4}}),
           Limb({{{5, 1.5, 0}, 0.6}, {{8, -1, 0}, 0.55}, {{10.5, -2.5, 0}, 0.4}})}) {
    place_ear(+1, 0.50, 0.20);
    place_ear(-1, 0.42, 0.06);
    place_legs(+1);
    place_legs(-1);
    place_eye(+1);
    place_eye(-1);
    engrave_skin();
}

void Elephant::place_legs(double side) {
    const double s = side;  // +1 left, -1 right
    legs_.push_back(Limb({{{s * 4.4, 20.5, 1.2}, 4.4},
                          {{s * 5.2, 17.0, 3.6}, 4.1},
                          {{s * 5.7, 13.5, 5.8}, 3.6},
                          {{s * 5.4, 10.0, 8.2}, 3.0},
                          {{s * 5.0, 7.4, 9.6}, 3.3},
                          {{s * 4.6, 4.4, 9.8}, 2.6},
                          {{s * 4.5, 1.6, 10.2}, 3.0}}));
    legs_.push_back(Limb({{{s * 5.0, 8.6, -4.0}, 7.0},
                          {{s * 8.4, 8.6, 0.6}, 5.9},
                          {{s * 10.6, 8.4, 5.2}, 5.0},
                          {{s * 11.0, 5.6, 8.6}, 3.7},
                          {{s * 11.0, 4.4, 10.6}, 3.2},
                          {{s * 11.2, 4.0, 12.6}, 3.3}}));
    const double forward = s > 0 ? 0.5 : 0;  // the left front foot is half a step ahead
    feet_.push_back(
        {.frame = look_along({s * 4.5, 1.7, 10.4 + forward}, {0, -1, 0}, {s * 0.15, 0, 1}),
         .radius = 3.35,
         .half_height = 1.9,
         .toe_spread_rad = 0.62,
         .toe_tilt_rad = -0.2,
         .toes = 4});
    feet_.push_back(
        {.frame = look_along({s * 11.3, 3.85, 13.2}, {s * 0.25, 0.16, 1}, {s * 0.1, 1, 0}),
         .radius = 3.75,
         .half_height = 1.9,
         .toe_spread_rad = 0.56,
         .toe_tilt_rad = 0.45,
         .toes = 4});
}

void Elephant::place_ear(double side, double swept_back_rad, double raised_rad) {
    const double c = std::cos(swept_back_rad), b = std::sin(swept_back_rad);
    const double cr = std::cos(raised_rad), sr = std::sin(raised_rad);
    const Vec out{side * c, 0, -b}, up{0, 1, 0};
    ears_.push_back(
        {{side * 5.0, 1.2, -1.4}, cr * out + sr * up, cr * up - sr * out, {side * b, 0, c}});
}

void Elephant::place_eye(double side) {
    const Vec p = on_surface(head_.world({side * 5.0, 0.6, 4.6}));
    const Vec n = normal(p);
    eyes_.push_back(look_along(p - 0.55 * n, n, head_.y));
}

/// Cuts a smooth line through the given points, each first moved onto the surface.
void Elephant::engrave(const Frame& frame, const std::vector<Vec>& chain, double width,
                       double depth) {
    std::vector<Limb::Knot> knots;
    for (const Vec q : chain) knots.push_back({on_surface(frame.world(q)), 0});
    std::vector<Vec> line = Limb(knots).axis();
    for (Vec& p : line) p = on_surface(p);
    grooves_.emplace_back(line, width, depth);
}

void Elephant::engrave_skin() {
    for (const Fold& fold : kFolds)
        for (const double side : {-1.0, 1.0}) {
            if (!fold.on_both_sides && side < 0) continue;
            std::vector<Vec> chain = fold.chain;
            for (Vec& p : chain) p.x *= side;
            engrave(fold.on_head ? head_ : kWorld, chain, fold.width, fold.depth);
        }
}

Vec Elephant::on_surface(Vec p) const {
    for (int i = 0; i < 20; ++i) p = p - 0.8 * distance(p) * normal(p);
    return p;
}

double Elephant::distance(Vec p) const {
    const Vec h = head_.local(p);
    double d = body(p);
    d = add_skull(d, h);
    d = add_trunk(d, h);
    for (const Frame& ear : ears_) d = add_ear(d, ear, h);
    for (const Frame& eye : eyes_) d = add_eye(d, eye, p);
    for (const Groove& groove : grooves_) d += groove.depth(p);
    return smooth_intersection(d, -p.y, 0.4);
}

Vec Elephant::normal(Vec p) const {
    constexpr double e = 1e-4;  // small against every detail, large against rounding
    return normalized({distance({p.x + e, p.y, p.z}) - distance({p.x - e, p.y, p.z}),
                       distance({p.x, p.y + e, p.z}) - distance({p.x, p.y - e, p.z}),
                       distance({p.x, p.y, p.z + e}) - distance({p.x, p.y, p.z - e})});
}

double Elephant::body(Vec p) const {
    double d = blob(p, {0, 8.8, -4.4}, {9.6, 9.4, 9.4});                 // rump
    d = smooth_union(d, blob(p, {0, 12.0, 0.8}, {8.6, 8.8, 8.4}), 6);    // belly
    d = smooth_union(d, blob(p, {0, 19.0, 0.2}, {8.3, 7.8, 7.0}), 6);    // chest
    d = smooth_union(d, blob(p, {0, 18.0, -3.6}, {2.6, 10.0, 4.4}), 6);  // spine
    d = smooth_union(d, blob(p, {0.1, 25.0, 2.4}, {6.0, 5.0, 6.0}), 5);  // neck
    for (const Limb& leg : legs_) d = add_limb(d, leg, p, 3.6);
    for (const Foot& foot : feet_) d = add_foot(d, foot, p);
    return add_tail(d, p);
}

double Elephant::add_foot(double d, const Foot& foot, Vec p) const {
    const Vec q = foot.frame.local(p);
    if (length(q) - foot.radius - 2.5 >= d + 1) return d;
    const double flare = foot.radius * (1 + 0.05 * q.z / foot.half_height);
    d = smooth_union(d, rounded_cylinder(q, flare, foot.half_height, 0.8), 1.0);
    const double ct = std::cos(foot.toe_tilt_rad), st = std::sin(foot.toe_tilt_rad);
    for (int i = 0; i < foot.toes; ++i) {
        const double a = foot.toe_spread_rad * (i - 0.5 * (foot.toes - 1));
        const Vec out{std::sin(a) * ct, std::cos(a) * ct, st};
        const Vec along{std::cos(a), -std::sin(a), 0}, down = cross(along, out);
        const Vec t = q - Vec{1.02 * foot.radius * std::sin(a), 1.02 * foot.radius * std::cos(a),
                              foot.half_height - 0.85};
        const Vec toe{dot(t, along), dot(t, down), dot(t, out)};
        d = smooth_union(d, ellipsoid(toe, {1.15, 1.15, 0.35}), 0.7);
        const double nail = ellipsoid(toe, {0.92, 0.88, 0.60});
        d = smooth_union(d + 0.13 * bump((nail - 0.08) / 0.26), nail, 0.25);
    }
    if (q.z > 0)
        d += 0.16 * bump((std::hypot(q.x, q.y) - 0.76 * foot.radius) / 0.4);  // rim of the sole
    return d;
}

double Elephant::add_tail(double d, Vec p) const {
    d = add_limb(d, tail_, p, 0.8);
    return smooth_union(d, blob(p, {12.3, 1.2, -8.2}, {1.0, 1.1, 2.2}), 0.6);
}

double Elephant::add_skull(double d, Vec h) const {
    if (length(h) - 12 >= d + 4) return d;
    const Vec pair{std::abs(h.x), h.y, h.z};              // for parts there are two of
    double s = blob(h, {0, 1.8, -0.6}, {6.7, 6.4, 6.4});  // cranium
    s = smooth_union(s, blob(pair, {2.5, 4.6, 1.0}, {3.2, 3.4, 3.6}), 3);   // brow
    s = smooth_union(s, blob(h, {0, -0.8, 3.6}, {4.7, 4.6, 4.6}), 4);       // root of the trunk
    s = smooth_union(s, blob(pair, {3.6, -2.6, 2.2}, {2.7, 3.0, 3.2}), 3);  // cheek
    s = smooth_union(s, blob(h, {0, -5.4, 2.8}, {2.8, 2.0, 3.6}), 1.2);     // jaw
    s = smooth_union(s, blob(h, {0, -5.9, 5.6}, {1.4, 1.1, 1.8}), 1.2);     // lower lip
    return smooth_union(d, s, 4);
}

double Elephant::add_trunk(double d, Vec h) const {
    if (trunk_.lower_bound(h) >= d + 2.4) return d;
    const Limb::Nearest n = trunk_.nearest(h);
    const Frame tip = look_along(trunk_.end(), trunk_.end_direction(), {0, 1, 0});
    const Vec q = tip.local(h);

    // Rings: one groove per turn of the phase, closer together towards the tip, uneven as skin is.
    const double phase = n.s / 1.3 + 0.006 * n.s * n.s + 0.13 * std::sin(1.3 * h.x + 0.9 * n.s) +
                         0.10 * std::sin(2.3 * n.s);
    const double ring = std::pow(0.5 + 0.5 * std::cos(2 * kPi * phase), 3);
    const double depth = 0.7 + 0.3 * std::sin(4.1 * n.s);
    const double fade = smooth_step(2.0, 6, n.s) * smooth_step(0.8, 2.0, trunk_.arc_length() - n.s);
    double t = n.distance + 0.085 * n.radius * depth * ring * fade;

    t = smooth_intersection(t, q.z - 0.5, 0.5);
    t = smooth_union(t, blob(q, {0, 1.1, 0.3}, {0.8, 0.6, 1.0}), 0.5);  // the finger
    t = smooth_difference(t, blob({std::abs(q.x), q.y, q.z}, {0.62, -0.1, 0.5}, {0.40, 0.5, 1.5}),
                          0.25);
    return smooth_union(d, t, 2.4);
}

double Elephant::add_ear(double d, const Frame& frame, Vec h) const {
    const Vec q = frame.local(h);
    if (length(q - Vec{6, -0.5, 0}) - 14.5 >= d + 1.8) return d;
    const double rim = ear_outline_.distance(q.x, q.y);
    if (rim >= d + 1.8) return d;

    // Middle of the sheet: a shallow bowl open to the front, wavy near the rim.
    const double u = q.x / 12;
    const double middle = 3.2 * u * u - 1.6 * u +
                          0.5 * std::sin(0.7 * q.y + 0.6) * smooth_step(4, 12, q.x) +
                          0.03 * std::pow(std::min(0.0, q.y + 4), 2);
    double half = 0.80 - 0.36 * smooth_step(0, 6, q.x);
    half += 0.20 * bump((rim + 0.8) / 0.8) * smooth_step(-2, 5, q.y);
    for (const Limb& vein : ear_veins_)
        half += 0.10 * bump(std::max(0.0, vein.nearest({q.x, q.y, 0}).distance + 0.5) / 0.9);
    const double sheet = 0.8 * (std::abs(q.z - middle) - half);
    return smooth_union(d, smooth_intersection(rim, sheet, 0.7), 1.8);
}

double Elephant::add_eye(double d, const Frame& frame, Vec p) const {
    const Vec q = frame.local(p);
    if (dot(q, q) > 16) return d;
    d = smooth_union(d, ellipsoid(q, {2.1, 1.85, 1.72}), 1.4);  // lids, still closed
    // The opening: where two discs overlap, an almond.
    const double almond = smooth_intersection(std::hypot(q.x, q.y + 0.76) - 1.66,
                                              std::hypot(q.x, q.y - 0.72) - 1.80, 0.2);
    d = smooth_difference(d, smooth_intersection(almond, 0.6 - q.z, 0.3), 0.35);
    d = smooth_union(d, length(q) - 1.50, 0.25);
    return smooth_difference(d, length(q - Vec{0.05, 0.12, 1.74}) - 0.60, 0.15);  // pupil
}

}  // namespace tallow::sculpt
