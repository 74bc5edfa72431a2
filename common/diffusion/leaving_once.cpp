// SPDX-License-Identifier: Apache-2.0
// Tree of sources -> those near a place, one by one, as points of discs, or many together ->
// OnceSum.
#include "common/diffusion/leaving_once.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/diffusion/sunflower.h"
#include "common/optics/fresnel.h"

namespace tallow {
namespace {

// Sources farther away than so many mean free paths do not matter: e^-8 of a tenth of the light.
constexpr float kFarthest = 8;

// A node acts as one where its radius is at most so much of its distance. Sheets: within 1 %.
constexpr float kNodeOpening = 0.2f;

// How much farther away than the body reaches, and how many mean free paths, a source may be.
constexpr float kReachSlack = 1.25f, kReachRoom = 0.25f;

// Sources farther away than so many radii of a cell act as points.
constexpr float kFarFromDisc = 4;

// The middle of a disc is where it counts most: a place above that takes the whole disc's integral.
constexpr float kMiddle = 0.4f;  // of its radius

// Mean over a disc of the radius R, at the height h above its middle, of mu T / d^2 e^(-d / l):
//
//     2 / R^2 integral of T(mu) e^(-h / (l mu)) dmu,   mu from h / sqrt(h^2 + R^2) to 1
double mean_of_disc(double height, double radius, double mean_free_path, double eta) {
    constexpr int kSteps = 400;  // of the midpoint rule
    const double least = height / std::hypot(height, radius), step = (1 - least) / kSteps;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double mu = least + (i + 0.5) * step;
        sum += double(fresnel_transmittance(float(1 / eta), float(mu))) *
               std::exp(-height / (mean_free_path * mu)) * step;
    }
    return 2 / (radius * radius) * sum;
}

}  // namespace

LeavingOnce::LeavingOnce(const ReducedChannel& reduced, const SumTree& sources, double cell_area,
                         std::span<const float> part)
    : sources_(sources),
      factor_(reduced.alpha_prime / (4 * std::numbers::pi) * sources.weight_scale() /
              (sources.unit() * sources.unit())),
      eta_(float(reduced.eta)),
      mean_free_path_(float(1 / (reduced.sigma_t_prime * sources.unit()))),
      cell_radius_(float(std::sqrt(cell_area / std::numbers::pi) / sources.unit())) {
    for (std::size_t i = 0; i < above_disc_.size(); ++i)
        above_disc_[i] =
            float(mean_of_disc(double(kFarFromDisc * cell_radius_) * double(i) / kHeights,
                               double(cell_radius_), double(mean_free_path_), reduced.eta));
    for (std::size_t k = 0; k < disc_.size(); ++k)
        disc_[k] = cell_radius_ * sunflower_point(int(k), kDiscPoints);
    if (part.empty()) return;
    part_before_.reserve(part.size() + 1);
    part_before_.push_back(0);
    for (const float w : part)
        part_before_.push_back(part_before_.back() + double(w) / sources.weight_scale());
}

// Of the weight of `count` sources.
float LeavingOnce::part_of(std::uint32_t first, std::uint32_t count) const {
    if (part_before_.empty()) return 0;
    return float(part_before_[first + count] - part_before_[first]);
}

float LeavingOnce::above_disc(float height) const {
    const float step = height / (kFarFromDisc * cell_radius_) * kHeights;
    const auto i = std::min(std::size_t(step), std::size_t(kHeights));
    return above_disc_[i] + (step - float(i)) * (above_disc_[i + 1] - above_disc_[i]);
}

class LeavingOnce::Gatherer {
public:
    Gatherer(const LeavingOnce& of, const LeavingPlace& place, OnceSources& near)
        : of_(of),
          place_(place.position / float(of.sources_.unit())),
          normal_(place.normal),
          reach_(place.reach),
          frame_(make_frame(normal_)),
          near_(near) {}

    void visit(std::uint32_t index) {
        const SumTree::Block& block = of_.sources_.blocks()[index];
        for (int lane = 0; lane < SumTree::kChildren; ++lane) {
            if (block.weight[lane] <= 0) continue;
            const Vec3 way = place_ - Vec3(block.x[lane], block.y[lane], block.z[lane]);
            const float distance = glm::length(way), radius = block.radius[lane];
            if (distance - radius > kFarthest * of_.mean_free_path_) continue;
            if (glm::dot(way, normal_) + radius <= 0) continue;  // all outside
            if (radius <= kNodeOpening * distance && is_beyond(way, distance - radius)) continue;
            if (radius <= kNodeOpening * distance && distance > far())
                near_.add(way, block.weight[lane],
                          of_.part_of(block.first[lane], block.count[lane]));
            else if (block.child[lane] != SumTree::kLeaf)
                visit(block.child[lane]);
            else
                for (std::uint32_t k = 0; k < block.count[lane]; ++k) add(block.first[lane] + k);
        }
    }
    /// Of discs that the place is above.
    Exitance below() const { return below_; }

private:
    float far() const { return kFarFromDisc * of_.cell_radius_; }

    // `nearest` is at most the length of the way.
    bool is_beyond(Vec3 way, float nearest) const {
        const float reach = reach_.at(glm::normalize(way)) / float(of_.sources_.unit());
        return nearest > kReachSlack * std::max(0.0f, reach) + kReachRoom * of_.mean_free_path_;
    }

    void add(std::uint32_t source) {
        const SumTree::Point& p = of_.sources_.points()[source];
        const float part = of_.part_of(source, 1);
        const Vec3 way = place_ - Vec3(p.x, p.y, p.z);
        const float height = glm::dot(way, normal_), distance2 = length2(way);
        if (distance2 > far() * far()) {
            near_.add(way, p.weight, part);
        } else if (height > 0 && distance2 - height * height <
                                     kMiddle * kMiddle * of_.cell_radius_ * of_.cell_radius_) {
            const float above = of_.above_disc(height);
            below_.all += double(p.weight * above), below_.part += double(part * above);
        } else if (height > 0) {
            for (const Vec2& at : of_.disc_)
                near_.add(way + at.x * frame_.s + at.y * frame_.t, p.weight / kDiscPoints,
                          part / kDiscPoints);
        }
    }

    const LeavingOnce& of_;
    Vec3 place_, normal_;
    LeavingRadiance reach_;
    Frame frame_;
    OnceSources& near_;
    Exitance below_{0, 0};
};

LeavingOnce::Exitance LeavingOnce::at(const LeavingPlace& place, OnceSources& near) const {
    if (sources_.blocks().empty()) return {0, 0};
    near.clear();
    Gatherer gatherer(*this, place, near);
    gatherer.visit(0);
    near.close();
    const Exitance below = gatherer.below();
    const OnceSums sums = once_sum()(near, place.normal, mean_free_path_, eta_);
    return {factor_ * (below.all + double(sums.all)), factor_ * (below.part + double(sums.part))};
}

}  // namespace tallow
