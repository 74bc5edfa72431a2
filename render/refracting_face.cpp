// SPDX-License-Identifier: Apache-2.0
// Curved faces -> their refracted connections: adaptive subdivision, then Newton's method.
#include "render/refracting_face.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "render/plane_of_incidence.h"

namespace tallow {
namespace {

constexpr double kEdge = 1e-7;       // a face ends so far beyond its edge, in u and v
constexpr double kConverged = 1e-9;  // last step, relative to the distance of x
constexpr double kSame = 1e-6;       // points closer than this, likewise, are one
constexpr int kIterations = 12;      // 3 to 5 are usual; more only near caustics
constexpr double kTooFar = 1;        // chosen: a first step that leads so far beyond ends a search
constexpr float kPad = 1e-5f;        // rounding of bounds to float, relative

/// A vector divided by its length, with its derivatives.
struct Unit {
    DVec3 v, d[2];
};
Unit normalized(DVec3 m, const DVec3 (&dm)[2]) {
    const double length = glm::length(m);
    Unit unit{m / length, {}};
    for (int k = 0; k < 2; ++k) unit.d[k] = (dm[k] - unit.v * glm::dot(unit.v, dm[k])) / length;
    return unit;
}

PatchBound make_bound(DVec3 center, double radius, DVec3 axis, double cos_cone) {
    const float cosine = float(cos_cone) - kPad;
    const float extent =
        float(std::max({std::abs(center.x), std::abs(center.y), std::abs(center.z)}));
    return {Vec3(center), float(radius) * (1 + kPad) + 1e-6f * extent, Vec3(axis), cosine,
            std::sqrt(std::max(0.0f, 1 - cosine * cosine))};
}

bool inside(glm::dvec2 uv, double margin) {
    return uv.x >= -margin && uv.y >= -margin && uv.x + uv.y <= 1 + margin;
}

template <class Face>
class FaceSearch {
public:
    FaceSearch(const Face& face, const Ends& ends, const RefractionCull& cull,
               std::vector<Patch>& found)
        : face_(face), ends_(ends), cull_(cull), found_(found) {}

    void search(const Corners& c, int splits) {
        const PatchBound bound = face_.bound(c);
        if (cull_.may_refract(bound)) search_within(bound, c, splits);
    }

    void search_within(const PatchBound& bound, const Corners& c, int splits) {
        const glm::dvec2 middle = (c[0] + c[1] + c[2]) / 3.0;
        if (splits == 0 || cull_.is_small(bound)) return start(middle);
        if (RefractionCull::is_flat(bound)) return start(as_if_flat(middle));
        const glm::dvec2 m[3] = {(c[1] + c[2]) / 2.0, (c[2] + c[0]) / 2.0, (c[0] + c[1]) / 2.0};
        search({c[0], m[2], m[1]}, splits - 1);
        search({m[2], c[1], m[0]}, splits - 1);
        search({m[1], m[0], c[2]}, splits - 1);
        search({m[0], m[1], m[2]}, splits - 1);
    }

private:
    void start(glm::dvec2 uv) {
        if (const auto patch = newton(uv)) add_once(ends_, *patch, found_);
    }

    // Where the plane through the face at `uv` has its solution, moved into the face.
    glm::dvec2 as_if_flat(glm::dvec2 uv) const {
        const Patch patch = face_.at(uv);
        const auto p = refract_through_plane(ends_, patch.p, patch.n);
        if (!p) return uv;
        const DVec3 d = *p - patch.p, &e = patch.dp[0], &f = patch.dp[1];
        const glm::dmat2 gram(glm::dot(e, e), glm::dot(e, f), glm::dot(e, f), glm::dot(f, f));
        const glm::dvec2 step = glm::inverse(gram) * glm::dvec2(glm::dot(d, e), glm::dot(d, f));
        const glm::dvec2 next = glm::max(uv + step, glm::dvec2(0));
        return next / std::max(1.0, next.x + next.y);
    }

    std::optional<Patch> newton(glm::dvec2 uv) const {
        Patch patch = face_.at(uv);
        SnellError error = snell_error(ends_, patch);
        for (int i = 0; i < kIterations; ++i) {
            const glm::dvec2 step = -(glm::inverse(error.df) * error.f);
            if (!(std::abs(step.x) + std::abs(step.y) < 1e6)) return std::nullopt;
            if (i == 0 && !inside(uv + step, kTooFar)) return std::nullopt;
            if (!damped_step(uv, step, patch, error)) return std::nullopt;
            const double moved = glm::length(step.x * patch.dp[0] + step.y * patch.dp[1]);
            if (moved <= kConverged * glm::length(ends_.x - patch.p))
                return inside(uv, kEdge) && on_both_sides(ends_, patch, patch.n)
                           ? std::optional(patch)
                           : std::nullopt;
        }
        return std::nullopt;
    }

    // Takes the longest of the step, its half, quarter, ... that does not lead away from the face
    // or from the solution.
    bool damped_step(glm::dvec2& uv, glm::dvec2 step, Patch& patch, SnellError& error) const {
        constexpr double kMargin = 0.5;  // faces are extrapolated so far while they are searched
        for (double scale = 1; scale > 0.01; scale /= 2) {
            const glm::dvec2 next = uv + scale * step;
            if (!inside(next, kMargin)) continue;
            const Patch next_patch = face_.at(next);
            const SnellError next_error = snell_error(ends_, next_patch);
            if (!(next_error.off <= error.off + 1e-12)) continue;
            uv = next, patch = next_patch, error = next_error;
            return true;
        }
        return false;
    }

