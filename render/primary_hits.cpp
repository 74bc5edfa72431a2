// SPDX-License-Identifier: Apache-2.0
// Pixels -> what is seen in them: camera rays, their chains of mirror reflections, and what they
// become by passing bodies.
#include "render/primary_hits.h"

#include <fmt/format.h>

#include <cmath>
#include <span>

#include "common/base/errors.h"
#include "common/base/rng.h"
#include "common/optics/fresnel.h"
#include "render/eye_path.h"

namespace tallow {
namespace {

// A chain ends when it carries less than this. Chosen: below the last bit of an 8-bit picture even
// in the mirror image of a light a thousand times brighter than white.
constexpr float kLeastThroughput = 1e-6f;

Rgb mirror_reflectance(const Material& material, float cos_o) {
    if (const auto* mirror = std::get_if<MirrorMaterial>(&material.kind))
        return mirror->reflectance;
    if (const auto* plastic = std::get_if<PlasticMaterial>(&material.kind))
        return Rgb(fresnel_reflectance(plastic->eta, cos_o));
    if (const auto* body = std::get_if<SubsurfaceMaterial>(&material.kind))
        return Rgb(fresnel_reflectance(body->medium.eta, cos_o));
    return Rgb(0);
}

// Turns the normals to the side of w_o. Opaque surfaces have two sides. On bodies w_o is outside,
// but an interpolated normal can still point away from it: then the geometric one is used.
void face(Hit& hit, Vec3 w_o) {
    if (glm::dot(hit.n_g, w_o) < 0) hit.n_g = -hit.n_g, hit.n = -hit.n;
    if (glm::dot(hit.n, w_o) <= 0) hit.n = hit.n_g;
}

// A camera ray starts at a place in its pixel and at one on the lens. Both are sequences in an
// order of their own: what is drawn later by the ray's number, on lamps and for paths, must not be
// tied to them.
enum class Start : std::uint64_t { pixel = 0x9fb21c651e98df25, lens = 0x2545f4914f6cdd1d };

Vec2 start_sample(Start start, std::uint32_t number, std::uint64_t pixel_seed) {
    const std::uint64_t seed = mix_bits(pixel_seed ^ std::uint64_t(start));
    return sobol_2d(shuffled_index(number, seed), seed);
}

// The centre of the lens, and points around its rim.
std::span<const Vec2> lens_points(const Camera& camera) {
    static constexpr Vec2 kPoints[] = {Vec2(0.5f), {0, 0},    {0.5f, 0}, {1, 0},   {1, 0.5f},
                                       {1, 1},     {0.5f, 1}, {0, 1},    {0, 0.5f}};
    return std::span(kPoints).first(camera.lens_radius > 0 ? std::size(kPoints) : 1);
}

/// A ray on its way through the scene.
struct Way {
    Ray ray;
    Rgb throughput;
    std::uint32_t depth = 0;  // number of surfaces met
    bool through = false;     // as in ShadingPoint
};

class PathTracer {
public:
    PathTracer(const Scene& scene, const RayScene& rays, const std::vector<bool>& clear,
               PrimaryHits& result)
        : scene_(scene), rays_(rays), clear_(clear), result_(result) {}

    void follow(const Ray& ray, std::uint32_t pixel, std::uint32_t number, std::uint64_t pixel_seed,
                Rgb throughput) {
        ways_.assign(1, {ray, throughput});
        for (std::size_t i = 0; i < ways_.size(); ++i) {
            // Each with random decisions of its own.
            const std::uint64_t own = pixel_seed + (std::uint64_t(i) << 32);
            follow(Way(ways_[i]), pixel, number, own);
        }
    }

private:
    void follow(Way way, std::uint32_t pixel, std::uint32_t number, std::uint64_t pixel_seed) {
        const std::uint64_t seed = mix_bits(pixel_seed + number + 1);
        for (; way.depth <= kMaxMirrorDepth; ++way.depth) {
            std::optional<Hit> hit = rays_.intersect(way.ray);
            if (add_nearer_light(way, hit ? hit->t : kInfinity, pixel)) return;
            if (!hit) return;
            const Vec3 w_o = -way.ray.direction;
            face(*hit, w_o);
            result_.points.push_back({pixel, way.depth, way.through, number,
                                      mix_bits(seed + way.depth), mix_bits(~pixel_seed + way.depth),
                                      *hit, w_o, way.throughput});

            const Material& material = scene_.materials[scene_.objects[hit->object].material];
            if (!clear_.empty() && clear_[hit->object])
                pass(std::get<SubsurfaceMaterial>(material.kind), way, *hit, w_o);
            way.throughput *= mirror_reflectance(material, glm::dot(hit->n, w_o));
            if (max_channel(way.throughput) < kLeastThroughput) return;
            Vec3 direction = reflect(w_o, hit->n);
            if (glm::dot(direction, hit->n_g) <= 0) direction = reflect(w_o, hit->n_g);
            way.ray = {rays_.offset_origin(hit->position, hit->n_g, direction),
                       glm::normalize(direction)};
        }
    }

