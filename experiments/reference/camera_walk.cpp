// SPDX-License-Identifier: Apache-2.0
// Walks backwards from the camera to the lamps.
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
        walk(
            world_.bodies, channel_, walker, random,
            [&](const Walker& at, float length) { return in_air(at, length); },
            [&](std::uint32_t body, const auto& shape, const Walker& at, Vec3 from) {
                return collided(world_.bodies[body], shape, at, from);
            });
        return {1, walker.collisions, walker.turns, 0, walker.leaks};
    }

private:
    Next in_air(const Walker& walker, float length) {
        if (walker.arrivals == 0) return Next::go_on;  // a lamp seen directly is not the bodies'
        const float radiance =
            world_.lamps.radiance(channel_, walker.position, walker.direction, length);
        if (radiance > 0)
            film_.add(layer_of(walker.collisions, walker.arrivals), channel_, pixel_,
                      walker.power * radiance);
        return Next::go_on;
    }

    // The first collision after one refraction: the end of a path that a link may count.
    template <class Shape>
    Next collided(const Body& body, const Shape& shape, const Walker& walker, Vec3 from) {
        if (counts_ == CameraCounts::everything || walker.collisions > 1 || walker.turns > 1)
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
            CameraWalk camera_walk(world, counts, channel, pixel, film);
            for (std::uint32_t i = 0; i < rays; ++i) {
                const Vec2 u = in_pixel(i);
                const Ray ray = camera_ray(world.camera, float(pixel % width) + u.x,
                                           float(pixel / width) + u.y);
                WalkRandom random(channel_seed, std::uint64_t(pixel) * rays + i);
                Walker walker{ray.origin, ray.direction, 1 / float(rays)};
                effort += camera_walk.follow(walker, random);
            }
        }
    }
    return effort;
}

}  // namespace tallow::reference
