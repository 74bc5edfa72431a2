// SPDX-License-Identifier: Apache-2.0
// Pixels -> what is seen in them: camera rays and their chains of mirror reflections.
#include "render/primary_hits.h"

#include <fmt/format.h>

#include <span>

#include "common/base/errors.h"
#include "common/base/rng.h"
#include "common/optics/fresnel.h"

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

struct CameraSample {
    Ray ray;
    std::uint32_t pixel, number;
    std::uint64_t pixel_seed;
};

/// Camera rays of a tile, row by row.
class RowSampler {
public:
    RowSampler(const Camera& camera, const Tile& tile, SampleRange range)
        : has_lens_(camera.lens_radius > 0), rays_(camera), tile_(tile), range_(range) {}

    void sample(int y, std::vector<CameraSample>& row) const {
        row.clear();
        auto pixel = std::uint32_t(y - tile_.y0) * std::uint32_t(tile_.width());
        for (int x = tile_.x0; x < tile_.x1; ++x, ++pixel) {
            const std::uint64_t pixel_seed = mix_bits(std::uint64_t(y) << 32 | std::uint32_t(x));
            for (auto k = std::uint32_t(range_.first); k < std::uint32_t(range_.end); ++k) {
                // One sample sits at the pixel's centre, more are spread over its square.
                const Vec2 u =
                    range_.samples == 1 ? Vec2(0.5f) : start_sample(Start::pixel, k, pixel_seed);
                const Vec2 lens = has_lens_ ? start_sample(Start::lens, k, pixel_seed) : Vec2(0.5f);
                row.push_back({rays_(float(x) + u.x, float(y) + u.y, lens), pixel, k, pixel_seed});
            }
        }
    }

private:
    bool has_lens_;
    CameraRays rays_;
    Tile tile_;
    SampleRange range_;
};

void trace_in_packets(const RayScene& scene, std::span<const CameraSample> samples,
                      std::span<std::optional<Hit>> hits) {
    std::vector<Ray> rays;
    for (const CameraSample& sample : samples) rays.push_back(sample.ray);
    scene.intersect(rays, hits);
}

class PathTracer {
public:
    PathTracer(const Scene& scene, const RayScene& rays, PrimaryHits& result)
        : scene_(scene), rays_(rays), result_(result) {}

    /// Follows a ray that is known to hit something, or nothing.
    void follow(const CameraSample& start, std::optional<Hit> hit, Rgb throughput,
                std::uint32_t max_depth) {
        const auto& [first_ray, pixel, number, pixel_seed] = start;
        Ray ray = first_ray;
        const std::uint64_t seed = mix_bits(pixel_seed + number + 1);
        for (std::uint32_t depth = 0; depth <= max_depth; ++depth) {
            if (depth > 0) hit = rays_.intersect(ray);
            if (add_nearer_light(ray, hit ? hit->t : kInfinity, pixel, depth, throughput)) return;
            if (!hit) return;
            const Vec3 w_o = -ray.direction;
            face(*hit, w_o);
            result_.points.push_back({pixel, depth, number, mix_bits(seed + depth),
                                      mix_bits(~pixel_seed + depth), *hit, w_o, throughput});

            const Material& material = scene_.materials[scene_.objects[hit->object].material];
            throughput *= mirror_reflectance(material, glm::dot(hit->n, w_o));
            if (max_channel(throughput) < kLeastThroughput) return;
            Vec3 direction = reflect(w_o, hit->n);
            if (glm::dot(direction, hit->n_g) <= 0) direction = reflect(w_o, hit->n_g);
            ray = {rays_.offset_origin(hit->position, hit->n_g, direction),
                   glm::normalize(direction)};
        }
    }

private:
    // The nearest light before `limit`, if any; an environment is behind everything.
    bool add_nearer_light(const Ray& ray, float limit, std::uint32_t pixel, std::uint32_t depth,
                          Rgb throughput) {
        std::optional<Emission> nearest;
        for (const Light& light : scene_.lights) {
            std::optional<Emission> seen = see_light(light, ray);
            if (!seen || seen->t > limit || (nearest && nearest->t <= seen->t)) continue;
            seen->radiance *= scene_.groups[light.group].scale;
            nearest = seen;
        }
        if (!nearest) return false;
        // At equal infinite distance a hit cannot be: limit is infinite only if nothing was hit.
        result_.lights.push_back({pixel, depth, throughput * nearest->radiance});
        return true;
    }

    const Scene& scene_;
    const RayScene& rays_;
    PrimaryHits& result_;
};

}  // namespace

PrimaryHits find_primary_hits(const Scene& scene, const RayScene& rays, const Camera& camera,
                              const Tile& tile, SampleRange range, Quality quality) {
    PrimaryHits result;
    result.points.reserve(tile.pixels() * std::size_t(range.end - range.first));
    PathTracer tracer(scene, rays, result);
    const RowSampler sampler(camera, tile, range);
    const Rgb throughput(1.0f / float(range.samples));
    std::vector<CameraSample> row;
    std::vector<std::optional<Hit>> hits;
    for (int y = tile.y0; y < tile.y1; ++y) {
        sampler.sample(y, row);
        hits.resize(row.size());
        if (quality == Quality::draft)
            trace_in_packets(rays, row, hits);
        else
            for (std::size_t i = 0; i < row.size(); ++i) hits[i] = rays.intersect(row[i].ray);
        for (std::size_t i = 0; i < row.size(); ++i) {
            const int x = tile.x0 + int(row[i].pixel) % tile.width();
            const bool shows_mirrors =
                quality == Quality::full || (first_of_block(x) == x && first_of_block(y) == y);
            tracer.follow(row[i], hits[i], throughput, shows_mirrors ? kMaxMirrorDepth : 0);
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
