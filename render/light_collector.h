// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "render/single_scatter.h"

namespace tallow {

class EntryDirections;

/// A place inside where light is scattered towards the eye.
struct Place {
    std::size_t point;    // of the eye ray that it lies on
    std::uint32_t index;  // of its light samples in the point's sequences
    Vec3 x;               // mm
    Vec3 w_inside;        // unit, along the eye ray away from the eye
    Rgb weight;           // of what is scattered here in the radiance at the surface
};

/// surface_tint() where only a place on the body's surface is known: texture coordinates belong to
/// a hit. 0 where rounding finds none, off an edge.
Rgb tint_at(const ScatteringBody& body, Vec3 position, Vec3 n_g);

/// Radiance that leaves the body, without sigma_s: sum over places of weight times the integral of
/// p L F_t cos_i / cos_i' e^(-sigma_t s_i'), for each point. single_scatter() says how.
class LightCollector {
public:
    LightCollector(const ScatteringBody& body, std::span<const EyePoint> points,
                   std::span<Rgb> sum);

    /// How many places are best added together: many where paths are searched, because neighbours
    /// share work.
    std::size_t batch() const { return body_.exact != nullptr ? kSearchBatch : kBatch; }

    /// At most batch() places.
    void add(std::span<const Place> places);

private:
    // Chosen: what is kept of them fits into the first-level cache.
    static constexpr std::size_t kBatch = 256;
    static constexpr std::size_t kSearchBatch = 4096;

    /// Light on its way from a lamp to a place.
    struct Arriving {
        const Place* place;
        Rgb radiance;
        float distance;  // to the lamp
    };

    void add_straight_lines(std::span<const Place> places, std::size_t light);
    bool enter(Arriving& light, const ShadowRay& inside, const Hit& exit, ShadowRay& outside) const;
    bool is_drawn(const Light& light) const;
    void add_entering_rays(std::span<const Place> places, std::size_t light_index);
    void follow_straight_lines(std::span<const Place> places, std::size_t light_index,
                               const LightBall& ball);
    void add_normals(const Place& place, const std::optional<LightBall>& ball,
                     const std::optional<Hit>& exit, EntryDirections& directions) const;
    bool bend_outwards(Arriving& light, const ShadowRay& inside, const Hit& exit, const Light& lamp,
                       ShadowRay& outside) const;
    void add_refracted_paths(std::span<const Place> places, std::size_t light_index);
    void add_path(const Place& place, std::size_t light_index, const LightPoint& y,
                  const RefractedPath& path);
    float draw_reach(const Place& place, std::size_t light_index) const;
    void add_unblocked();
    void add_inner_light(std::span<const Place> places);
    Vec2 light_sample(const Place& place, std::size_t light) const;
    bool admits_light(Vec3 x) const;
    void add(const Place& place, Rgb radiance) {
        sum_[place.point] += scale_ * place.weight * radiance;
    }

    const ScatteringBody& body_;
    std::span<const EyePoint> points_;
    std::span<Rgb> sum_;
    Rgb sigma_t_;
    float reach_;  // mm
    Rgb scale_;    // of the light's group
    std::array<Arriving, kBatch> arriving_;
    std::array<ShadowRay, kBatch> inside_, outside_;
    std::array<std::optional<Hit>, kBatch> exit_;
    std::array<bool, kBatch> occluded_;
    std::vector<ConnectionQuery> queries_;
    std::size_t paths_ = 0;  // in the arrays, of refracted ones
};

}  // namespace tallow
