// SPDX-License-Identifier: Apache-2.0
// Scene and tolerance -> what is computed. Each decision is a function of its own that leaves a
// line in the plan.
#include "common/exitance/scene_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/exitance/diffuse_limit.h"
#include "common/optics/fresnel.h"
#include "common/optics/phase.h"

namespace tallow {
namespace {

// A term may take this part of the tolerance when it is left out: sampling, hierarchy and noise
// have theirs.
constexpr double kShareOfTolerance = 1.0 / 3;

// Side of the smallest pixel on anything inside the box, mm: that of its nearest point as seen from
// anywhere on the lens. Blur only makes it larger.
float smallest_footprint(const Camera& camera, const Box& box) {
    const Vec3 nearest = glm::clamp(camera.position, box.low, box.high);
    const float distance =
        std::max(0.0f, glm::length(nearest - camera.position) - camera.lens_radius);
    return 2 * distance * std::tan(camera.fov / 2) / float(camera.height);
}

// Whether a ball around the box may be in the picture: its centre is no farther outside of the cone
// around the picture than its radius. What is seen from any place on a lens is within the lens'
// radius of a cone that is wider by radius / focus, so that the ball grows by it.
bool may_see(const Camera& camera, const Box& box) {
    const Vec3 center = 0.5f * (box.low + box.high);
    const float radius = 0.5f * glm::length(box.high - box.low) + camera.lens_radius;
    const Vec3 to_center = center - camera.position;
    const float distance = glm::length(to_center);
    if (!std::isfinite(radius) || distance <= radius) return true;
    const float half_height = std::tan(camera.fov / 2);
    const float half_width = half_height * float(camera.width) / float(camera.height);
    const float spread = camera.lens_radius > 0 ? camera.lens_radius / camera.focus : 0.0f;
    const float cone = std::atan(std::hypot(half_height, half_width) + spread);
    const Vec3 forward = glm::normalize(camera.look_at - camera.position);
    const float off = std::acos(std::clamp(glm::dot(to_center / distance, forward), -1.0f, 1.0f));
    return off <= cone + std::asin(radius / distance);
}

// How all cameras stand in all of their frames.
std::vector<Camera> all_views(const Scene& scene) {
    std::vector<Camera> views;
    for (const Camera& camera : scene.cameras)
        for (int frame = 0; frame < frame_count(camera); ++frame)
            views.push_back(camera_at(camera, frame));
    return views;
}

bool is_specular(const Material& material) {
    return !std::holds_alternative<DiffuseMaterial>(material.kind);
}

class Planner {
public:
    Planner(const Scene& scene, const SceneGeometry& geometry, double tolerance)
        : geometry_(geometry),
          tolerance_(tolerance),
          views_(all_views(scene)),
          result_{scene, {}, {}, {}} {}

    ScenePlan make() {
        result_.treatment.assign(scene().objects.size(), Treatment::samples);
        result_.diffuse.resize(scene().objects.size());
        plan_indirect_light();
        for (std::size_t object = 0; object < scene().objects.size(); ++object)
            if (subsurface(scene(), object) != nullptr) {
                plan_body(object);
                plan_diffusion(object);
            }
        for (Material& material : result_.scene.materials)
            if (auto* body = std::get_if<SubsurfaceMaterial>(&material.kind)) {
                plan_single_scattering(material.name, *body);
                plan_transmission(material.name, *body);
            }
        return std::move(result_);
    }

private:
    const Scene& scene() const { return result_.scene; }
    bool everything() const { return scene().settings.everything; }

    void decide(std::string subject, std::string term, bool computed, std::string how,
                std::string because, std::optional<double> bound = {}) {
        result_.plan.decisions.push_back({std::move(subject), std::move(term), computed,
                                          std::move(how), std::move(because), bound});
    }

