// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/stats.h"
#include "common/cloud/cache_io.h"
#include "common/exitance/body_exitance.h"
#include "common/exitance/exit_factor.h"
#include "common/geometry/ray_scene.h"
#include "common/scene/scene_geometry.h"
#include "render/inner_light.h"
#include "render/refracted_connection.h"
#include "render/shade.h"

namespace tallow {

/// What a BodyExitance is made from, for one body of a cache.
struct ExitanceSource {
    Model model;
    Medium medium;
    Orders orders;
    bool shifts, boundary_elements;
    Exit exit;
    float tolerance;  // of the scene's settings: the sums' accuracy must not change the solve
};

/// Diffusion in a body, of each light group at the scale 1, so that other scales need no solve.
struct GroupDiffusion {
    Rgb indirect_gain;
    std::vector<std::optional<BodyDiffusion::Solution>> of_group;  // empty: never lit so far
};

/// A translucent body ready to be shaded.
struct PreparedBody {
    const SubsurfaceMaterial* material;
    SurfaceFactors factors;
    ExitanceSource source;
    BodyExitance exitance_of;
    GroupDiffusion diffusion;
    DiffusionReport report;  // of the diffusion of all groups together
    ExitanceField exitance;
    int march_steps;                                  // of a pixel; see march_steps_of_pixel()
    std::optional<RefractedConnections> connections;  // where single scattering is to be exact
    std::optional<InnerLight> inner;                  // where it matters to single scattering
    LampPaths lamps = LampPaths::sky_drawn;
};

/// What every picture of a scene has in common, whatever its camera: the ray tracer's hierarchy,
/// and for each body the kernels, and the trees of the light that enters it. It is made once, and
/// then render_image() may be called any number of times.
class PreparedScene {
public:
    /// `scene` is that of a ScenePlan, `diffuse` [object] its reflectances, whose objects are
    /// opaque whatever the cache has of them; empty if there are none. `geometry` and what `cache`
    /// points into must outlive this, and the cache must be one of the scene. Adds to the phases
    /// bvh, octree and diffusion; diffusion counts `clusters`, the `diffusion_iterations` of GMRES
    /// and, among the errors, `objects[i].diffusion`, and leaves its decisions in the plan.
    PreparedScene(Scene scene, const SceneGeometry& geometry, CacheView cache,
                  ExitanceAccuracy accuracy, const std::vector<std::optional<Rgb>>& diffuse,
                  Stats& stats);

    /// Takes other values for what the cache does not hold: scales of light groups, coefficients of
    /// media, colours, settings, accuracy. Shapes, places, lights and what belongs to the cache's
    /// fingerprint must be as before; see require_fingerprint(). Only the exitance is made again,
    /// in the phase octree, and kernels and diffusion where media are new; scales of groups need no
    /// solve. If it throws, it has to be called again.
    void change(Scene scene, ExitanceAccuracy accuracy,
                const std::vector<std::optional<Rgb>>& diffuse, Stats& stats);

    PreparedScene(const PreparedScene&) = delete;
    PreparedScene& operator=(const PreparedScene&) = delete;

    const Scene& scene() const { return scene_; }
    /// The same with the lights switched off whose group has the scale 0: they get no rays.
    const Scene& lit() const { return lit_; }
    const Surface& surface(std::uint32_t object) const { return geometry_.surfaces[object]; }
    const RayScene& rays() const { return rays_; }
    /// The body, or null for an object that is shaded as an opaque surface.
    const PreparedBody* body(std::uint32_t object) const {
        return bodies_[object] ? &*bodies_[object] : nullptr;
    }
    /// [object] whether camera rays pass it; see find_primary_hits().
    const std::vector<bool>& clear() const { return clear_; }
    const ReflectedLight& reflected() const { return *reflected_; }
    Rgb albedo_of(std::uint32_t object) const { return albedos_[scene_.objects[object].material]; }
    /// What people are to know of the solves, one line each; see diffusion_warning().
    std::vector<std::string> warnings() const;
    /// Whether surfaces reflect light that was reflected before.
    bool has_indirect_light() const { return indirect_; }
    const ExitanceAccuracy& accuracy() const { return accuracy_; }

private:
    void prepare(Scene scene, const std::vector<std::optional<Rgb>>& diffuse, Stats& stats);
    void prepare_bodies(const std::vector<std::optional<Rgb>>& diffuse, Stats& stats);
    std::vector<bool> find_clear_bodies() const;
    void follow_inner_light(const BodyView& view, PreparedBody& body, Stats& stats) const;
    PreparedBody prepare_body(const BodyView& view, std::optional<PreparedBody>& before,
                              Stats& stats) const;
    BodyDiffusion::Solution solve(const BodyView& view, const BodyExitance& exitance_of,
                                  GroupDiffusion& diffusion) const;
    void report_diffusion(Stats& stats) const;

    const SceneGeometry& geometry_;
    CacheView cache_;
    ExitanceAccuracy accuracy_;
    RayScene rays_;
    Scene scene_, lit_;
    std::vector<std::optional<PreparedBody>> bodies_;  // [object]
    std::optional<ReflectedLight> reflected_;
    std::vector<Rgb> albedos_;  // [material]
    std::vector<bool> clear_;   // [object]
    bool indirect_ = false;
};

}  // namespace tallow
