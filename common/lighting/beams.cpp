// SPDX-License-Identifier: Apache-2.0
#include "common/lighting/beams.h"

#include <algorithm>
#include <optional>

#include "common/base/parallel.h"
#include "common/optics/fresnel.h"

namespace tallow {
namespace {

constexpr std::size_t kBlock = 256;  // samples whose rays are traced together
constexpr int kMostEntries = 4;      // of one beam, before it is taken to have left

Vec3 direction_at(const LitSamples& lit, std::size_t i) {
    const float length = glm::length(lit.w_i[i]);
    return length > 0 ? lit.w_i[i] / length : -lit.normal[i];
}

// A sample is the centroid of its cell: in hollows it lies above the surface, and its beam enters
// before it can leave. Where it leaves, or nothing within `longest` from the sample.
std::optional<Hit> find_exit(const RayScene& rays, std::uint32_t object, const ShadowRay& way,
                             std::optional<Hit> hit, float longest) {
    for (int entry = 0; entry < kMostEntries && hit && glm::dot(way.direction, hit->n_g) < 0;
         ++entry) {
        const float before = hit->t;
        const Vec3 inside = rays.offset_origin(hit->position, hit->n_g, way.direction);
        if (before >= longest) return std::nullopt;
        hit = rays.intersect_object({inside, way.direction}, object, longest - before);
        if (hit) hit->t += before;
    }
    return hit;
}

Beam beam_to(const Hit& hit, Vec3 w, float eta) {
    const float cosine = std::min(1.0f, std::abs(glm::dot(w, hit.n_g)));
    return {hit.t, fresnel_reflectance(1 / eta, cosine), -reflect(w, hit.n_g)};
}

}  // namespace

std::vector<Beam> follow_beams(const RayScene& rays, std::uint32_t object, const LitSamples& lit,
                               float eta, float longest) {
    if (longest == 0) return {};
    std::vector<Beam> result(lit.position.size());
    parallel_ranges(result.size(), kBlock, [&](std::size_t begin, std::size_t end) {
        std::vector<ShadowRay> ways;
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3 w = direction_at(lit, i);
            ways.push_back({rays.offset_origin(lit.position[i], lit.normal[i], w), w, longest});
        }
        std::vector<std::optional<Hit>> hits(ways.size());
        rays.intersect_object(ways, object, hits);
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3 w = ways[i - begin].direction;
            const auto hit = find_exit(rays, object, ways[i - begin], hits[i - begin], longest);
            result[i] = hit ? beam_to(*hit, w, eta) : Beam{longest, 0, w};
        }
    });
    return result;
}

}  // namespace tallow
