// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

#include "common/optics/fresnel.h"
#include "common/optics/phase.h"
#include "experiments/reference/bodies.h"
#include "experiments/reference/film.h"
#include "experiments/reference/walk_random.h"

namespace tallow::reference {

/// A packet of light of one channel on its way, from the lamp or, backwards, from the camera.
struct Walker {
    Vec3 position;
    Vec3 direction;  ///< unit, of travel
    float power;     ///< or importance; never changed by what is met, only by roulette
    std::uint64_t collisions = 0;  ///< that it was scattered at
    std::uint32_t arrivals = 0;    ///< times that it met a body from outside
    std::uint64_t turns = 0;       ///< times that it was refracted or reflected
    std::uint64_t leaks = 0;       ///< found outside the body that it was in, by rounding
};

/// How a walk goes on.
enum class Next { go_on, stop };

/// Light at a smooth boundary: reflected or refracted, by chance, with Fresnel's probabilities.
/// True if it goes through. `eta` is the far side's index over the near side's; `normal` points
/// to the near side.
inline bool cross_boundary(float eta, Vec3 normal, Walker& walker, WalkRandom& random) {
    const float cosine = std::clamp(-glm::dot(walker.direction, normal), 0.0f, 1.0f);
    ++walker.turns;
    if (random.next() >= fresnel_reflectance(eta, cosine)) {
        if (const std::optional<Vec3> through = refract(-walker.direction, normal, eta)) {
            walker.direction = *through;
            return true;
        }
    }
    walker.direction = glm::normalize(reflect(-walker.direction, normal));
    return false;
}

/// New direction by the phase function.
inline void scatter(float g, Walker& walker, WalkRandom& random) {
    const float u = random.next(), phi = kTwoPi * random.next();
    const float z = g == 0 ? 1 - 2 * u : sample_henyey_greenstein(g, u);
    const float sine = std::sqrt(std::max(0.0f, 1 - z * z));
    const Vec3 local(sine * std::cos(phi), sine * std::sin(phi), z);
    // Without a preferred direction any frame will do.
    walker.direction =
        g == 0 ? local : glm::normalize(make_frame(walker.direction).to_world(local));
}

/// What follows a collision: false if light is absorbed, otherwise it has a new direction.
inline bool survive_collision(const Medium& medium, int channel, Walker& walker,
                              WalkRandom& random) {
    if (random.next() >= medium.albedo()[channel]) return false;
    scatter(medium.g, walker, random);
    return true;
}

/// A walk inside one body until it is absorbed, stopped or leaves; true if it leaves. Analog: free
/// paths by the extinction, absorption by chance.
///
/// on_collision(walker, from) is called where light that comes straight from `from` collides,
/// before it is known whether that absorbs it; walker.collisions counts this collision already,
/// walker.direction is still that of arrival.
template <class Shape, class OnCollision>
bool walk_inside(const Shape& shape, const Medium& medium, int channel, Walker& walker,
                 WalkRandom& random, OnCollision&& on_collision) {
    const float mean_free_path = 1 / medium.sigma_t()[channel];
    for (;;) {
        const float flight = mean_free_path * random.exponential();
        const float clearance = shape.clearance(walker.position);
        if (flight >= clearance) {
            if (clearance < 0) {
                ++walker.leaks;
                return false;
            }
            if (const auto hit = shape.leave(walker.position, walker.direction, flight)) {
                walker.position = hit->position;
                if (cross_boundary(1 / medium.eta, -hit->normal, walker, random)) return true;
                continue;
            }
        }
        const Vec3 from = walker.position;
        walker.position += flight * walker.direction;
        ++walker.collisions;
        if (on_collision(walker, from) == Next::stop) return false;
        if (!survive_collision(medium, channel, walker, random)) return false;
    }
}

/// A walk inside bodies[index]; true if it leaves. on_collision(body, shape, walker, from) as in
/// walk_inside().
template <class OnCollision>
bool walk_in_body(const Bodies& bodies, std::uint32_t index, int channel, Walker& walker,
                  WalkRandom& random, OnCollision&& on_collision) {
    const Body& body = bodies[index];
    return std::visit(
        [&](const auto& shape) {
            return walk_inside(
                shape, body.medium, channel, walker, random,
                [&](Walker& at, Vec3 from) { return on_collision(index, shape, at, from); });
        },
        body.shape);
}

/// Which way a walk crosses a surface.
enum class Crossed { in, out };

/// A walk that starts in the air, to its end.
///
/// on_air(walker, length) is called for every straight piece through the air, which ends at a body
/// after `length` or never; on_collision as in walk_in_body(); on_crossing(walker, way) where light
/// has entered or left a body.
template <class OnAir, class OnCollision, class OnCrossing>
void walk(const Bodies& bodies, int channel, Walker& walker, WalkRandom& random, OnAir&& on_air,
          OnCollision&& on_collision, OnCrossing&& on_crossing) {
    for (;;) {
        const std::optional<Bodies::Entry> entry = bodies.enter(walker.position, walker.direction);
        on_air(walker, entry ? entry->crossing.t : kInfinity);
        if (!entry) return;
        ++walker.arrivals;
        walker.position = entry->crossing.position;
        const float eta = bodies[entry->body].medium.eta;
        if (!cross_boundary(eta, entry->crossing.normal, walker, random)) continue;
        on_crossing(walker, Crossed::in);
        if (!walk_in_body(bodies, entry->body, channel, walker, random, on_collision)) return;
        on_crossing(walker, Crossed::out);
    }
}

template <class OnAir, class OnCollision>
void walk(const Bodies& bodies, int channel, Walker& walker, WalkRandom& random, OnAir&& on_air,
          OnCollision&& on_collision) {
    walk(bodies, channel, walker, random, on_air, on_collision, [](const Walker&, Crossed) {});
}

}  // namespace tallow::reference
