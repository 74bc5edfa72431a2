// SPDX-License-Identifier: Apache-2.0
// A pilot run on some blocks of samples -> rays for each light.
#include "precompute/choose_light_samples.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "common/base/parallel.h"
#include "common/base/rng.h"
#include "precompute/light_gatherer.h"

namespace tallow {
namespace {

constexpr int kMostRays = 256;            // chosen: 256 times the noise of the tracer's own edges
constexpr std::size_t kLeastBlocks = 64;  // chosen: their mean square is known to about a fifth
constexpr std::size_t kBlocksEach = 64;   // one in so many blocks is in the pilot
constexpr int kRaysForMeans = 4;          // chosen: the mean of all blocks is then known to 1 %
constexpr double kPatchPerPath2 = 4;      // fitted, see the header
constexpr double kAlone = 10;             // chosen, see the header
constexpr std::uint64_t kPilotSeed = 1;   // any

/// What is known of one block: the irradiance, mean of two runs, and the mean square difference
/// between the runs' patches.
struct PilotBlock {
    double E = 0, square = 0;
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
        double sum = 0;
        for (const PilotBlock& block : run(light, rays)) sum += block.E;
        return sum / double(blocks_);
    }

    /// Root mean square error of a patch's mean irradiance with so many rays, and as much more as
    /// the pilot's blocks may have missed: one standard deviation of their mean.
    double noise(std::size_t light, int rays) const {
        double sum = 0, squares = 0;
        for (const PilotBlock& block : run(light, rays))
            sum += block.square, squares += block.square * block.square;
        const double n = double(blocks_), mean_square = sum / n;
        const double missed = std::max(0.0, squares / n - mean_square * mean_square) *
                              (1 - 1 / stride_) / n;  // none if all blocks were looked at
        // A difference of two runs has twice the variance of one.
        return std::sqrt((mean_square + std::sqrt(missed)) / 2);
    }

private:
    using Block = std::array<Transmitted, kGatherBlock>;

    // Any of those from one multiple of the stride to the next. Always the same one would be at the
    // same place in the Morton order's squares and get the same strata of the sequence.
    std::size_t block(std::size_t b) const {
        const double u = double(to_unit_float(random_bits(kPilotSeed, 0, b)));
        return std::size_t((double(b) + u) * stride_);
    }

    std::vector<PilotBlock> run(std::size_t light, int rays) const {
        std::vector<PilotBlock> of_block(blocks_);
        parallel_ranges(blocks_, 4, [&](std::size_t first, std::size_t last) {
            LightGatherer gatherer(scene_, rays_, samples_, eta_);
            for (std::size_t b = first; b < last; ++b)
                of_block[b] = compare(gatherer, light, rays, block(b));
        });
        return of_block;
    }

    // One run is what gather_irradiance() will do. The leading digits of its points are the same in
    // every block, so that their luck does not average out; the other run is scrambled anew for
    // each block, and its luck does.
    PilotBlock compare(LightGatherer& gatherer, std::size_t light, int rays,
                       std::size_t block) const {
        const std::size_t begin = block * kGatherBlock;
        const std::size_t end = std::min(samples_.size(), begin + kGatherBlock);
        Block one{}, other{};
        const Sobol2d fresh(mix_bits(~mix_bits(light) + block));
        gatherer.add(light, rays, light_sequence(light), begin, end, one);
        gatherer.add(light, rays, fresh, begin, end, other);
        PilotBlock result;
        const std::size_t count = end - begin;
        for (std::size_t first = 0; first < count; first += patch_) {
            const std::size_t size = std::min(patch_, count - first);
            Rgb difference;
            for (std::size_t i = first; i < first + size; ++i) {
                difference += one[i].E_t - other[i].E_t;
                result.E += double(mean(one[i].E_t) + mean(other[i].E_t)) / double(2 * count);
            }
            const double share = double(size) / double(count);
            for (int c = 0; c < 3; ++c) {  // in double: squares of bright light
                const double d = double(difference[c]) / double(size);
                result.square += d * d * share / 3;
            }
        }
        return result;
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
