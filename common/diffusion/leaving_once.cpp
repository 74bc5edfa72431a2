// SPDX-License-Identifier: Apache-2.0
#include "common/diffusion/leaving_once.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/diffusion/sunflower.h"
#include "common/optics/fresnel.h"

namespace tallow {
namespace {

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
    : cloud_{&sources,
             {},
             float(1 / (reduced.sigma_t_prime * sources.unit())),
             float(reduced.eta),
             float(std::sqrt(cell_area / std::numbers::pi) / sources.unit()),
             {},
             {}},
      factor_(reduced.alpha_prime / (4 * std::numbers::pi) * sources.weight_scale() /
              (sources.unit() * sources.unit())) {
    for (std::size_t i = 0; i < cloud_.above_disc.size(); ++i)
        cloud_.above_disc[i] = float(
            mean_of_disc(double(cloud_.far()) * double(i) / OnceCloud::kHeights,
                         double(cloud_.cell_radius), double(cloud_.mean_free_path), reduced.eta));
    for (std::size_t k = 0; k < cloud_.disc.size(); ++k)
        cloud_.disc[k] = cloud_.cell_radius * sunflower_point(int(k), OnceCloud::kDiscPoints);
    if (part.empty()) return;
    cloud_.part_before.reserve(part.size() + 1);
    cloud_.part_before.push_back(0);
    for (const float w : part)
        cloud_.part_before.push_back(cloud_.part_before.back() +
                                     double(w) / sources.weight_scale());
}

LeavingOnce::Exitance LeavingOnce::at(const LeavingPlace& place, OnceSources& room) const {
    const SumTree& sources = *cloud_.sources;
    if (sources.blocks().empty()) return {0, 0};
    const float to_units = float(1 / sources.unit());
    LeavingRadiance reach;
    reach.add(to_units, place.reach);
    const OnceSums sums =
        once_sum()(cloud_, {to_units * place.position, place.normal, reach}, room);
    return {factor_ * double(sums.all), factor_ * double(sums.part)};
}

}  // namespace tallow
