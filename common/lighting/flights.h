// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/diffusion/flight.h"
#include "common/geometry/ray_scene.h"

namespace tallow {

/// Follows light inside of a body of index `eta`: where it meets the surface a part of it is
/// mirrored by Fresnel's equations, and the rest leaves. Parts below 1e-3 are dropped, and so is
/// what is left after Flight::kLegs legs.
///
/// A sample is the centroid of its cell: in hollows it lies above the surface. Light that starts
/// there enters before it can leave.
///
/// `rays` must outlive the result.
FollowFlights flights_in(const RayScene& rays, std::uint32_t object, float eta);

}  // namespace tallow
