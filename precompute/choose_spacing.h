// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/exitance/scene_plan.h"
#include "common/optics/medium.h"
#include "common/scene/scene.h"
#include "common/scene/scene_geometry.h"

namespace tallow {

/// Spacing of samples for a medium and a tolerance: h = 0.35 (tolerance / 1 %)^0.6 mean free paths
/// of the smallest channel, but at most a fifth of the body's extent.
///
/// Units    mm.
/// Error    0.7 times the tolerance by the samples alone, which leaves as much to their summation
///          (the squares add up to the tolerance's). Fitted to the profile `transport` and to
///          `photon-beam-diffusion`, whose errors grow as h^1.65: 1 % at 0.39 to 0.47 mean free
///          paths, on three bodies in two media (docs/SAMPLING.md). The dipoles would do with
///          larger spacings; normalized diffusion, which goes as 1/r, has errors some twenty times
///          as large. The model is no parameter: pass one does not know it.
float automatic_spacing(const Medium& medium, double tolerance, float extent);

/// What the user wants; with neither, the spacing is automatic for each body.
struct SamplingWish {
    std::optional<float> spacing;   ///< mm, of all bodies
    std::optional<double> samples;  ///< of all bodies together
};

struct BodySpacing {
    std::uint32_t object;
    float spacing;    // mm
    double expected;  // samples, about
};

/// A spacing for each object that is to be sampled. A wished-for number of samples is met within 5
/// %: the automatic spacings are all multiplied by the factor at which that many samples are
/// counted, so that the bodies share them as they would share those of the automatic spacings.
///
/// Throws   InputError if the samples would not fit in memory, or if the bodies cannot be sampled
///          with so few.
std::vector<BodySpacing> choose_spacings(const Scene& scene, const SceneGeometry& geometry,
                                         std::span<const Treatment> treatment,
                                         const SamplingWish& wish);

/// Memory that pass one takes at most for such samples, bytes.
double memory_of_samples(double samples, std::size_t groups, bool indirect);

}  // namespace tallow
