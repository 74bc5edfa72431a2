// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "common/geometry/ray_scene.h"
#include "common/scene/scene.h"

namespace tallow {

/// A point on the outside of a surface, where light is gathered. Both normals are unit and on the
/// same side. Receivers with the same seed take their rays from the same sequences, each from a
/// first one of its own, and are stratified together.
struct Receiver {
    Vec3 position;  // mm
    Vec3 n_g;       // geometric normal
    Vec3 n;         // shading normal
    std::uint64_t seed;
    std::uint32_t first_ray = 0;
};

/// How much of the light that arrives under a cosine counts.
struct Acceptance {
    /// 1 for all of it; otherwise the index of a smooth boundary that the light has to cross, and
    /// F_t(eta, cos_i) counts.
    float eta = 1;

    float operator()(float cos_i) const;
};

/// Irradiance by light that comes straight from the lights, added to E[group]; the groups' scales
/// are not applied.
///
///     E += sum over lights of the mean over rays of  L / pdf * accept(cos_i) * cos_i * V
///
/// Each area light gets `light_samples` shadow rays, others one.
///
/// Units    W/mm^2.
void add_direct_light(const Scene& scene, const RayScene& rays, const Receiver& receiver,
                      int light_samples, Acceptance accept, std::span<Rgb> E);

/// The sum over the groups, each with its scale.
Rgb scaled_sum(std::span<const LightGroup> groups, std::span<const Rgb> of_group);

}  // namespace tallow