    void plan_indirect_light() {
        const int bounces = indirect_bounces(scene());
        const bool forced = scene().settings.bounces.has_value();
        if (bounces > 0)
            decide("scene", "indirect light", true, fmt::format("{} bounces", bounces),
                   forced ? "forced" : "light can reach surfaces over other surfaces");
        else
            decide("scene", "indirect light", false, "0 bounces",
                   forced ? "forced" : "nothing reflects light onto anything",
                   forced ? std::nullopt : std::optional(0.0));
    }

    void plan_body(std::size_t object) {
        const SubsurfaceMaterial& material = *subsurface(scene(), object);
        const std::string name = fmt::format("objects[{}]", object);
        const Box box = bounding_box(geometry_.surfaces[object]);
        if (!everything() && is_unseen(object, box)) {
            result_.treatment[object] = Treatment::unseen;
            decide(name, "samples", false, "not sampled",
                   "outside of every camera's picture, and neither mirrors nor bounces show it", 0);
            return;
        }
        const bool absorbs_all = max_channel(material.medium.sigma_s_prime) == 0;
        float footprint = kInfinity;
        for (const Camera& camera : views_)
            footprint = std::min(footprint, smallest_footprint(camera, box));
        const double allowed = kShareOfTolerance * tolerance_;
        const bool forced = material.diffuse_limit != Switch::automatic;
        const bool diffuse =
            material.diffuse_limit == Switch::on ||
            (!forced && !everything() &&
             (absorbs_all || (footprint > 0 &&
                              is_diffuse_at(material.medium, material.model, footprint, allowed))));
        if (!diffuse) {
            decide(name, "samples", true, "sampled",
                   forced ? "forced"
                          : fmt::format("pixels of {:.3g} mm resolve a mean free path of {:.3g} mm",
                                        footprint, max_channel(material.medium.mean_free_path())));
            return;
        }
        result_.treatment[object] = Treatment::diffuse;
        result_.diffuse[object] = total_reflectance(material);
        decide(name, "samples", false, "as a diffuse surface",
               forced ? "forced"
               : absorbs_all
                   ? "the medium does not scatter"
                   : fmt::format("light spills out of pixels of {:.3g} mm by less", footprint),
               forced ? std::nullopt : std::optional(absorbs_all ? 0.0 : allowed));
    }

    void plan_diffusion(std::size_t object) {
        const SubsurfaceMaterial& material = *subsurface(scene(), object);
        if (!material.re_entry && indirect_bounces(scene()) > 0)
            decide(fmt::format("objects[{}]", object), "light that re-enters", false, "left out",
                   "forced");
        if (!material.boundary_elements || result_.treatment[object] != Treatment::samples) return;
        const std::string name = fmt::format("objects[{}]", object);
        if (encloses_volume(scene().objects[object].shape))
            decide(name, "diffusion in the body", true, "boundary elements",
                   "it is finite, and the profile stands for a half-space");
        else
            decide(name, "diffusion in the body", false, "not solved",
                   "a plane is the profile's half-space", 0.0);
    }

    static Rgb total_reflectance(const SubsurfaceMaterial& material) {
        Rgb total;
        for (int c = 0; c < 3; ++c)
            total[c] = float(
                make_profile(material.model, material.medium, c, Orders::all)->total_reflectance());
        return total;
    }

    bool is_unseen(std::size_t object, const Box& box) const {
        if (indirect_bounces(scene()) > 0) return false;  // it may light what is seen
        for (std::size_t other = 0; other < scene().objects.size(); ++other)
            if (other != object && is_specular(scene().materials[scene().objects[other].material]))
                return false;
        return std::ranges::none_of(views_,
                                    [&](const Camera& camera) { return may_see(camera, box); });
    }

