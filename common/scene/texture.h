// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <variant>

#include "common/base/rgb.h"
#include "common/base/vec.h"
#include "common/image/read_image.h"

namespace tallow {

/// Where on a surface a texture is looked up.
struct TexturePoint {
    Vec2 uv{0};               ///< Hit::uv
    Vec3 object_position{0};  ///< mm, in the object's own space
};

/// Two colours in squares (of uv) or cubes (of object space), two squares a period.
struct CheckerTexture {
    Rgb even, odd;
};

/// A picture, repeated, read with bilinear interpolation; v counts from the bottom.
struct ImageTexture {
    std::shared_ptr<const RgbImage> image;
};

/// A colour that varies over a surface.
struct Texture {
    enum class Coordinates { uv, object };

    std::variant<CheckerTexture, ImageTexture> kind;
    Coordinates coordinates = Coordinates::uv;
    /// Size of one period: of uv, or in mm of object space, where pictures lie in the plane z = 0.
    Vec3 period{1};
};

/// The colour at a point. Not filtered: who needs a mean over a pixel or a cell looks up often.
Rgb look_up(const Texture& texture, const TexturePoint& point);

/// A constant colour, or one times a texture.
struct SurfaceColor {
    Rgb value;
    std::shared_ptr<const Texture> texture;  ///< null for a constant

    SurfaceColor() = default;
    SurfaceColor(Rgb constant) : value(constant) {}  // NOLINT: a colour is one everywhere

    Rgb at(const TexturePoint& point) const {
        return texture ? value * look_up(*texture, point) : value;
    }
};

}  // namespace tallow
