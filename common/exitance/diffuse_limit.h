// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/optics/profile.h"

namespace tallow {

/// Bound of the share of light that enters a uniformly lit square of side `footprint` [mm] on a
/// plane and leaves outside of it, over all that leaves:
///
///     1 / R_total integral over the plane of R(r) (1 - o(x, y)),  o = (1 - |x|/p)+ (1 - |y|/p)+
///
/// o, the overlap of the square with itself moved by (x, y), is bounded from below by its mean over
/// directions, at least 1 - 4 r / (pi p).
///
/// Units    1. `mean_free_path` [mm] is the distance over which the profile varies.
/// Error    1.00 to 1.10 times the exact share, of six models from 0.1 to 1000 mean free paths.
double spilled_share(const Profile& profile, double mean_free_path, double footprint);

/// Whether a medium looks like a diffuse surface of reflectance R_total, M = R_total E, when it is
/// seen in footprints (pixels on the surface) of this side: in each channel the spilled share of a
/// footprint is at most `tolerance`.
///
/// The error of a footprint's mean exitance is then at most `tolerance` of R_total E_max, E_max the
/// largest irradiance in reach, hard shadows included. Where E varies smoothly it is far less, for
/// light that leaves a footprint comes back from its neighbours; docs/FINE_MEDIA.md derives both.
/// Curvature is not looked at: the surface has to be flat over a few footprints.
bool is_diffuse_at(const Medium& medium, Model model, float footprint_mm, double tolerance);

}  // namespace tallow
