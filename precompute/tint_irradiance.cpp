// SPDX-License-Identifier: Apache-2.0
// Samples of a textured body -> what their cells let in of the light on them.
#include "precompute/tint_irradiance.h"

#include <cmath>
#include <optional>

#include "common/base/parallel.h"
#include "common/base/rng.h"

namespace tallow {
namespace {

// Chosen: a texture finer than the cells leaves a quarter of its contrast as noise of a sample,
// which the sum over samples smoothes out; twice as many cost twice the rays and leave 0.7 of that.
constexpr std::uint32_t kPoints = 16;

class CellTinter {
public:
    CellTinter(const Scene& scene, const RayScene& rays, std::uint32_t object,
               const SurfaceSamples& samples)
        : scene_(scene),
          rays_(rays),
          object_(object),
          albedo_(subsurface(scene, object)->albedo),
          samples_(samples) {}

    std::optional<Rgb> mean_tint(std::size_t i) const {
        const Vec3 n = samples_.normal[i];
        const Frame frame = make_frame(n);
        const float side = std::sqrt(samples_.area[i]);
        Rgb sum;
        int count = 0;
        const auto add = [&](const std::optional<Rgb>& tint) {
            if (tint) sum += *tint, ++count;
        };
        for (std::uint32_t k = 0; k < kPoints; ++k) {
            const Vec2 u = side * (sobol_2d(k, mix_bits(i)) - 0.5f);
            add(tint_below(samples_.position[i] + u.x * frame.s + u.y * frame.t, n, side / 2));
        }
        // All may miss a sliver; the point where light is gathered is on it.
        if (count == 0) add(tint_below(samples_.ray_origin[i], n, side / 2));
        return count > 0 ? std::optional(sum / float(count)) : std::nullopt;
    }

private:
    /// Of the surface that is met first on the way from `reach` above x to as far below.
    std::optional<Rgb> tint_below(Vec3 x, Vec3 n, float reach) const {
        const auto hit = rays_.intersect_object({x + reach * n, -n}, object_, 2 * reach);
        if (!hit || glm::dot(hit->n_g, n) <= 0) return std::nullopt;
        return surface_tint(scene_, albedo_, *hit);
    }

    const Scene& scene_;
    const RayScene& rays_;
    std::uint32_t object_;
    const SurfaceColor& albedo_;
    const SurfaceSamples& samples_;
};

/// Samples without a tint get that of their neighbour in Morton order.
std::vector<Rgb> filled(const std::vector<std::optional<Rgb>>& tints) {
    std::vector<Rgb> result;
    Rgb last(0);
    for (const auto& tint : tints)
        if (tint) {
            last = *tint;
            break;
        }
    for (const auto& tint : tints) result.push_back(last = tint.value_or(last));
    return result;
}

}  // namespace

std::vector<Rgb> entry_tints(const Scene& scene, const RayScene& rays, std::uint32_t object,
                             const SurfaceSamples& samples) {
    const SurfaceColor& albedo = subsurface(scene, object)->albedo;
    if (!albedo.texture)
        return std::vector<Rgb>(samples.size(),
                                map(albedo.value, [](float a) { return std::sqrt(a); }));
    const CellTinter tinter(scene, rays, object, samples);
    std::vector<std::optional<Rgb>> tints(samples.size());
    parallel_for(samples.size(), 256, [&](std::size_t i) { tints[i] = tinter.mean_tint(i); });
    return filled(tints);
}

void tint_irradiance(const Scene& scene, const RayScene& rays, std::uint32_t object,
                     const SurfaceSamples& samples, std::span<GroupIrradiance> groups) {
    const SurfaceColor& albedo = subsurface(scene, object)->albedo;
    if (!albedo.texture && albedo.value == Rgb(1)) return;
    const std::vector<Rgb> tints = entry_tints(scene, rays, object, samples);
    for (GroupIrradiance& group : groups)
        for (std::size_t i = 0; i < tints.size(); ++i) group.E_t[i] *= tints[i];
}

}  // namespace tallow
