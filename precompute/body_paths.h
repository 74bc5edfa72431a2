// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "common/exitance/exitance_field.h"
#include "common/geometry/ray_scene.h"
#include "common/lighting/light_paths.h"
#include "common/scene/scene.h"
#include "precompute/gather_patches.h"
#include "precompute/sampled_body.h"

namespace tallow {

/// A body's exitance under each light group alone; null where the group does not reach it.
using GroupFields = std::vector<std::unique_ptr<ExitanceField>>;

struct PathOptions {
    int bounces;
    int rays;                                 ///< from each patch
    std::vector<std::optional<Rgb>> diffuse;  ///< [object] bodies taken for diffuse surfaces
};

/// The paths that set out from the patches of one body, and the irradiance that they bring. They
/// are the same each time that they are asked for; where they met bodies is kept from one time to
/// the next, up to `most_kept` places, and only exitance is asked for anew.
class BodyPaths {
public:
    BodyPaths(const Scene& scene, const RayScene& rays, const SampledBody& body,
              const GatherPatches& patches, const PathOptions& options, std::size_t most_kept);

    /// Adds what reaches the patches [begin, end): by opaque surfaces, unless that is null, and by
    /// bodies that shine as fields[object] say, empty for opaque ones; by the body itself only if
    /// its material lets light re-enter. Sums are those of GatherPatches::spread().
    void gather(std::size_t begin, std::size_t end, const std::vector<GroupFields>& fields,
                std::vector<GroupIrradiance>* by_surfaces, std::vector<GroupIrradiance>& by_bodies);

private:
    /// Where a path sets out, and how its radiance counts.
    struct Start {
        std::uint32_t sample;
        Vec3 w;
        float weight;  // pi F_t / rays, 0 if nothing enters along it
        Vec3 w_refracted;
    };
    /// Of some patches; receivers are numbered from the first of a chunk.
    using Vertices = std::vector<std::vector<BodyVertex>>;  // [block]

    Start start(std::size_t patch, std::size_t ray) const;
    Vertices follow(std::size_t begin, std::size_t end,
                    std::vector<GroupIrradiance>* by_surfaces) const;
    void add_exitance(std::uint32_t object, const GroupFields& fields, std::size_t begin,
                      const Vertices& vertices, std::vector<GroupIrradiance>& by_bodies) const;
    static void add(GroupIrradiance& sums, std::size_t patch, const Start& start, Rgb L);

    const RayScene& rays_;
    const SampledBody& body_;
    const GatherPatches& patches_;
    LightPaths paths_;
    std::size_t rays_per_patch_, groups_;
    bool re_entry_;
    float eta_;
    std::size_t most_kept_;
    std::map<std::size_t, Vertices> kept_;  // by the first patch of a chunk
};

}  // namespace tallow
