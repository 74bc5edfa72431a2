// SPDX-License-Identifier: Apache-2.0
#include "render/gather_exitance.h"

#include "common/base/parallel.h"

namespace tallow {
namespace {

// Solid angle for a tolerance (relRMSE). Fitted: on the bunny, armadillo and elephant in marble the
// measured error is then 0.2 to 0.9 of the tolerance between 0.0003 and 0.1; doubled, it exceeds
// the tolerance on the bunny. docs/EVALUATOR.md has the table and the command that made it.
float solid_angle_for(float tolerance) { return 6 * tolerance; }

}  // namespace

std::array<ProfileTable, 3> tabulate_profiles(Model model, const Medium& medium, Orders orders) {
    const auto tabulate = [&](int channel) {
        return ProfileTable(*make_profile(model, medium, channel, orders),
                            medium.mean_free_path()[channel]);
    };
    return {tabulate(0), tabulate(1), tabulate(2)};
}

ExitanceField::ExitanceField(const LitSamples& samples, std::array<ProfileTable, 3> profiles,
                             float tolerance)
    : profiles_(std::move(profiles)), max_solid_angle_(solid_angle_for(tolerance)) {
    std::vector<float> flux(samples.position.size());
    for (int c = 0; c < 3; ++c) {
        parallel_for(flux.size(), 8192,
                     [&](std::size_t i) { flux[i] = samples.E_t[i][c] * samples.area[i]; });
        sums_[std::size_t(c)] =
            std::make_unique<PointSum>(samples.position, flux, samples.area, samples.nodes);
    }
}

void ExitanceField::gather(std::span<const ExitancePoint> points, std::span<Rgb> exitance,
                           std::span<std::uint32_t> evaluations) const {
    for (std::size_t i = 0; i < points.size(); ++i) {
        std::uint64_t calls = 0;
        for (std::size_t c = 0; c < 3; ++c)
            exitance[i][int(c)] = float(
                sums_[c]->evaluate(points[i].position, max_solid_angle_, profiles_[c], calls));
        evaluations[i] += std::uint32_t(calls);
    }
}

}  // namespace tallow
