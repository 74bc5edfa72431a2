// SPDX-License-Identifier: Apache-2.0
// Samples -> transmitted irradiance of each light group, in blocks of neighbouring samples.
#include "precompute/gather_irradiance.h"

#include <algorithm>
#include <array>

#include "common/base/check.h"
#include "common/base/parallel.h"
#include "precompute/light_gatherer.h"

namespace tallow {
namespace {

void gather_block(LightGatherer& gatherer, const Scene& scene, const LightSampleCounts& counts,
                  std::size_t begin, std::size_t end, std::vector<GroupIrradiance>& groups) {
    for (std::uint32_t group = 0; group < groups.size(); ++group) {
        std::array<Transmitted, kGatherBlock> sum{};
        for (std::size_t light = 0; light < scene.lights.size(); ++light)
            if (scene.lights[light].group == group)
                gatherer.add(light, counts[light], light_sequence(light), begin, end, sum);
        for (std::size_t i = begin; i < end; ++i) {
            const Transmitted& at = sum[i - begin];
            const float weight = mean(at.E_t);
            groups[group].E_t[i] = at.E_t;
            groups[group].w_i[i] = weight > 0 ? at.direction / weight : Vec3(0);
        }
    }
}

}  // namespace

Sobol2d light_sequence(std::size_t light) { return Sobol2d(mix_bits(light)); }

std::vector<GroupIrradiance> gather_irradiance(const Scene& scene, const RayScene& rays,
                                               const SurfaceSamples& samples, float eta,
                                               const LightSampleCounts& counts,
                                               Progress& progress) {
    std::vector<GroupIrradiance> groups(scene.groups.size());
    for (GroupIrradiance& group : groups) {
        group.E_t.resize(samples.size());
        group.w_i.resize(samples.size());
    }
    gather_irradiance_range(scene, rays, samples, eta, counts, {0, samples.size()}, groups,
                            progress);
    return groups;
}

void gather_irradiance_range(const Scene& scene, const RayScene& rays,
                             const SurfaceSamples& samples, float eta,
                             const LightSampleCounts& counts, SampleSpan span,
                             std::vector<GroupIrradiance>& groups, Progress& progress) {
    TALLOW_CHECK(counts.size() == scene.lights.size(), "{} counts, {} lights", counts.size(),
                 scene.lights.size());
    TALLOW_CHECK(span.begin % kGatherBlock == 0 &&
                     (span.end % kGatherBlock == 0 || span.end == samples.size()),
                 "samples {} to {} are not whole blocks", span.begin, span.end);
    const auto start = [&](std::size_t block) {
        return std::min(span.end, span.begin + block * kGatherBlock);
    };
    const std::size_t blocks = (span.end - span.begin + kGatherBlock - 1) / kGatherBlock;
    parallel_ranges(blocks, 4, [&](std::size_t begin, std::size_t end) {
        LightGatherer gatherer(scene, rays, samples, eta);
        for (std::size_t block = begin; block < end; ++block)
            gather_block(gatherer, scene, counts, start(block), start(block + 1), groups);
        progress.add(start(end) - start(begin));
    });
}

}  // namespace tallow