    void plan_single_scattering(const std::string& name, SubsurfaceMaterial& material) {
        const std::string subject = "materials." + name;
        if (material.single_scattering != Switch::automatic) {
            decide(subject, "single scattering", material.single_scattering == Switch::on,
                   material.single_scattering == Switch::on ? marched(material) : "not marched",
                   "forced");
            return;
        }
        const double bound = single_scattering_bound(material);
        const double edges = bright_edge_share(material);
        const double allowed = kShareOfTolerance * tolerance_;
        const bool computed = everything() || bound > allowed || edges > allowed;
        material.single_scattering = computed ? Switch::on : Switch::off;
        const bool costly = !everything() && is_costly(material);
        if (costly) material.connection = Connection::straight;
        if (computed)
            decide(
                subject, "single scattering", true, marched(material),
                everything()
                    ? "everything is asked for"
                    : fmt::format("up to {:.2g} of the light; thin edges {:.2g} of the surface{}",
                                  bound, edges, costly ? "; refracted paths would take long" : ""));
        else
            decide(subject, "single scattering", false, "left to the profile",
                   "the phase function turns too little light back", std::max(bound, edges));
    }

    // Whether refracted paths take long. Roughly, on a busy machine: a place takes 2 us along a
    // straight line; along refracted paths from a quad 3 us on the bunny in marble (115 triangles
    // in reach) and 9 us in skin1 (930), and on the interpolated normals of scenes/demo.yaml 7 us
    // for each lamp. The limits are chosen, right before fast: bunny and armadillo in skin lack up
    // to 11 % of their light along straight lines. What pass two then takes is in docs/PLAN.md.
    bool is_costly(const SubsurfaceMaterial& material) const {
        constexpr double kFewInReach = 1200;
        constexpr std::size_t kFewTriangles = 1000;
        for (std::size_t object = 0; object < scene().objects.size(); ++object) {
            if (subsurface(scene(), object) != &material) continue;
            const Surface& surface = geometry_.surfaces[object];
            const auto* mesh = std::get_if<TriangleMesh>(&surface);
            if (mesh == nullptr || mesh->triangles.size() <= kFewTriangles) continue;
            if (!mesh->corner_normals.empty() ||
                triangles_in_reach(surface, material.medium) > kFewInReach)
                return true;
        }
        return false;
    }

    static const char* marched(const SubsurfaceMaterial& material) {
        return material.connection == Connection::exact ? "marched, light along refracted paths"
                                                        : "marched, light along straight lines";
    }

    /// Light that passes a body keeps e^(-sigma_t s); seen through it may be a lamp that is
    /// kBrightest times as bright as the picture.
    void plan_transmission(const std::string& name, SubsurfaceMaterial& material) {
        const std::string subject = "materials." + name;
        const bool forced = material.transmission != Switch::automatic;
        if (forced) {
            decide(subject, "transmission", material.transmission == Switch::on,
                   material.transmission == Switch::on ? "camera rays pass" : "not followed",
                   "forced");
            return;
        }
        constexpr double kBrightest = 1000;
        const double allowed = kShareOfTolerance * tolerance_;
        const double paths = std::log(kBrightest / std::max(allowed, 1e-12));
        const double bound = thin_share(material, paths);
        const bool computed = everything() || bound > allowed;
        material.transmission = computed ? Switch::on : Switch::off;
        const std::string thin = fmt::format(
            "{:.2g} of the surface is thinner than {:.2g} mean free paths", bound, paths);
        decide(subject, "transmission", computed, computed ? "camera rays pass" : "not followed",
               everything() ? "everything is asked for" : thin,
               computed ? std::nullopt : std::optional(bound));
    }

    /// Largest share of the surface of a body of this material where refracted rays may cross it
    /// within so many mean free paths of the clearest channel. In a ball their chords are longer
    /// than 2 r cos_c, with the critical angle; a half-space they do not cross; of others it is
    /// what lies near an edge.
    double thin_share(const SubsurfaceMaterial& material, double paths) const {
        const double eta = material.medium.eta;
        const double cos_c = std::sqrt(std::max(0.0, 1 - 1 / (eta * eta)));
        const double length = paths / double(min_channel(material.medium.sigma_t()));
        double share = 0;
        for (std::size_t object = 0; object < scene().objects.size(); ++object) {
            if (subsurface(scene(), object) != &material) continue;
            const Surface& surface = geometry_.surfaces[object];
            if (std::holds_alternative<PlaneSurface>(surface)) continue;
            const double thickness = smallest_extent(surface);
            const bool round = is_sphere(surface);
            share = std::max(share, round && thickness * cos_c > length
                                        ? 0.0
                                        : length / std::max(thickness, 1e-30));
        }
        return std::min(share, 1.0);
    }

