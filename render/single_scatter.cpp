// SPDX-License-Identifier: Apache-2.0
// Single scattering by marching the refracted eye ray. From each depth light is followed either
// along straight shadow rays through the surface with a corrected length inside, or along all paths
// that are refracted at the surface.
#include "render/single_scatter.h"

#include <cmath>

#include "common/base/rng.h"
#include "common/optics/fresnel.h"
#include "common/optics/phase.h"

namespace tallow {
namespace {

Rgb exp(Rgb x) {
    return map(x, [](float v) { return std::exp(v); });
}

/// Depths along a ray of length s_max with density proportional to the mean over channels of
/// sigma e^(-sigma s) / (1 - e^(-sigma s_max)).
class DepthSampler {
public:
    DepthSampler(Rgb sigma, float s_max) : sigma_(sigma), s_max_(s_max) {
        for (int c = 0; c < 3; ++c) reach_[c] = -std::expm1(-sigma[c] * s_max);
    }

    float density(float s) const {
        float sum = 0;
        for (int c = 0; c < 3; ++c) sum += sigma_[c] * std::exp(-sigma_[c] * s) / reach_[c];
        return sum / 3;
    }

    /// Inverse of the cumulative distribution, by Newton's method inside a shrinking bracket.
    float depth(float u) const {
        float low = 0, high = std::min(s_max_, 100 / min_channel(sigma_));
        float s = std::min(high, -std::log1p(-u) / max_channel(sigma_));
        for (int i = 0; i < 40; ++i) {
            const float error = cumulative(s) - u;
            (error > 0 ? high : low) = s;
            float next = s - error / density(s);
            if (!(next > low && next < high)) next = 0.5f * (low + high);
            if (std::abs(next - s) <= 1e-5f * s) return next;
            s = next;
        }
        return s;
    }

private:
    float cumulative(float s) const {
        float sum = 0;
        for (int c = 0; c < 3; ++c) sum += -std::expm1(-sigma_[c] * s) / reach_[c];
        return sum / 3;
    }

    Rgb sigma_;
    Rgb reach_;
    float s_max_;
};

class SingleScatter {
public:
    SingleScatter(const Scene& scene, const RayScene& rays, const Surface& surface,
                  const RefractedConnections* exact, const SurfaceColor& albedo,
                  const Medium& medium, const Hit& hit, Vec3 w_inside)
        : scene_(scene),
          rays_(rays),
          surface_(surface),
          exact_(exact),
          albedo_(albedo),
          medium_(medium),
          sigma_t_(medium.sigma_t()),
          object_(hit.object),
          w_inside_(w_inside) {}

    /// Radiance scattered at x from light number `light` into the direction back to the eye,
    /// without sigma_s: integral of p L F_t cos_i / cos_i' e^(-sigma_t s_i').
    Rgb in_scattered(Vec3 x, std::size_t light, Vec2 u) const {
        const Rgb scale = scene_.groups[scene_.lights[light].group].scale;
        return scale * (exact_ != nullptr ? along_refracted_paths(x, scene_.lights[light], u)
                                          : along_straight_line(x, scene_.lights[light], u));
    }

private:
    Rgb along_straight_line(Vec3 x, const Light& light, Vec2 u) const {
        const auto sample = sample_light(light, x, std::nullopt, u);
        if (!sample) return {};
        const auto exit = rays_.intersect_object({x, sample->w_i}, object_, sample->distance);
        if (!exit || !admits_light(exit->position)) return {};
        const float cos_g = glm::dot(sample->w_i, exit->n_g);
        if (cos_g <= 0) return {};  // grazed from outside by rounding
        const float cos_n = glm::dot(sample->w_i, exit->n);
        const Vec3 n = cos_n > 0 ? exit->n : exit->n_g;
        const float cos_i = cos_n > 0 ? cos_n : cos_g;
        const auto w_refracted = refract(sample->w_i, n, medium_.eta);
        if (!w_refracted) return {};
        const ShadowRay outside{rays_.offset_origin(exit->position, exit->n_g, sample->w_i),
                                sample->w_i, sample->distance - exit->t};
        if (rays_.occluded(outside)) return {};

        const float ratio = cos_i / refracted_cosine(medium_.eta, cos_i);
        const float phase = henyey_greenstein(medium_.g, -glm::dot(*w_refracted, w_inside_));
        const float transmitted = fresnel_transmittance(medium_.eta, cos_i);
        return phase * transmitted * ratio * sample->radiance * exp(-exit->t * ratio * sigma_t_) *
               surface_tint(scene_, albedo_, *exit);
    }

