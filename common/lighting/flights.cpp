// SPDX-License-Identifier: Apache-2.0
// Starts -> flights: all first legs of a block are traced together, those behind a mirror alone.
#include "common/lighting/flights.h"

#include <algorithm>
#include <optional>

#include "common/base/parallel.h"
#include "common/optics/fresnel.h"

namespace tallow {
namespace {

constexpr std::size_t kBlock = 256;  // flights whose rays are traced together
constexpr int kMostEntries = 4;      // of one leg, before it is taken to have left
constexpr float kLeastShare = 1e-3f;

class Follower {
public:
    Follower(const RayScene& rays, std::uint32_t object, float eta)
        : rays_(rays), object_(object), eta_(eta) {}

    ShadowRay first_way(Vec3 from, Vec3 normal, Vec3 w, float longest) const {
        return {rays_.offset_origin(from, normal, w), w, longest};
    }

    void trace(std::span<const ShadowRay> ways, std::span<std::optional<Hit>> hits) const {
        rays_.intersect_object(ways, object_, hits);
    }

    Flight follow(ShadowRay way, std::optional<Hit> hit) const {
        Flight flight;
        float share = 1;
        for (std::size_t i = 0; i < Flight::kLegs; ++i) {
            hit = find_exit(way, hit);
            flight.legs[i] = {way.direction, hit ? hit->t : kInfinity, share};
            if (!hit) break;
            const float cosine = std::min(1.0f, std::abs(glm::dot(way.direction, hit->n_g)));
            share *= fresnel_reflectance(1 / eta_, cosine);
            way.length -= hit->t;
            if (share < kLeastShare || way.length <= 0 || i + 1 == Flight::kLegs) break;
            way.direction = -reflect(way.direction, hit->n_g);
            way.origin = rays_.offset_origin(hit->position, hit->n_g, way.direction);
            hit = rays_.intersect_object({way.origin, way.direction}, object_, way.length);
        }
        return flight;
    }

private:
    // Where a way leaves, if it enters at `hit`; nothing within its length.
    std::optional<Hit> find_exit(const ShadowRay& way, std::optional<Hit> hit) const {
        for (int entry = 0; entry < kMostEntries && hit && glm::dot(way.direction, hit->n_g) < 0;
             ++entry) {
            const float before = hit->t;
            const Vec3 inside = rays_.offset_origin(hit->position, hit->n_g, way.direction);
            if (before >= way.length) return std::nullopt;
            hit = rays_.intersect_object({inside, way.direction}, object_, way.length - before);
            if (hit) hit->t += before;
        }
        return hit;
    }

    const RayScene& rays_;
    std::uint32_t object_;
    float eta_;
};

}  // namespace

FollowFlights flights_in(const RayScene& rays, std::uint32_t object, float eta) {
    return [follower = Follower(rays, object, eta)](std::span<const Vec3> from,
                                                    std::span<const Vec3> normal,
                                                    std::span<const Vec3> w, float longest) {
        std::vector<Flight> result(from.size());
        parallel_ranges(result.size(), kBlock, [&](std::size_t begin, std::size_t end) {
            std::vector<ShadowRay> ways;
            for (std::size_t i = begin; i < end; ++i)
                ways.push_back(follower.first_way(from[i], normal[i], w[i], longest));
            std::vector<std::optional<Hit>> hits(ways.size());
            follower.trace(ways, hits);
            for (std::size_t i = begin; i < end; ++i)
                result[i] = follower.follow(ways[i - begin], hits[i - begin]);
        });
        return result;
    };
}

}  // namespace tallow