    static double smallest_extent(const Surface& surface) {
        const Box box = bounding_box(surface);
        const Vec3 size = box.high - box.low;
        return double(std::min({size.x, size.y, size.z}));
    }

    /// Not an ellipsoid.
    static bool is_sphere(const Surface& surface) {
        const auto* sphere = std::get_if<SphereSurface>(&surface);
        if (sphere == nullptr) return false;
        const glm::mat3 gram = glm::transpose(sphere->to_world.linear) * sphere->to_world.linear;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                if (std::abs(gram[i][j] - (i == j ? gram[0][0] : 0)) > 1e-4f * gram[0][0])
                    return false;
        return true;
    }

    /// Share of the surface near edges so thin that light may pass them scattered once, forward:
    /// within 4 / sigma_t of a silhouette of the smallest body of this material.
    double bright_edge_share(const SubsurfaceMaterial& material) const {
        double share = 0;
        for (std::size_t object = 0; object < scene().objects.size(); ++object) {
            if (subsurface(scene(), object) != &material) continue;
            const double thickness = smallest_extent(geometry_.surfaces[object]);
            share = std::max(share, 4 / (double(min_channel(material.medium.sigma_t())) *
                                         std::max(thickness, 1e-30)));
        }
        return std::min(share, 1.0);
    }

    const SceneGeometry& geometry_;
    double tolerance_;
    std::vector<Camera> views_;
    ScenePlan result_;
};

}  // namespace

double single_scattering_bound(const SubsurfaceMaterial& material) {
    const Medium& medium = material.medium;
    const double eta = medium.eta, cos_c = std::sqrt(std::max(0.0, 1 - 1 / (eta * eta)));
    if (cos_c == 0) return 1;  // matched indices: grazing light runs along the surface
    // Light is turned by an angle in [pi - 2 asin(1 / eta), pi].
    const double cos_least = std::cos(std::numbers::pi - 2 * std::asin(1 / eta));
    const double p_max = std::max(double(henyey_greenstein(medium.g, float(cos_least))),
                                  double(henyey_greenstein(medium.g, -1.0f)));
    // Of L_1 / (M T(w_o) / pi) the transmittances cancel, but for the norm of T.
    const double norm = diffuse_fresnel_transmittance(eta);
    double bound = 0;
    for (int c = 0; c < 3; ++c) {
        const double total =
            make_profile(material.model, medium, c, Orders::all)->total_reflectance();
        const double once =
            double(medium.albedo()[c]) * p_max * std::numbers::pi * norm / (2 * eta * eta * cos_c);
        if (once > 0) bound = std::max(bound, total > 0 ? std::min(1.0, once / total) : 1.0);
    }
    return bound;
}

double triangles_in_reach(const Surface& surface, const Medium& medium) {
    const auto* mesh = std::get_if<TriangleMesh>(&surface);
    if (mesh == nullptr) return 0;
    double area = 0;
    for (std::size_t t = 0; t < mesh->triangles.size(); ++t) area += triangle_area(*mesh, t);
    const double reach = 3 / double(min_channel(medium.sigma_t()));
    const double all = double(mesh->triangles.size());
    return std::min(all, all * std::numbers::pi * reach * reach / std::max(area, 1e-30));
}

ScenePlan plan_scene(const Scene& scene, const SceneGeometry& geometry, double tolerance) {
    return Planner(scene, geometry, tolerance).make();
}

}  // namespace tallow