    Rgb along_refracted_paths(Vec3 x, const Light& light, Vec2 u) const {
        const LightPoint y = sample_light_point(light, u);
        Rgb sum;
        for (const RefractedPath& path : exact_->find(x, y)) {
            const Rgb intensity = intensity_towards(light, y, -path.w_i, path.outside);
            if (max_channel(intensity) == 0 || !std::isfinite(path.spread) || blocked(x, path))
                continue;
            const float phase = henyey_greenstein(medium_.g, -glm::dot(path.w_inside, w_inside_));
            const float cos_i = std::min(1.0f, glm::dot(path.w_i, path.n));
            const float transmitted = fresnel_transmittance(medium_.eta, cos_i);
            sum += phase * transmitted * path.spread * intensity * exp(-path.inside * sigma_t_) *
                   tint_at(path.position, path.n_g);
        }
        return sum;
    }

    // Whether the body ends before x_i on the way from x, or something stands before the light.
    bool blocked(Vec3 x, const RefractedPath& path) const {
        constexpr float kShort = 1 - 1e-4f;  // stops before x_i itself
        if (rays_.intersect_object({x, -path.w_inside}, object_, kShort * path.inside)) return true;
        return rays_.occluded(
            {rays_.offset_origin(path.position, path.n_g, path.w_i), path.w_i, path.outside});
    }

    // Where only the place is known: the texture coordinates belong to a hit.
    Rgb tint_at(Vec3 position, Vec3 n_g) const {
        if (!albedo_.texture) return surface_tint(scene_, albedo_, {});
        const Vec3 above = rays_.offset_origin(position, n_g, n_g);
        const auto hit =
            rays_.intersect_object({above, -n_g}, object_, 2 * glm::length(above - position));
        return hit ? surface_tint(scene_, albedo_, *hit) : Rgb(0);  // off an edge by rounding
    }

    // A half-space takes light only through its opening.
    bool admits_light(Vec3 x) const {
        const auto* plane = std::get_if<PlaneSurface>(&surface_);
        return plane == nullptr || length2(x - plane->point) <= plane->radius * plane->radius;
    }

    const Scene& scene_;
    const RayScene& rays_;
    const Surface& surface_;
    const RefractedConnections* exact_;
    const SurfaceColor& albedo_;
    const Medium& medium_;
    Rgb sigma_t_;
    std::uint32_t object_;
    Vec3 w_inside_;
};

}  // namespace

Rgb single_scatter(const Scene& scene, const RayScene& rays, const Surface& surface,
                   const Medium& medium, const Hit& hit, Vec3 w_o, int steps, std::uint64_t seed,
                   const RefractedConnections* exact, const SurfaceColor& albedo) {
    const float cos_o = glm::dot(w_o, hit.n);
    const auto w_inside = refract(w_o, hit.n, medium.eta);
    if (!w_inside || max_channel(medium.sigma_s_prime) == 0) return {};
    const Vec3 start = rays.offset_origin(hit.position, hit.n_g, *w_inside);
    const auto far_side = rays.intersect_object({start, *w_inside}, hit.object);
    const float s_max = far_side ? glm::length(far_side->position - hit.position) : kInfinity;
    if (!(s_max > 0)) return {};

    const Rgb sigma_t = medium.sigma_t();
    const DepthSampler depths(sigma_t, s_max);
    const SingleScatter scatter(scene, rays, surface, exact, albedo, medium, hit, *w_inside);
    Rgb sum;  // depths count from the surface itself: the offset only keeps the march off it
    for (int k = 0; k < steps; ++k) {
        const float jitter = to_unit_float(random_bits(seed, 0, std::uint64_t(k)));
        const float s = depths.depth((float(k) + jitter) / float(steps));
        Rgb from_lights;
        for (std::size_t light = 0; light < scene.lights.size(); ++light)
            from_lights += scatter.in_scattered(hit.position + s * *w_inside, light,
                                                sobol_2d(std::uint32_t(k), seed + light));
        sum += exp(-s * sigma_t) / depths.density(s) * from_lights;
    }
    const float exit = fresnel_transmittance(medium.eta, cos_o) / (medium.eta * medium.eta);
    return exit / float(steps) * medium.sigma_s() * surface_tint(scene, albedo, hit) * sum;
}

}  // namespace tallow
