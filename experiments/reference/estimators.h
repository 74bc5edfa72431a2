// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "experiments/reference/bodies.h"
#include "experiments/reference/film.h"
#include "experiments/reference/lamps.h"
#include "experiments/reference/pinhole.h"
#include "experiments/reference/start_map.h"

namespace tallow::reference {

/// A scene as the estimators see it.
struct World {
    const Bodies& bodies;
    const Lamps& lamps;
    const Camera& camera;
    Pinhole pinhole;
};

/// Work done, in numbers that do not depend on the machine.
struct Effort {
    std::uint64_t walks = 0, collisions = 0, turns = 0, links = 0, leaks = 0;
    Effort& operator+=(const Effort& o);
    /// Rough cost, in collisions.
    double cost() const;
};

/// Where walks from each lamp and of each channel start: [lamp * kChannels + channel].
using StartMaps = std::vector<StartMap>;

/// Paths that links count: from their last collision one refraction leads to the camera, and the
/// body's links() reports it. Every collision of walks from the lamps brings radiance
///
///     alpha p(cos) / eta^2 * F_t e^(-sigma_t d) spread * (1 / (pixel_size^2 cos^3 theta))
///
/// times its power to the pixel in which the camera sees the link. Links that are expected to bring
/// little are drawn by chance and bring more.
///
/// Adds `walks` walks of each channel to the film, divided by their number.
Effort add_light_walks(const World& world, const StartMaps& starts, std::uint64_t seed,
                       std::uint32_t walks, Film& film);

/// Starts for which the noise of the picture, sqrt(mean variance), is least at a given cost, as
/// `walks` trial walks of each channel tell: in proportion to sqrt(v / c), with
///
///     v   mean, over walks from a cell, of the sum over pixels of the square of what one brings
///     c   their mean cost
StartMaps learn_starts(const World& world, std::uint64_t seed, std::uint32_t walks);

/// Which paths a camera walk counts.
enum class CameraCounts {
    unlinked,   ///< those that links do not count
    everything  ///< all of them
};

/// Walks backwards from the camera, `rays` of each channel a pixel, that bring a lamp's radiance
/// where they end at one.
Effort add_camera_walks(const World& world, CameraCounts counts, std::uint64_t seed,
                        std::uint32_t rays, Film& film);

}  // namespace tallow::reference