    // Into the body, over reflections inside, and out wherever light leaves.
    void pass(const SubsurfaceMaterial& body, const Way& way, const Hit& hit, Vec3 w_o) {
        const float eta = body.medium.eta;
        const Rgb sigma_t = body.medium.sigma_t();
        auto w = refract(w_o, hit.n, eta);
        if (!w || glm::dot(*w, hit.n_g) >= 0) return;
        Rgb carried = way.throughput * fresnel_transmittance(eta, glm::dot(w_o, hit.n)) *
                      surface_tint(scene_, body.albedo, hit);
        Vec3 from = hit.position, n_g = hit.n_g, direction = *w;
        for (int k = 0; k <= kMaxInnerReflections; ++k) {
            const auto end = rays_.intersect_object(
                {rays_.offset_origin(from, n_g, direction), direction}, hit.object);
            if (!end) return;
            const float length = glm::length(end->position - from);
            for (int c = 0; c < 3; ++c) carried[c] *= std::exp(-sigma_t[c] * length);
            if (max_channel(carried) < kLeastThroughput) return;
            const auto reflection = reflect_inside(direction, *end, eta);
            if (!reflection) return;
            leave(
                way, *end, direction, eta,
                carried * (1 - reflection->reflectance) * surface_tint(scene_, body.albedo, *end));
            carried *= reflection->reflectance;
            from = end->position, n_g = end->n_g, direction = reflection->direction;
        }
    }

    void leave(const Way& way, const Hit& end, Vec3 direction, float eta, Rgb throughput) {
        if (max_channel(throughput) < kLeastThroughput || ways_.size() >= kMaxRays) return;
        const Vec3 n = glm::dot(direction, end.n) > 0 ? end.n : end.n_g;
        const auto w = refract(-direction, -n, 1 / eta);
        if (!w || glm::dot(*w, end.n_g) <= 0) return;
        ways_.push_back({{rays_.offset_origin(end.position, end.n_g, *w), *w},
                         throughput,
                         way.depth + 1,
                         way.through || way.depth == 0});
    }

    // The nearest light before `limit`, if any; an environment is behind everything.
    bool add_nearer_light(const Way& way, float limit, std::uint32_t pixel) {
        std::optional<Emission> nearest;
        for (const Light& light : scene_.lights) {
            std::optional<Emission> seen = see_light(light, way.ray);
            if (!seen || seen->t > limit || (nearest && nearest->t <= seen->t)) continue;
            seen->radiance *= scene_.groups[light.group].scale;
            nearest = seen;
        }
        if (!nearest) return false;
        // At equal infinite distance a hit cannot be: limit is infinite only if nothing was hit.
        result_.lights.push_back(
            {pixel, way.depth, way.through, way.throughput * nearest->radiance});
        return true;
    }

    const Scene& scene_;
    const RayScene& rays_;
    const std::vector<bool>& clear_;  // [object]
    PrimaryHits& result_;
    std::vector<Way> ways_;  // of one camera ray; the first is itself
};

}  // namespace

PrimaryHits find_primary_hits(const Scene& scene, const RayScene& rays, const Camera& camera,
                              const Tile& tile, SampleRange range, const std::vector<bool>& clear) {
    PrimaryHits result;
    result.points.reserve(tile.pixels() * std::size_t(range.end - range.first));
    PathTracer tracer(scene, rays, clear, result);
    std::uint32_t pixel = 0;
    for (int y = tile.y0; y < tile.y1; ++y)
        for (int x = tile.x0; x < tile.x1; ++x, ++pixel) {
            const std::uint64_t pixel_seed = mix_bits(std::uint64_t(y) << 32 | std::uint32_t(x));
            for (int k = range.first; k < range.end; ++k) {
                // One sample sits at the pixel's centre, more are spread over its square.
                const Vec2 u = range.samples == 1
                                   ? Vec2(0.5f)
                                   : start_sample(Start::pixel, std::uint32_t(k), pixel_seed);
                const Vec2 lens = camera.lens_radius > 0
                                      ? start_sample(Start::lens, std::uint32_t(k), pixel_seed)
                                      : Vec2(0.5f);
                const Ray ray = camera_ray(camera, float(x) + u.x, float(y) + u.y, lens);
                tracer.follow(ray, pixel, std::uint32_t(k), pixel_seed,
                              Rgb(1.0f / float(range.samples)));
            }
        }
    return result;
}

void require_camera_outside(const Scene& scene, const RayScene& rays, const Camera& camera) {
    for (std::uint32_t object = 0; object < scene.objects.size(); ++object) {
        if (subsurface(scene, object) == nullptr) continue;
        for (const Vec2 lens : lens_points(camera)) {
            const Ray view =
                camera_ray(camera, 0.5f * float(camera.width), 0.5f * float(camera.height), lens);
            const auto hit = rays.intersect_object(view, object);
            if (!hit || glm::dot(hit->n_g, view.direction) <= 0) continue;
            throw InputError(
                fmt::format("{}: camera '{}' is inside this translucent body{}; move it outside",
                            scene.objects[object].where, camera.name,
                            camera.frame > 0 ? fmt::format(" in frame {}", camera.frame) : ""));
        }
    }
}

}  // namespace tallow
