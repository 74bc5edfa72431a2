// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "common/base/vec.h"

namespace tallow::reference {

/// Where a ray goes through a body's surface.
struct Crossing {
    float t;              ///< distance along the ray, mm
    Vec3 position;        ///< mm
    Vec3 normal;          ///< unit, outward
    std::uint32_t facet;  ///< triangle; 0 of a sphere
};

/// A path from a point x inside a body to the camera that is refracted once, by that body.
struct CameraLink {
    DVec3 position;       ///< p on the surface, mm
    DVec3 w;              ///< unit, from x to p
    double inside;        ///< |p - x|, mm
    double outside;       ///< |y - p|, mm
    double cos_in;        ///< to the normal, inside
    double cos_out;       ///< to the normal, outside
    double spread;        ///< |dOmega_y / dA_x|: solid angle at the camera over area across at x
    std::uint32_t facet;  ///< as in Crossing
    bool open;            ///< its body hardly ever blocks such a link, as trials found
};

/// Spread of a pencil of rays from the camera y that is refracted into a body.
///
///     dA_x / dOmega_y = d_o^2 (cos_i / cos_o) (1 - d_i V_s) (1 - d_i V_t)
///     eta V_s           = -1 / d_o           + (eta cos_i - cos_o) / R
///     eta cos_i^2 V_t   = -cos_o^2 / d_o     + (eta cos_i - cos_o) / R
///
/// with the vergences V inside, the radius R of a convex sphere (1 / R = 0 for a plane), distances
/// d and cosines outside (o) and inside (i).
///
/// Source   Coddington's equations; e.g. Welford, "Aberrations of optical systems", 1986, ch. 9.
struct Pencil {
    double sagittal, tangential;  ///< V_s, V_t, 1/mm

    Pencil(double eta, double curvature, double outside, double cos_in, double cos_out) {
        const double power = (eta * cos_in - cos_out) * curvature;
        sagittal = (power - 1 / outside) / eta;
        tangential = (power - cos_out * cos_out / outside) / (eta * cos_in * cos_in);
    }

    /// dOmega_y / dA_x at the depth `inside`.
    double spread(double inside, double outside, double cos_in, double cos_out) const {
        const double area = outside * outside * cos_in / cos_out * (1 - inside * sagittal) *
                            (1 - inside * tangential);
        return 1 / std::abs(area);
    }
};

}  // namespace tallow::reference