    const Face& face_;
    const Ends& ends_;
    const RefractionCull& cull_;
    std::vector<Patch>& found_;
};

constexpr Corners kWholeFace = {{{0, 0}, {1, 0}, {0, 1}}};

}  // namespace

SmoothTriangle::SmoothTriangle(const TriangleMesh& mesh, std::size_t t)
    : p_(mesh.vertices[mesh.triangles[t][0]]), n_(mesh.corner_normals[3 * t]) {
    for (std::size_t k = 0; k < 2; ++k) {
        dp_[k] = DVec3(mesh.vertices[mesh.triangles[t][k + 1]]) - p_;
        dn_[k] = DVec3(mesh.corner_normals[3 * t + k + 1]) - n_;
    }
}

Patch SmoothTriangle::at(glm::dvec2 uv) const {
    const Unit n = normalized(n_ + uv.x * dn_[0] + uv.y * dn_[1], dn_);
    return {p_ + uv.x * dp_[0] + uv.y * dp_[1], n.v, {dp_[0], dp_[1]}, {n.d[0], n.d[1]}};
}

PatchBound SmoothTriangle::bound(const Corners& corners) const {
    // Normals between those of the corners lie in any cone below a right angle that holds these.
    std::array<Patch, 3> c;
    for (std::size_t i = 0; i < 3; ++i) c[i] = at(corners[i]);
    const DVec3 center = (c[0].p + c[1].p + c[2].p) / 3.0;
    const DVec3 axis = glm::normalize(c[0].n + c[1].n + c[2].n);
    double radius = 0, cosine = 1;
    for (const Patch& corner : c) {
        radius = std::max(radius, glm::length(corner.p - center));
        cosine = std::min(cosine, glm::dot(corner.n, axis));
    }
    return make_bound(center, radius, axis, cosine);
}

EllipsoidOctant::EllipsoidOctant(const Affine& to_world, int octant)
    : linear_(to_world.linear),
      to_normal_(glm::inverseTranspose(linear_)),
      translation_(to_world.translation),
      q_((octant & 1) != 0 ? -1 : 1, 0, 0),
      stretch_(0),
      stretch_normal_(0) {
    dq_[0] = DVec3(0, (octant & 2) != 0 ? -1 : 1, 0) - q_;
    dq_[1] = DVec3(0, 0, (octant & 4) != 0 ? -1 : 1) - q_;
    for (int i = 0; i < 3; ++i) {  // Frobenius norms
        stretch_ += glm::dot(linear_[i], linear_[i]);
        stretch_normal_ += glm::dot(to_normal_[i], to_normal_[i]);
    }
    stretch_ = std::sqrt(stretch_), stretch_normal_ = std::sqrt(stretch_normal_);
}

DVec3 EllipsoidOctant::on_sphere(glm::dvec2 uv) const {
    return glm::normalize(q_ + uv.x * dq_[0] + uv.y * dq_[1]);
}

Patch EllipsoidOctant::at(glm::dvec2 uv) const {
    const Unit q = normalized(q_ + uv.x * dq_[0] + uv.y * dq_[1], dq_);
    const Unit n = normalized(to_normal_ * q.v, {to_normal_ * q.d[0], to_normal_ * q.d[1]});
    return {
        linear_ * q.v + translation_, n.v, {linear_ * q.d[0], linear_ * q.d[1]}, {n.d[0], n.d[1]}};
}

PatchBound EllipsoidOctant::bound(const Corners& corners) const {
    // On the sphere a cap that holds the corners holds the triangle; its image lies in a ball.
    const DVec3 q[3] = {on_sphere(corners[0]), on_sphere(corners[1]), on_sphere(corners[2])};
    const DVec3 middle = glm::normalize(q[0] + q[1] + q[2]);
    double chord = 0;
    for (const DVec3& corner : q) chord = std::max(chord, glm::length(corner - middle));
    const DVec3 normal = to_normal_ * middle;
    const double length = glm::length(normal);
    const double sine = stretch_normal_ * chord / length;
    const double cosine = sine < 1 ? std::sqrt(1 - sine * sine) : -1;
    return make_bound(linear_ * middle + translation_, stretch_ * chord, normal / length, cosine);
}

void add_once(const Ends& ends, const Patch& patch, std::vector<Patch>& found) {
    const double near = kSame * glm::length(ends.x - patch.p);
    const bool known = std::any_of(found.begin(), found.end(), [&](const Patch& other) {
        return glm::length(other.p - patch.p) <= near;
    });
    if (!known) found.push_back(patch);
}

// Splits: a triangle of a mesh is small already, unless x is near; an octant is not.
void find_on_face(const SmoothTriangle& face, const PatchBound& bound, const Ends& ends,
                  const RefractionCull& cull, std::vector<Patch>& found) {
    FaceSearch(face, ends, cull, found).search_within(bound, kWholeFace, 4);
}
void find_on_face(const EllipsoidOctant& face, const Ends& ends, const RefractionCull& cull,
                  std::vector<Patch>& found) {
    FaceSearch(face, ends, cull, found).search(kWholeFace, 8);
}

}  // namespace tallow
