// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/exitance/exit_factor.h"
#include "common/geometry/ray_scene.h"
#include "common/scene/scene.h"

namespace tallow {

/// A place on a translucent body that a path has met. The body shines there by its own exitance,
/// which is cheap to know for many places at once: so it is asked for later.
struct BodyVertex {
    std::uint32_t receiver;  // whose path it is
    std::uint32_t object;
    Vec3 position;  // on the surface, mm
    Vec3 n;         // shading normal, on the side of w_o
    Vec3 w_o;       // unit, towards the previous vertex
    Rgb factor;     // radiance at the receiver by an exitance of 1: throughput * T(w_o) / pi
};

/// Paths that follow light backwards from a receiver over surfaces that reflect it: diffuse ones,
/// with a shadow ray to each light; plastics, either by their base or by their coat; mirrors; and
/// the smooth surface of translucent bodies, which also shine by themselves, and which light passes
/// that is not scattered inside (find_passages()). Light that reaches the receiver with nothing in
/// its way is not theirs: lights are seen in mirrors and through bodies only.
///
/// At a body a path may be mirrored or pass it, by one way or another: one of them is chosen by
/// what each carries. Russian roulette ends a path with the share of light that is lost, so that no
/// contribution is cut off. Lights in mirrors and behind bodies are looked for before it: a coat
/// that reflects a twenty-fifth of a lamp shows it always and faintly, not one time in twenty-five
/// and bright.
class LightPaths {
public:
    /// Light may be reflected up to `bounces` times, by diffuse surfaces and bodies; mirror
    /// reflections and passages do not count, up to kMostMirrors of them.
    /// Objects with a reflectance in `diffuse` [object] are bodies that are taken for diffuse
    /// surfaces; empty if there are none.
    LightPaths(const Scene& scene, const RayScene& rays, int bounces,
               std::vector<std::optional<Rgb>> diffuse = {});

    static constexpr int kMostMirrors = 8;

    /// What to collect. Bodies alone suffices when only their exitance has changed.
    enum class Collect { everything, bodies };

    /// Follows one path whose first segment is `ray`. Adds the radiance that opaque surfaces and
    /// mirrored lights send back along it to L[group], group scales not applied, and appends the
    /// places on bodies. The path depends on `seed` only, not on what is collected.
    void follow(Ray ray, std::uint32_t receiver, std::uint64_t seed, Collect collect,
                std::span<Rgb> L, std::vector<BodyVertex>& bodies) const;

private:
    struct Walk;
    /// A way on from a vertex; mirrored or passing a body if specular.
    struct Onward {
        Ray ray;
        Rgb weight;
        bool specular;
    };

    void meet(Hit hit, Vec3 w_o, Walk& walk) const;
    void mirror(const Hit& hit, Vec3 w_o, Rgb weight, Walk& walk) const;
    void pass(const Hit& hit, Vec3 w_o, Walk& walk) const;
    void meet_coated(const Hit& hit, Vec3 w_o, Rgb base, float eta, Walk& walk) const;
    void meet_base(const Hit& hit, Rgb rho, float eta, Walk& walk) const;
    bool meet_light(const Ray& ray, Rgb weight, const Walk& walk) const;
    std::optional<Onward> choose(const Walk& walk) const;

    const Scene& scene_;
    const RayScene& rays_;
    int bounces_;
    std::vector<std::optional<SurfaceFactors>> factors_;  // [material] of translucent ones
    std::vector<std::optional<Rgb>> diffuse_;
    std::vector<float> F_dr_;  // [material] of plastics, else 0
};

}  // namespace tallow
