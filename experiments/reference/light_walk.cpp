// SPDX-License-Identifier: Apache-2.0
// Walks from the lamps, each collision of which is linked to the camera.
#include <algorithm>
#include <cmath>

#include "common/base/errors.h"
#include "common/base/parallel.h"
#include "experiments/reference/estimators.h"
#include "experiments/reference/walk.h"

namespace tallow::reference {
namespace {

/// Links of the collisions of one channel's walks, and what they bring.
class Linker {
public:
    Linker(const World& world, int channel, Film& film, Effort& effort)
        : world_(world), channel_(channel), film_(film), effort_(effort) {}

    template <class Shape>
    void link(std::uint32_t index, const Shape& shape, const Walker& walker, WalkRandom& random) {
        const Body& body = world_.bodies[index];
        const float sigma_t = body.medium.sigma_t()[channel_];
        // The surface is at least this far: most collisions deep inside end here, by roulette.
        const float nearest = std::max(0.0f, shape.clearance(walker.position));
        if (nearest > body.reach[std::size_t(channel_)]) return;
        const float first = std::min(1.0f, kKeep * std::exp(-sigma_t * nearest));
        if (first < 1 && random.next() >= first) return;
        shape.links(walker.position, body.reach[std::size_t(channel_)],
                    [&](const CameraLink& link) {
                        use(index, body, link, walker, first, sigma_t, random);
                    });
    }

private:
    // Part of a link's most expected contribution below which it is drawn by roulette. Chosen:
    // see docs/REFERENCE_TRACER.md.
    static constexpr float kKeep = 1;

    void use(std::uint32_t index, const Body& body, const CameraLink& link, const Walker& walker,
             float first, float sigma_t, WalkRandom& random) {
        ++effort_.links;
        const auto view = world_.pinhole.see(link.position);
        if (!view) return;
        const double eta = double(body.medium.eta);
        const double through = 1 - fresnel_reflectance(1 / eta, link.cos_in);
        const double away = std::exp(-double(sigma_t) * link.inside);
        const float cosine = glm::dot(walker.direction, Vec3(link.w));
        const double scattered = double(body.medium.albedo()[channel_]) *
                                 double(henyey_greenstein(body.medium.g, cosine));
        // What the link brings, over what one of a collision at the surface does.
        const double part = scattered * 4 * std::numbers::pi * through * away / double(first);
        const double keep = std::min(1.0, double(kKeep) * part);
        if (!(keep > 0) || (keep < 1 && double(random.next()) >= keep)) return;
        if (!world_.bodies.is_clear(index, walker.position, link)) return;
        const double radiance = double(walker.power) * scattered * through * away * link.spread /
                                (eta * eta) * view->radiance / (double(first) * keep);
        film_.add(layer_of(walker.collisions, walker.arrivals), channel_, view->pixel,
                  float(radiance));
    }

    const World& world_;
    int channel_;
    Film& film_;
    Effort& effort_;
};

/// Starting directions that cover the bodies evenly, from points at random on the lamps.
class Starts {
public:
    explicit Starts(std::uint64_t seed) : direction_(mix_bits(seed)) {}

    Lamps::Choice operator()(std::uint32_t i, WalkRandom& random) const {
        const float lamp = random.next(), u = random.next(), v = random.next();
        return {lamp, {u, v}, direction_(i)};
    }

private:
    Sobol2d direction_;
};

}  // namespace

Effort& Effort::operator+=(const Effort& o) {
    walks += o.walks, collisions += o.collisions, turns += o.turns, links += o.links;
    leaks += o.leaks;
    return *this;
}

// Measured on the bunny: a ray costs about what three collisions do.
double Effort::cost() const {
    return 5.0 * double(walks) + double(collisions) + 3.0 * double(turns) + 3.0 * double(links);
}

Effort add_light_walks(const World& world, std::uint64_t seed, std::uint32_t walks, Film& film) {
    Effort effort;
    for (int channel = 0; channel < kChannels; ++channel) {
        const std::uint64_t channel_seed = mix_bits(seed * kChannels + std::uint64_t(channel));
        const Starts starts(channel_seed);
        Linker linker(world, channel, film, effort);
        for (std::uint32_t i = 0; i < walks; ++i) {
            if (i % 4096 == 0 && interrupted()) throw Interrupted();
            WalkRandom random(channel_seed, i);
            const auto ray = world.lamps.send(channel, starts(i, random));
            if (!ray) continue;
            Walker walker{ray->origin, ray->direction, ray->power / float(walks)};
            walk(
                world.bodies, channel, walker, random,
                [](const Walker&, float) { return Next::go_on; },
                [&](std::uint32_t body, const auto& shape, const Walker& at, Vec3) {
                    linker.link(body, shape, at, random);
                    return Next::go_on;
                });
            effort += {1, walker.collisions, walker.turns, 0, walker.leaks};
        }
    }
    return effort;
}

}  // namespace tallow::reference
