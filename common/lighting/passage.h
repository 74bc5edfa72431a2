// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "common/geometry/ray_scene.h"
#include "common/scene/scene.h"

namespace tallow {

/// A ray that goes on outside of a body, and the share of its radiance that it brings back to
/// where it set out.
struct Passage {
    Ray ray;
    Rgb weight;
};

/// What of the passages of a body is left out.
struct PassageLimits {
    float least_weight;    ///< > 0: passages that keep less than this in each channel
    int most_reflections;  ///< of those that are reflected inside more often
};

/// Follows a ray backwards through a body without any collision. It meets the body from outside at
/// `hit`, where hit.n and hit.n_g are on the side of w_o, is refracted into it, reflected inside,
/// and leaves wherever it is not totally reflected, each time as a passage with
///
///     weight = F_t(w_o) e^(-sigma_t s) F_r(1) ... F_r(k) F_t(k + 1)
///
/// s is the length of the way inside. Radiance that enters a body grows by eta^2 and loses it again
/// where it leaves. Appends to `result`.
///
/// Source   Fresnel's and Snell's laws; Beer's law with the extinction sigma_s + sigma_a, not the
///          reduced one: light that is scattered forward is scattered.
void find_passages(const Scene& scene, const RayScene& rays, const Hit& hit, Vec3 w_o,
                   PassageLimits limits, std::vector<Passage>& result);

}  // namespace tallow
