// SPDX-License-Identifier: Apache-2.0
#include "common/scene/texture.h"

#include <cmath>

#include "common/base/overloaded.h"
#include "common/scene/scene.h"

namespace tallow {
namespace {

Rgb look_up(const CheckerTexture& checker, Vec3 p) {
    const Vec3 cell = glm::floor(2.0f * p);
    const bool odd = std::fmod(std::abs(cell.x + cell.y + cell.z), 2.0f) != 0;
    return odd ? checker.odd : checker.even;
}

int wrapped(int i, int n) { return ((i % n) + n) % n; }

Rgb look_up(const ImageTexture& texture, Vec3 p) {
    const RgbImage& image = *texture.image;
    // Fractions first: far from the origin no float is left for the pixels.
    const float x = (p.x - std::floor(p.x)) * float(image.width) - 0.5f;
    const float y = (1 - (p.y - std::floor(p.y))) * float(image.height) - 0.5f;
    const int x0 = int(std::floor(x)), y0 = int(std::floor(y));
    const float fx = x - float(x0), fy = y - float(y0);
    const auto pixel = [&](int i, int j) {
        return image.at(wrapped(i, image.width), wrapped(j, image.height));
    };
    return (1 - fy) * ((1 - fx) * pixel(x0, y0) + fx * pixel(x0 + 1, y0)) +
           fy * ((1 - fx) * pixel(x0, y0 + 1) + fx * pixel(x0 + 1, y0 + 1));
}

}  // namespace

Rgb look_up(const Texture& texture, const TexturePoint& point) {
    const Vec3 p =
        texture.coordinates == Texture::Coordinates::uv ? Vec3(point.uv, 0) : point.object_position;
    return std::visit([&](const auto& kind) { return look_up(kind, p / texture.period); },
                      texture.kind);
}

TexturePoint texture_point(const Scene& scene, const Hit& hit) {
    const Affine& to_world = scene.objects[hit.object].transform;
    return {hit.uv, glm::inverse(to_world.linear) * (hit.position - to_world.translation)};
}

}  // namespace tallow
