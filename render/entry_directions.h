// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "common/scene/light.h"

namespace tallow {

/// Draws directions from a place inside a body in which light from a lamp may enter it.
///
/// If the surface were a plane with the normal n, light from the direction w outside would come
/// from the direction d(w, n) that Snell's law gives. Normals that are found near the place stand
/// for the surface; half of the directions are those of the lamp itself bent at such a plane, half
/// lie around the middle of them with a density that falls as the inverse fourth power of the
/// angle, and so is nowhere 0:
///
///     density(d) = sum over planes of chance (p_lamp(w) eta^2 cos_d / cos_w / 2 + p_wide(d) / 2)
///
///     p_wide = m (2 + m) / (4 pi (1 - cos + m)^2),   1 - m the cosine of the lamp's rim inside
///
/// Of the environment the middle is the normal, and the rim the critical angle.
///
/// Domain   not for delta lights.
class EntryDirections {
public:
    /// `ball` is the lamp's, see bounding_ball(); `light` must outlive this.
    EntryDirections(const Light& light, const std::optional<LightBall>& ball, Vec3 x, float eta);

    /// A normal that bends light from this lamp to the place, `likely` in proportion to what it is
    /// expected to bring. At most kMost.
    static constexpr std::size_t kMost = 4;
    void add(Vec3 n, float likely);
    bool empty() const { return count_ == 0; }

    /// Unit, away from the place. Nothing where the plane turns from the light that was drawn.
    std::optional<Vec3> draw(Vec2 u) const;
    float density(Vec3 direction) const;  ///< over solid angle

private:
    struct Plane {
        Vec3 n;
        float likely;
        Vec3 axis;  // of p_wide
        float m;
    };

    const Light& light_;
    bool finite_;
    Vec3 x_;
    float eta_;
    Vec3 to_lamp_{0};  // unit, towards its middle
    float rim_ = 0;    // sine of the angle between middle and rim, outside
    std::array<Plane, kMost> planes_;
    std::size_t count_ = 0;
    float likely_ = 0;  // sum over planes
};

/// Refraction of light that leaves a body in unit direction `direction`: what refract() is to light
/// that enters. Nothing at total internal reflection.
std::optional<Vec3> refract_outwards(Vec3 direction, Vec3 n, float eta);

}  // namespace tallow
