// SPDX-License-Identifier: Apache-2.0
// A pilot run on some blocks of samples -> rays for each light.
#include "precompute/choose_light_samples.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "common/base/parallel.h"
#include "precompute/light_gatherer.h"

namespace tallow {
namespace {

constexpr int kMostRays = 256;            // chosen: 256 times the noise of the tracer's own edges
constexpr std::size_t kLeastBlocks = 64;  // chosen: their mean square is known to about a tenth
constexpr std::size_t kBlocksEach = 64;   // one in so many blocks is in the pilot
constexpr int kRaysForMeans = 4;          // chosen: the mean of all blocks is then known to 1 %
constexpr double kPatchPerPath2 = 4;      // fitted, see the header
constexpr double kAlone = 10;             // chosen, see the header

/// A run's sums over blocks: of the irradiance, and of the squared differences between two
/// sequences' patches.
struct PilotSums {
    double E = 0, squares = 0;
};

class Pilot {
public:
    Pilot(const Scene& scene, const RayScene& rays, const SurfaceSamples& samples,
          const Medium& medium)
        : scene_(scene), rays_(rays), samples_(samples), eta_(medium.eta) {
        const std::size_t all = (samples.size() + kGatherBlock - 1) / kGatherBlock;
        blocks_ = std::min(all, std::max(kLeastBlocks, all / kBlocksEach));
        stride_ = blocks_ > 0 ? double(all) / double(blocks_) : 1;
        double area = 0;
        for (const float a : samples.area) area += double(a);
        const double mfp = double(min_channel(medium.mean_free_path()));
        const double averaged = kPatchPerPath2 * mfp * mfp * double(samples.size()) / area;
        const double largest = double(kGatherBlock);
        patch_ = std::bit_floor(std::size_t(std::clamp(averaged, 1.0, largest)));
    }

    /// Mean irradiance by a light, mean of the channels.
    double irradiance(std::size_t light, int rays) const {
        return run(light, rays).E / double(blocks_ * 2);
    }

    /// Root mean square error of a patch's mean irradiance with so many rays.
    double noise(std::size_t light, int rays) const {
        // A difference of two runs has twice the variance of one.
        return std::sqrt(run(light, rays).squares / 2 / double(blocks_));
    }

private:
    using Block = std::array<Transmitted, kGatherBlock>;

    PilotSums run(std::size_t light, int rays) const {
        std::vector<PilotSums> of_block(blocks_);
        parallel_ranges(blocks_, 4, [&](std::size_t first, std::size_t last) {
            LightGatherer gatherer(scene_, rays_, samples_, eta_);
            for (std::size_t b = first; b < last; ++b)
                of_block[b] =
                    compare(gatherer, light, rays, std::size_t((double(b) + 0.5) * stride_));
        });
        PilotSums total;
        for (const PilotSums& block : of_block) total.E += block.E, total.squares += block.squares;
        return total;
    }

    PilotSums compare(LightGatherer& gatherer, std::size_t light, int rays,
                      std::size_t block) const {
        const std::size_t begin = block * kGatherBlock;
        const std::size_t end = std::min(samples_.size(), begin + kGatherBlock);
        Block one{}, other{};
        gatherer.add(light, rays, Sobol2d(mix_bits(2 * light + 1)), begin, end, one);
        gatherer.add(light, rays, Sobol2d(~mix_bits(2 * light + 1)), begin, end, other);
        PilotSums sums;
        const std::size_t count = end - begin;
        for (std::size_t first = 0; first < count; first += patch_) {
            const std::size_t size = std::min(patch_, count - first);
            Rgb difference;
            for (std::size_t i = first; i < first + size; ++i) {
                difference += one[i].E_t - other[i].E_t;
                sums.E += double(mean(one[i].E_t) + mean(other[i].E_t)) / double(count);
            }
            const double share = double(size) / double(count);
            for (int c = 0; c < 3; ++c) {  // in double: squares of bright light
                const double d = double(difference[c]) / double(size);
                sums.squares += d * d * share / 3;
            }
        }
        return sums;
    }

    const Scene& scene_;
    const RayScene& rays_;
    const SurfaceSamples& samples_;
    float eta_;
    std::size_t blocks_, patch_;  // in the pilot; samples of a patch
    double stride_;               // from one of its blocks to the next
};

}  // namespace

LightSampleCounts equal_light_samples(const Scene& scene, int rays) {
    LightSampleCounts counts;
    for (const Light& light : scene.lights) counts.push_back(is_delta(light) ? 1 : rays);
    return counts;
}

LightSampleCounts choose_light_samples(const Scene& scene, const RayScene& rays,
                                       const SurfaceSamples& samples, const Medium& medium,
                                       double tolerance) {
    LightSampleCounts counts = equal_light_samples(scene, 1);
    const Pilot pilot(scene, rays, samples, medium);
    std::vector<double> E(scene.groups.size());
    double sized = 0, total = 0;
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        const bool delta = is_delta(scene.lights[i]);
        E[scene.lights[i].group] += pilot.irradiance(i, delta ? 1 : kRaysForMeans);
        sized += delta ? 0 : 1;
    }
    for (std::size_t g = 0; g < E.size(); ++g) total += E[g] * double(mean(scene.groups[g].scale));
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        if (is_delta(scene.lights[i])) continue;
        const std::uint32_t group = scene.lights[i].group;
        const double scale = double(mean(scene.groups[group].scale));
        const double alone = kAlone * E[group];
        const double compared = scale > 0 ? std::min(total / scale, alone) : alone;
        // The noise of the lights adds up in squares.
        const double allowed = std::max(tolerance, 1e-4) / 3 * compared / std::sqrt(sized);
        while (counts[i] < kMostRays && pilot.noise(i, counts[i]) > allowed) counts[i] *= 2;
    }
    return counts;
}

}  // namespace tallow
