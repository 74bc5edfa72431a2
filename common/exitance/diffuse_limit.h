// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/optics/profile.h"

namespace tallow {

/// Bound of the share of light that enters a square of side `footprint` [mm] on a plane and leaves
/// outside of it, over all that leaves. It holds however the irradiance is spread over the square:
/// for a uniform one it is
///
///     1 / R_total integral over the plane of R(r) (1 - o(x, y)),  o = (1 - |x|/p)+ (1 - |y|/p)+
///
/// the overlap of the square with itself moved by (x, y); o is bounded from below by its mean over
/// directions, at least 1 - 4 r / (pi p).
///
/// Units    1. `mean_free_path` [mm] is the distance over which the profile varies.
/// Error    of the quadrature 1e-4 of the value.
double spilled_share(const Profile& profile, double mean_free_path, double footprint);

/// Whether a medium looks like a diffuse surface of reflectance R_total, M = R_total E, when it is
/// seen in footprints (pixels on the surface) of this side: in each channel the spilled share of a
/// pixel is at most `tolerance`.
///
/// That bounds the difference of a pixel's mean exitance relative to that of the brightest pixel in
/// reach, for any irradiance, hard shadows included. Where E varies smoothly, light that leaves a
/// pixel comes back from its neighbours, and the difference is less by another factor of about
/// <r> |E'| / E; docs/FINE_MEDIA.md has both. Curvature is not looked at: the surface has to be
/// flat over a few footprints.
bool is_diffuse_at(const Medium& medium, Model model, float footprint_mm, double tolerance);

}  // namespace tallow
