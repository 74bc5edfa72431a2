// SPDX-License-Identifier: Apache-2.0
// Walks backwards from the camera to the lamps.
#include <algorithm>
#include <cmath>

#include "common/base/errors.h"
#include "common/base/parallel.h"
#include "experiments/reference/estimators.h"
#include "experiments/reference/walk.h"

namespace tallow::reference {
namespace {

/// One walk. Radiance is the same along it, but for the factor eta^2 at each refraction, which
/// entering and leaving cancel.
class CameraWalk {
public:
    CameraWalk(const World& world, CameraCounts counts, int channel, std::uint32_t pixel,
               Film& film)
        : world_(world), counts_(counts), channel_(channel), pixel_(pixel), film_(film) {}

    Effort follow(Walker& walker, WalkRandom& random) {
        unit_ = walker.power;
        effort_.walks = 1;
        if (counts_ == CameraCounts::everything) {
            go_through_air(walker, random);
            count(walker);
        } else {
            begin_unlinked(walker, random);
        }
        return effort_;
    }

private:
    auto on_collision() const {
        return [this](std::uint32_t body, const auto& shape, const Walker& at, Vec3 from) {
            return collided(world_.bodies[body], shape, at, from);
        };
    }

    void go_through_air(Walker& walker, WalkRandom& random) {
        walk(
            world_.bodies, channel_, walker, random,
            [this](const Walker& at, float length) { in_air(at, length); }, on_collision());
    }

    void go_through_body(std::uint32_t body, Walker& walker, WalkRandom& random) {
        if (walk_in_body(world_.bodies, body, channel_, walker, random, on_collision()))
            go_through_air(walker, random);
    }

    // Most walks would be refracted, collide within reach, and be dropped, because a link counts
    // them. So half of them are reflected, with a power that makes up for it, and the others fly
    // on beyond the reach of links or through the body.
    void begin_unlinked(Walker& walker, WalkRandom& random) {
        constexpr float kReflected = 0.5f;
        const auto entry = world_.bodies.enter(walker.position, walker.direction);
        if (!entry) return;
        ++walker.arrivals, ++walker.turns;
        walker.position = entry->crossing.position;
        const Body& body = world_.bodies[entry->body];
        const Vec3 back = -walker.direction, normal = entry->crossing.normal;
        const float cosine = std::clamp(glm::dot(back, normal), 0.0f, 1.0f);
        const float reflectance = fresnel_reflectance(body.medium.eta, cosine);
        if (random.next() < kReflected) {
            walker.power *= reflectance / kReflected;
            walker.direction = glm::normalize(reflect(back, normal));
            if (survives(walker, random)) go_on_mirrored(walker, random);
            return;
        }
        const auto through = refract(back, normal, body.medium.eta);
        if (!through) return;
        walker.power *= (1 - reflectance) / (1 - kReflected);
        walker.direction = *through;
        std::visit([&](const auto& shape) { fly_on(entry->body, shape, walker, random); },
                   body.shape);
    }

    template <class Shape>
    void fly_on(std::uint32_t index, const Shape& shape, Walker& walker, WalkRandom& random) {
        if constexpr (!Shape::kLinksAll) {
            go_through_body(index, walker, random);
            count(walker);
            return;
        }
        const Medium& medium = world_.bodies[index].medium;
        const float reach = world_.bodies[index].reach[std::size_t(channel_)];
        const auto out = shape.leave(walker.position, walker.direction, reach);
        walker.power *= std::exp(-medium.sigma_t()[channel_] * (out ? out->t : reach));
        if (!survives(walker, random)) return;
        beyond_links_ = true;
        walker.position = out ? out->position : walker.position + reach * walker.direction;
        split(walker, [&](Walker& copy) {
            if (out && cross_boundary(1 / medium.eta, -out->normal, copy, random))
                go_through_air(copy, random);
            else
                go_through_body(index, copy, random);
        });
    }

