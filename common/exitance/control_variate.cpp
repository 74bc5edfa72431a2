// SPDX-License-Identifier: Apache-2.0
#include "common/exitance/control_variate.h"

#include <algorithm>
#include <cmath>

#include "common/base/parallel.h"

namespace tallow {
namespace {

// g is 0 where it would be below this, times 1/sigma^2: 5.4 sigma away, or up to 7.6 after fading.
constexpr double kNegligible = 1e-7;

// Relative error of C by rounding to float, of the sum of its terms' sizes. Some five roundings.
constexpr float kRounding = 0x1p-21f;

constexpr std::size_t kGrain = 16384;

KernelTable gaussian(double sigma, double unit) {
    const double a = 1 / (2 * sigma * sigma);
    return KernelTable([=](double r2) { return a / double(std::numbers::pi) * std::exp(-a * r2); },
                       sigma, unit, kNegligible / (sigma * sigma));
}

}  // namespace

ControlVariate::ControlVariate(const BodyView& body, const LitSamples& lit,
                               const ExitanceKernels& kernels, const ExitanceAccuracy& accuracy)
    : beta_(kernels.beta),
      mass_({body.positions, body.areas, body.nodes}, body.areas,
            gaussian(kernels.sigma, kernels.profiles[0].unit()), accuracy) {
    const KernelTable g = gaussian(kernels.sigma, kernels.profiles[0].unit());
    const std::span<const Rgb> E = lit.direct();
    std::vector<float> flux(E.size());
    for (std::size_t c = 0; c < 3; ++c) {
        if (beta_[c] == 0) continue;
        rest_[c] = kernels.kappa[c] - beta_[c];
        parallel_for(flux.size(), kGrain,
                     [&](std::size_t i) { flux[i] = E[i][int(c)] * lit.area[i]; });
        blurred_[c].emplace(SampleSum::Samples{lit.position, lit.area, lit.nodes}, flux, g,
                            accuracy);
    }
}

ControlVariate::Result ControlVariate::evaluate(const SumTargets& targets,
                                                std::span<const Rgb> E) const {
    Result result;
    SampleSum::Result mass;
    mass_.evaluate(targets, mass);
    result.evaluations = mass.evaluations;
    for (std::size_t c = 0; c < 3; ++c) {
        result.C[c].assign(E.size(), 0);
        result.bound[c].assign(mass.bound.size(), 0);
        if (blurred_[c]) add_channel(c, targets, E, mass, result);
    }
    return result;
}

void ControlVariate::add_channel(std::size_t channel, const SumTargets& targets,
                                 std::span<const Rgb> E, const SampleSum::Result& mass,
                                 Result& result) const {
    SampleSum::Result blurred;
    blurred_[channel]->evaluate(targets, blurred);
    const float beta = float(beta_[channel]), rest = float(rest_[channel]);
    parallel_for(E.size(), kGrain, [&](std::size_t i) {
        const float here = E[i][int(channel)];
        const float missing = std::max(-1.0f, 1 - mass.sum[i]);
        result.C[channel][i] = beta * (here - blurred.sum[i]) + rest * here * missing;
        result.evaluations[i] += blurred.evaluations[i];
        if (mass.bound.empty()) return;
        const float size =
            beta * (here + blurred.sum[i]) + std::abs(rest) * here * (1 + mass.sum[i]);
        result.bound[channel][i] =
            beta * blurred.bound[i] + std::abs(rest) * here * mass.bound[i] + kRounding * size;
    });
}

}  // namespace tallow
