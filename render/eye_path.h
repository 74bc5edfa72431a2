// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "render/single_scatter.h"

namespace tallow {

/// A straight piece of the way of an eye ray inside a body, from one meeting with its surface to
/// the next.
struct EyeSegment {
    std::size_t point;  // of the EyePoint that it belongs to
    Vec3 start;         // mm
    Vec3 direction;     // unit, away from the eye
    float length;       // mm; infinite in a half-space
    Rgb throughput;     // reflectances and e^(-sigma_t s) from where the ray entered to `start`
};

/// What a surface reflects of light that meets it from inside at `end`.
struct InnerReflection {
    Vec3 direction;  // unit
    float reflectance;
};
/// Nothing where a ray grazed an edge from outside, by rounding. Interpolated normals reflect,
/// unless they would send light out of the body.
std::optional<InnerReflection> reflect_inside(Vec3 direction, const Hit& end, float eta);

/// Follows eye rays that are refracted into a body, and on where they are reflected inside, until
/// what is left may bring less than 0.3 % of the light that is scattered once; without `body.exact`
/// to their first end only. Those of a point follow one another, in the order of `points`; a point
/// has none whose ray does not enter.
std::vector<EyeSegment> follow_eye_rays(const ScatteringBody& body,
                                        std::span<const EyePoint> points);

/// Share of light along the segment that is scattered on it, times its throughput, mean over
/// channels: what it can bring, if light falls everywhere alike.
float weight_of(const EyeSegment& segment, Rgb sigma_t);

}  // namespace tallow