    // From the mirror reflection that a camera ray begins with, to a lamp or a body.
    void go_on_mirrored(Walker& walker, WalkRandom& random) {
        const auto entry = world_.bodies.enter(walker.position, walker.direction);
        in_air(walker, entry ? entry->crossing.t : kInfinity);
        if (!entry) return;
        ++walker.arrivals;
        walker.position = entry->crossing.position;
        const float eta = world_.bodies[entry->body].medium.eta;
        split(walker, [&](Walker& copy) {
            if (cross_boundary(eta, entry->crossing.normal, copy, random))
                go_through_body(entry->body, copy, random);
            else
                go_through_air(copy, random);
        });
    }

    // The few walks that get somewhere go on as many.
    template <class GoOn>
    void split(const Walker& walker, const GoOn& go_on) {
        constexpr int kCopies = 8;
        for (int i = 0; i < kCopies; ++i) {
            Walker copy = walker;
            copy.power /= kCopies;
            go_on(copy);
            count(copy);
        }
    }

    void count(const Walker& walker) {
        effort_ += {0, walker.collisions, walker.turns, 0, walker.leaks};
    }

    // Roulette for what has lost most of its power.
    bool survives(Walker& walker, WalkRandom& random) const {
        constexpr float kLeast = 0.1f;
        const float part = walker.power / unit_;
        if (part >= kLeast) return true;
        if (random.next() * kLeast >= part) return false;
        walker.power = kLeast * unit_;
        return true;
    }

    void in_air(const Walker& walker, float length) {
        if (walker.arrivals == 0) return;  // a lamp seen directly is not the bodies'
        const float radiance =
            world_.lamps.radiance(channel_, walker.position, walker.direction, length);
        if (radiance > 0)
            film_.add(layer_of(walker.collisions, walker.arrivals), channel_, pixel_,
                      walker.power * radiance);
    }

    // The first collision after one refraction: the end of a path that a link may count.
    template <class Shape>
    Next collided(const Body& body, const Shape& shape, const Walker& walker, Vec3 from) const {
        if (counts_ == CameraCounts::everything || beyond_links_ || walker.collisions > 1 ||
            walker.turns > 1)
            return Next::go_on;
        const float inside = glm::length(walker.position - from);
        const float reach = body.reach[std::size_t(channel_)];
        return shape.links_path(walker.position, from, inside, reach) ? Next::stop : Next::go_on;
    }

    const World& world_;
    CameraCounts counts_;
    int channel_;
    std::uint32_t pixel_;
    Film& film_;
    Effort effort_;
    float unit_ = 0;             // power of a walk at its start
    bool beyond_links_ = false;  // the walk is one that no link counts
};

}  // namespace

Effort add_camera_walks(const World& world, CameraCounts counts, std::uint64_t seed,
                        std::uint32_t rays, Film& film) {
    Effort effort;
    const auto width = std::uint32_t(world.pinhole.width());
    for (int channel = 0; channel < kChannels; ++channel) {
        const std::uint64_t channel_seed = mix_bits(~seed * kChannels + std::uint64_t(channel));
        for (std::uint32_t pixel = 0; pixel < world.pinhole.pixels(); ++pixel) {
            if (pixel % 256 == 0 && interrupted()) throw Interrupted();
            const Sobol2d in_pixel(mix_bits(channel_seed + pixel));
            for (std::uint32_t i = 0; i < rays; ++i) {
                const Vec2 u = in_pixel(i);
                const Ray ray = camera_ray(world.camera, float(pixel % width) + u.x,
                                           float(pixel / width) + u.y);
                WalkRandom random(channel_seed, std::uint64_t(pixel) * rays + i);
                Walker walker{ray.origin, ray.direction, 1 / float(rays)};
                effort += CameraWalk(world, counts, channel, pixel, film).follow(walker, random);
            }
        }
    }
    return effort;
}

}  // namespace tallow::reference
