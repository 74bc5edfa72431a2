// SPDX-License-Identifier: Apache-2.0
#include "common/scene/texture.h"

#include <cmath>

#include "common/base/overloaded.h"
#include "common/scene/scene.h"

namespace tallow {
namespace {

/// By how much of a square its borders are moved. Chosen: far above the rounding of positions, so
/// that a surface that lies in a border, such as a floor at y = 0, is of one colour, and invisible.
constexpr double kBorderShift = 1e-3;

Rgb look_up(const CheckerTexture& checker, DVec3 p) {
    const DVec3 cell = glm::floor(2.0 * p + kBorderShift);
    const bool odd = std::fmod(std::abs(cell.x + cell.y + cell.z), 2.0) != 0;
    return odd ? checker.odd : checker.even;
}

int wrapped(int i, int n) { return ((i % n) + n) % n; }

/// Exact at both ends, and for a = b everywhere.
Rgb mix(Rgb a, Rgb b, double t) { return a + float(t) * (b - a); }

Rgb look_up(const ImageTexture& texture, DVec3 p) {
    const RgbImage& image = *texture.image;
    const double x = (p.x - std::floor(p.x)) * image.width - 0.5;
    const double y = (1 - (p.y - std::floor(p.y))) * image.height - 0.5;
    const int x0 = int(std::floor(x)), y0 = int(std::floor(y));
    const auto pixel = [&](int i, int j) {
        return image.at(wrapped(i, image.width), wrapped(j, image.height));
    };
    return mix(mix(pixel(x0, y0), pixel(x0 + 1, y0), x - x0),
               mix(pixel(x0, y0 + 1), pixel(x0 + 1, y0 + 1), x - x0), y - y0);
}

}  // namespace

Rgb look_up(const Texture& texture, const TexturePoint& point) {
    // In double: large coordinates over small periods stay finite and keep their fractions.
    const DVec3 p = texture.coordinates == Texture::Coordinates::uv ? DVec3(Vec3(point.uv, 0))
                                                                    : DVec3(point.object_position);
    return std::visit([&](const auto& kind) { return look_up(kind, p / DVec3(texture.period)); },
                      texture.kind);
}

TexturePoint texture_point(const Scene& scene, const Hit& hit) {
    const Affine& to_world = scene.objects[hit.object].transform;
    return {hit.uv, glm::inverse(to_world.linear) * (hit.position - to_world.translation)};
}

Rgb texture_value(const Scene& scene, const Hit& hit) {
    const Texture* texture = texture_of(scene.materials[scene.objects[hit.object].material]);
    return texture ? look_up(*texture, texture_point(scene, hit)) : Rgb(1);
}

Rgb surface_tint(const Scene& scene, const SurfaceColor& albedo, const Hit& hit) {
    const Rgb color = albedo.texture ? albedo.at(texture_point(scene, hit)) : albedo.value;
    return map(color, [](float a) { return std::sqrt(a); });
}

const Texture* texture_of(const Material& material) {
    return std::visit(Overloaded{
                          [](const SubsurfaceMaterial& m) { return m.albedo.texture.get(); },
                          [](const DiffuseMaterial& m) { return m.reflectance.texture.get(); },
                          [](const PlasticMaterial& m) { return m.reflectance.texture.get(); },
                          [](const MirrorMaterial&) -> const Texture* { return nullptr; },
                      },
                      material.kind);
}

}  // namespace tallow
