// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/optics/medium.h"
#include "common/scene/scene.h"
#include "common/scene/scene_geometry.h"

namespace tallow {

/// Spacing of samples for a medium and a tolerance: 0.35 of the smallest channel's mean free path
/// at 1 %, growing with the square root of the tolerance, because the error of a midpoint rule
/// grows with the square of the spacing. At most a fifth of the body's extent.
///
/// Units    mm.
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

/// A spacing for each translucent object. A wished-for number of samples is met within 5 %: the
/// automatic spacings are all multiplied by the factor at which that many samples are counted, so
/// that the bodies share them as they would share those of the automatic spacings.
///
/// Throws   InputError if the samples would not fit in memory, or if the bodies cannot be sampled
///          with so few.
std::vector<BodySpacing> choose_spacings(const Scene& scene, const SceneGeometry& geometry,
                                         const SamplingWish& wish);

}  // namespace tallow
