// SPDX-License-Identifier: Apache-2.0
// Camera rays of a tile -> its pixels, one term of the shading sum after the other.
#include "render/tile_renderer.h"

#include <algorithm>

#include "render/march_steps.h"
#include "render/single_scatter.h"

namespace tallow {
namespace {

// Paths of indirect light from opaque surfaces: so many a pixel, shared by its camera rays, but at
// least so many each.
constexpr int kPathsPerPixel = 64, kLeastPaths = 1;

// The layer of what is not the first surface of a camera ray.
Rgb Pixel::*layer_behind(bool through) { return through ? &Pixel::transmitted : &Pixel::specular; }

}  // namespace

void TileRenderer::find_hits(SampleRange range) {
    hits_ = find_primary_hits(view_.world.scene(), view_.world.rays(), view_.camera, tile_, range,
                              view_.world.clear(), view_.quality);
    describe_surfaces();
    add_seen_lights();
}

std::size_t TileRenderer::count_points(std::uint32_t object) const {
    return std::size_t(
        std::count_if(hits_.points.begin(), hits_.points.end(),
                      [&](const ShadingPoint& point) { return point.hit.object == object; }));
}

void TileRenderer::list_points(std::uint32_t object, ExitancePoint* points) const {
    const PreparedBody& body = *view_.world.body(object);
    for (const ShadingPoint& point : hits_.points) {
        if (point.hit.object != object) continue;
        *points = {point.hit.position, point.hit.n, point.w_o};
        if (body.exitance.needs_irradiance())
            points->E_direct =
                view_.world.reflected().entering(point, *body.material, shadow_rays());
        ++points;
    }
}

void TileRenderer::add_multiple_scattering(std::uint32_t object, const Exitance& exitance,
                                           std::size_t next) {
    const PreparedBody& body = *view_.world.body(object);
    const float weight = 1.0f / float(view_.samples);
    for (const ShadingPoint& point : hits_.points) {
        if (point.hit.object != object) continue;
        const float T = exit_factor(body.factors, glm::dot(point.hit.n, point.w_o));
        const Rgb tint = surface_tint(view_.world.scene(), body.material->albedo, point.hit);
        add(point, &Pixel::multiple, kInvPi * T * tint * exitance.M[next]);
        Pixel& pixel = pixels_[point.pixel];
        if (point.depth == 0) {
            pixel.exitance += weight * tint * exitance.M[next];
            if (!exitance.bound.empty()) pixel.error_bound += weight * tint * exitance.bound[next];
        }
        pixel.evaluations += exitance.evaluations[next];
        ++next;
    }
}

void TileRenderer::add_single_scattering(std::uint32_t object) {
    const PreparedBody& body = *view_.world.body(object);
    const MarchSteps steps = share_steps(body.march_steps, view_.samples);
    std::vector<const ShadingPoint*> points;
    std::vector<EyePoint> eyes;
    for (const ShadingPoint& point : hits_.points) {
        if (point.hit.object != object) continue;
        points.push_back(&point);
        eyes.push_back(
            {point.hit, point.w_o, point.pixel_seed, point.ray * std::uint32_t(steps.of_point)});
    }
    std::vector<Rgb> L(points.size());
    single_scatter({view_.world.lit(), view_.world.rays(), view_.world.surface(object), object,
                    body.material->medium, body.connections ? &*body.connections : nullptr,
                    body.material->albedo, body.inner ? &*body.inner : nullptr, body.lamps},
                   eyes, steps, L);
    for (std::size_t i = 0; i < points.size(); ++i) add(*points[i], &Pixel::single, L[i]);
}

void TileRenderer::add_reflected_light() {
    struct Shared {
        std::optional<std::uint32_t> object;
        Rgb radiance;
    };
    std::vector<Shared> blocks(view_.quality == Quality::draft ? tile_.pixels() : 0);
    for (const ShadingPoint& point : hits_.points) {
        if (view_.world.body(point.hit.object) != nullptr) continue;
        const auto direct = [&] { return view_.world.reflected().direct(point, shadow_rays()); };
        if (view_.quality == Quality::full || point.depth > 0) {
            add(point, &Pixel::diffuse, direct());
            continue;
        }
        Shared& shared = blocks[block_of(point.pixel)];
        if (shared.object != point.hit.object) shared = {point.hit.object, direct()};
        add(point, &Pixel::diffuse, shared.radiance);
    }
}

// The first pixel of a draft's block.
std::size_t TileRenderer::block_of(std::size_t pixel) const {
    const int width = tile_.width(), x = int(pixel) % width, y = int(pixel) / width;
    return std::size_t(first_of_block(y)) * std::size_t(width) + std::size_t(first_of_block(x));
}

void TileRenderer::share_mirrors() {
    std::vector<std::optional<std::uint32_t>> seen(tile_.pixels());  // object
    for (const ShadingPoint& point : hits_.points)
        if (point.depth == 0) seen[point.pixel] = point.hit.object;
    for (std::size_t pixel = 0; pixel < seen.size(); ++pixel)
        if (seen[pixel] && seen[pixel] == seen[block_of(pixel)])
            pixels_[pixel].specular = pixels_[block_of(pixel)].specular;
}

void TileRenderer::add_indirect_light() {
    const int paths = std::max(kLeastPaths, kPathsPerPixel / view_.samples);
    vertices_.clear();
    for (std::size_t i = 0; i < hits_.points.size(); ++i)
        add(hits_.points[i], &Pixel::diffuse,
            view_.world.reflected().indirect(hits_.points[i], paths, std::uint32_t(i), vertices_));
}

void TileRenderer::add_light_of_body(std::uint32_t object, const Exitance& exitance,
                                     std::size_t next) {
    for (const BodyVertex& vertex : vertices_)
        if (vertex.object == object)
            add(hits_.points[vertex.receiver], &Pixel::diffuse, vertex.factor * exitance.M[next++]);
}

// To each area light.
int TileRenderer::shadow_rays() const {
    if (view_.quality == Quality::draft) return 1;
    return std::max(1, shadow_rays_of_pixel(view_.world.accuracy().tolerance) / view_.samples);
}

// Adds radiance seen at a point to its layer; what mirrors show belongs to their specular, what is
// seen through bodies to transmitted.
void TileRenderer::add(const ShadingPoint& point, Rgb Pixel::*layer, Rgb radiance) {
    Pixel& pixel = pixels_[point.pixel];
    const Rgb light = point.throughput * radiance;
    pixel.*(point.depth == 0 ? layer : layer_behind(point.through)) += light;
    if (layer == &Pixel::multiple || layer == &Pixel::single) pixel.scattered += light;
}

void TileRenderer::describe_surfaces() {
    const Scene& scene = view_.world.scene();
    const float weight = 1.0f / float(view_.samples);
    for (const ShadingPoint& point : hits_.points) {
        if (point.depth > 0) continue;
        Pixel& pixel = pixels_[point.pixel];
        pixel.coverage += weight;
        pixel.normal += weight * point.hit.n;
        pixel.position += weight * Vec3(DVec3(point.hit.position) + scene.origin);
        pixel.depth += weight * point.hit.t;
        pixel.albedo +=
            weight * texture_value(scene, point.hit) * view_.world.albedo_of(point.hit.object);
    }
}

void TileRenderer::add_seen_lights() {
    for (const SeenLight& light : hits_.lights)
        pixels_[light.pixel].*(light.depth == 0 ? &Pixel::emission : layer_behind(light.through)) +=
            light.radiance;
}

}  // namespace tallow
