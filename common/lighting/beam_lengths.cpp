// SPDX-License-Identifier: Apache-2.0
#include "common/lighting/beam_lengths.h"

#include <optional>

#include "common/base/parallel.h"

namespace tallow {
namespace {

constexpr std::size_t kBlock = 256;  // samples whose rays are traced together

}  // namespace

std::vector<float> beam_lengths(const RayScene& rays, std::uint32_t object, const LitSamples& lit,
                                float longest) {
    if (longest == 0) return {};
    std::vector<float> result(lit.position.size());
    parallel_ranges(result.size(), kBlock, [&](std::size_t begin, std::size_t end) {
        std::vector<ShadowRay> beams;
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3 n = lit.normal[i];
            const float length = glm::length(lit.w_i[i]);
            const Vec3 w = length > 0 ? lit.w_i[i] / length : -n;
            beams.push_back({rays.offset_origin(lit.position[i], n, w), w, longest});
        }
        std::vector<std::optional<Hit>> hits(beams.size());
        rays.intersect_object(beams, object, hits);
        for (std::size_t i = begin; i < end; ++i)
            result[i] = hits[i - begin] ? hits[i - begin]->t : longest;
    });
    return result;
}

}  // namespace tallow
