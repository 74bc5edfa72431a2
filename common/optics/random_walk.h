// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "common/base/rng.h"
#include "common/base/vec.h"
#include "common/optics/fresnel.h"
#include "common/optics/phase.h"

namespace tallow {

/// A homogeneous layer with parallel smooth faces at z = 0 and z = thickness, between equal outer
/// media. Lengths are in mean free paths.
struct Slab {
    double eta = 1;  ///< index inside / outside
    float g = 0;     ///< mean cosine of its Henyey-Greenstein phase function
    double thickness = std::numeric_limits<double>::infinity();  ///< infinite: a half-space
};

/// Light expected to leave the slab at the end of one flight of a walk.
struct Escape {
    double r2;      ///< squared distance from the point of entry, in mean free paths^2
    int order;      ///< collisions so far: with an albedo alpha it carries weight * alpha^order
    double weight;  ///< expected part of the light that entered
    bool top;       ///< through the face where it entered
};

/// Uniform numbers of one walk, a function of the seed and the number of the walk.
class WalkRandom {
public:
    WalkRandom(std::uint64_t seed, std::uint64_t walk) : state_(mix_bits(mix_bits(seed) + walk)) {}
    /// In [0, 1), 53 bits. Source: SplitMix64 (Steele, Lea, Flood 2014).
    double next() {
        state_ += 0x9e3779b97f4a7c15ull;
        return static_cast<double>(mix_bits(state_) >> 11) * 0x1p-53;
    }

private:
    std::uint64_t state_;
};

/// Direction of travel after a collision.
inline DVec3 scatter(const DVec3& direction, float g, WalkRandom& random) {
    const double u = random.next();
    const double cosine = g == 0 ? 1 - 2 * u : double(sample_henyey_greenstein(g, float(u)));
    const double sine = std::sqrt(std::fmax(0.0, 1 - cosine * cosine));
    const double phi = 2 * std::numbers::pi * random.next();
    const DVec3 local(sine * std::cos(phi), sine * std::sin(phi), cosine);
    if (g == 0) return local;
    return glm::normalize(DVec3(make_frame(Vec3(direction)).to_world(Vec3(local))));
}

/// One walk of light that has entered at the origin along +z, without absorption. Calls
/// score(Escape) for every flight that could leave; returns the weight that was still inside after
/// `max_order` collisions, or 0.
///
/// Each flight towards a face is scored with its expected value, the probability to get there times
/// the Fresnel transmittance, and is then played out by chance. From order 64 on half of the walks
/// end at each power of four, at random, and the others count twice, so that every octave of orders
/// costs about the same. Both leave the expectation of every score as it is: the result is
/// unbiased.
template <class Score>
double random_walk(const Slab& slab, int max_order, WalkRandom& random, Score&& score) {
    constexpr double kOpaque = 40;  // e^-40 of a walk is below the rounding of the sum
    constexpr int kFirstRoulette = 64;
    DVec3 position(0), direction(0, 0, 1);
    double weight = 1;
    for (int order = 0;;) {
        const bool up = direction.z < 0;
        const double to_face = ((up ? 0 : slab.thickness) - position.z) / direction.z;
        const double reflected = fresnel_reflectance(1 / slab.eta, std::abs(direction.z));
        if (reflected < 1 && to_face < kOpaque) {
            const DVec3 exit = position + to_face * direction;
            score(Escape{exit.x * exit.x + exit.y * exit.y, order,
                         weight * std::exp(-to_face) * (1 - reflected), up});
        }
        const double flight = -std::log1p(-random.next());
        if (flight >= to_face) {
            if (random.next() >= reflected) return 0;
            position += to_face * direction;
            position.z = up ? 0 : slab.thickness;
            direction.z = -direction.z;
            continue;
        }
        position += flight * direction;
        if (++order > max_order) return weight;
        const auto bits = static_cast<unsigned>(order);
        if (order >= kFirstRoulette && std::has_single_bit(bits) &&
            std::countr_zero(bits) % 2 == 0) {
            if (random.next() < 0.5) return 0;
            weight *= 2;
        }
        direction = scatter(direction, slab.g, random);
    }
}

}  // namespace tallow
