// SPDX-License-Identifier: Apache-2.0
// Reflected light against rooms whose balance is known, and against sums over surfaces.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/base/rng.h"
#include "common/lighting/cosine_direction.h"
#include "common/lighting/direct_light.h"
#include "common/lighting/light_paths.h"
#include "common/optics/fresnel.h"
#include "precompute/build_octree.h"
#include "precompute/choose_light_samples.h"
#include "precompute/gather_indirect.h"
#include "tests/support/ball_mesh.h"
#include "tests/support/scenes.h"
#include "tests/support/shapes.h"

namespace tallow {
namespace {

using test::lit_scene;

void add_object(Scene& scene, std::vector<Surface>& surfaces, const Material& material,
                const Surface& surface) {
    scene.objects.push_back({SphereShape{1}, std::uint32_t(scene.materials.size()), {}, ""});
    scene.materials.push_back(material);
    surfaces.push_back(surface);
}

struct MeanAndError {
    double mean, error;  // standard error
};

/// Irradiance by what `paths` bring back to a point, with cosine-distributed directions.
MeanAndError irradiance(const Scene& scene, const std::vector<Surface>& surfaces, Vec3 x, Vec3 n,
                        int bounces, int count) {
    const RayScene rays(surfaces);
    const LightPaths paths(scene, rays, bounces);
    const Frame frame = make_frame(n);
    double sum = 0, squares = 0;
    for (int k = 0; k < count; ++k) {
        const Vec2 u = sobol_2d(std::uint32_t(k), 1);
        const Vec3 w = cosine_direction(frame, u);
        std::vector<Rgb> L(scene.groups.size());
        std::vector<BodyVertex> bodies;
        paths.follow({rays.offset_origin(x, n, n), w}, 0, mix_bits(std::uint64_t(k)),
                     LightPaths::Collect::everything, L, bodies);
        const double E = std::numbers::pi * double(L[0].g);
        sum += E, squares += E * E;
    }
    const double mean = sum / count;
    return {mean, std::sqrt(std::max(0.0, squares / count - mean * mean) / count)};
}

// In a ball of diffuse walls every point sees every other under the same form factor: a lamp in the
// middle gives E = I / R^2, and each reflection gives the same times rho.
TEST(IndirectLight, ClosedWhiteRoom) {
    for (const float rho : {0.5f, 0.9f})
        for (const int bounces : {1, 2, 5}) {
            Scene scene = lit_scene({PointLight{Vec3(0), Rgb(100)}});
            std::vector<Surface> surfaces;
            add_object(scene, surfaces, {"wall", DiffuseMaterial{Rgb(rho)}},
                       test::ball(Vec3(0), 10));
            double expected = 0;
            for (int k = 1; k <= bounces; ++k) expected += std::pow(double(rho), k);
            const auto E =
                irradiance(scene, surfaces, {0, 3, 4}, {0, 0.6f, 0.8f}, bounces, 1 << 14);
            // Four standard errors: 6e-5 to fail by chance.
            EXPECT_NEAR(E.mean, expected, 4 * E.error + 1e-5) << rho << ", " << bounces;
            EXPECT_LT(E.error, 0.02 * expected);
        }
}

// Two walls that take no light, under a sky of radiance 1: whatever is missing of the sky is made
// up for by the walls, so that the irradiance is pi as if they were not there. For plastic, coat
// and base together take nothing if the base is white.
TEST(IndirectLight, WhiteCornerUnderTheSky) {
    for (const Material& white : {Material{"white", DiffuseMaterial{Rgb(1)}},
                                  Material{"white", PlasticMaterial{Rgb(1), 1.5f}}}) {
        Scene scene = lit_scene({EnvironmentLight{Rgb(1)}});
        std::vector<Surface> surfaces;
        add_object(scene, surfaces, white, PlaneSurface{Vec3(0), {0, 1, 0}});
        add_object(scene, surfaces, white, PlaneSurface{Vec3(0), {1, 0, 0}});
        const Vec3 x(1, 0, 0), n(0, 1, 0);
        const RayScene rays(surfaces);
        std::vector<Rgb> direct(1);
        add_direct_light(scene, rays, {x, n, n, 1}, 1 << 14, {}, direct);
        const auto indirect = irradiance(scene, surfaces, x, n, 64, 1 << 15);
        EXPECT_GT(indirect.mean, 0.4);  // a quarter of the sky is hidden, near the horizon
        EXPECT_NEAR(double(direct[0].g) + indirect.mean, std::numbers::pi,
                    4 * indirect.error + 2e-3);
    }
}

// A mirror doubles a lamp that shines along it.
TEST(IndirectLight, LampInAMirror) {
    Scene scene = lit_scene({SphereLight{{0, 5, 10}, 1, Rgb(1)}});
    std::vector<Surface> surfaces;
    add_object(scene, surfaces, {"mirror", MirrorMaterial{Rgb(0.5f)}},
               PlaneSurface{Vec3(0), {0, 1, 0}});
    // At (0, 5, 0), facing +z: the mirrored lamp is a sphere around (0, -5, 10).
    const double d2 = 10 * 10 + 10 * 10, cosine = 10 / std::sqrt(d2);
    const double expected = 0.5 * std::numbers::pi / d2 * cosine;
    const auto E = irradiance(scene, surfaces, {0, 5, 0}, {0, 0, 1}, 1, 1 << 18);
    EXPECT_NEAR(E.mean, expected, 4 * E.error);
    EXPECT_LT(E.error, 0.05 * expected);
}

SampledBody sampled(const Scene& scene, const std::vector<Surface>& surfaces, const RayScene& rays,
                    std::uint32_t object, float spacing) {
    Progress progress(true);
    SampledBody body{object,
                     spacing,
                     surface_area(surfaces[object]),
                     sample_surface(surfaces[object], spacing),
                     {},
                     {},
                     {}};
    body.nodes = build_octree(body.samples.position);
    body.direct =
        gather_irradiance(scene, rays, body.samples, subsurface(scene, object)->medium.eta,
                          equal_light_samples(scene, 1), progress);
    return body;
}

// Exitance of one body on another, against the sum over the samples of both. The other body is in
// the dark but for that. The lamp is parallel light, which no mirror shows.
TEST(IndirectLight, OneBodyShinesOnAnother) {
    Scene scene = lit_scene({DirectionalLight{glm::normalize(Vec3(1, 0, -0.2f)), Rgb(1)}});
    scene.settings.light_samples = 1;
    std::vector<Surface> surfaces;
    SubsurfaceMaterial wax;
    wax.medium = {Rgb(0.05f), Rgb(2), 0, 1.3f};
    wax.model = Model::dipole;
    const Vec3 center(6, 0, 0);
    add_object(scene, surfaces, {"a", wax}, test::ball(Vec3(0), 2));
    add_object(scene, surfaces, {"b", wax}, test::ball(center, 2));
    add_object(scene, surfaces, {"screen", DiffuseMaterial{Rgb(0)}},
               DiscSurface{{glm::mat3(2.2f), {3, 0, 100}}});  // far away, in nobody's light
    const RayScene rays(surfaces);
    std::vector<SampledBody> bodies = {sampled(scene, surfaces, rays, 0, 0.25f),
                                       sampled(scene, surfaces, rays, 1, 0.25f)};
    const std::vector<SampledBody> before = bodies;
    Progress progress(true);
    Checkpoint checkpoint("unused.part", {}, {.resume = false, .seconds = 1e9});
    gather_indirect(scene, rays, bodies, {1, 64, 1e-3f}, checkpoint, progress);
    checkpoint.finish();

    const auto profile = make_profile(wax.model, wax.medium, 1, Orders::all);
    const SurfaceFactors factors = surface_factors(wax);
    const SurfaceSamples &a = before[0].samples, &b = before[1].samples;
    std::vector<double> M(a.size());
    for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t j = 0; j < a.size(); ++j)
            M[i] += double(before[0].direct[0].E_t[j].g) * double(a.area[j]) *
                    (*profile)(double(length2(a.position[i] - a.position[j])));
    double expected = 0, found = 0;
    for (std::size_t i = 0; i < b.size(); ++i) {
        found += double(bodies[1].indirect[0].E_t[i].g) * double(b.area[i]);
        for (std::size_t j = 0; j < a.size(); ++j) {
            const Vec3 d = a.position[j] - b.position[i];
            const Vec3 w = glm::normalize(d);
            const float cos_i = glm::dot(w, b.normal[i]), cos_o = -glm::dot(w, a.normal[j]);
            if (cos_i <= 0 || cos_o <= 0) continue;
            const double L = M[j] / std::numbers::pi * double(exit_factor(factors, cos_o));
            expected += double(b.area[i]) * double(a.area[j]) * L *
                        double(fresnel_transmittance(1.3f, cos_i) * cos_i * cos_o / length2(d));
        }
    }
    EXPECT_GT(expected, 0);
    // Measured: 0.1 %. The quadrature is good to the square of spacing / distance.
    EXPECT_NEAR(found / expected, 1, 0.005);
}

// Two balls of one body light each other: without re-entry nothing of that is left, and what
// another body sends still is.
TEST(IndirectLight, ReEntryCanBeSwitchedOff) {
    const auto flux_on = [](bool re_entry, std::uint32_t receiver) {
        Scene scene = lit_scene({DirectionalLight{glm::normalize(Vec3(1, 0, -0.2f)), Rgb(1)}});
        scene.settings.light_samples = 1;
        std::vector<Surface> surfaces;
        SubsurfaceMaterial wax;
        wax.medium = {Rgb(0.05f), Rgb(2), 0, 1.3f};
        wax.model = Model::dipole, wax.re_entry = re_entry;
        TriangleMesh pair = test::ball_mesh(3, [](Vec3) { return 2.0f; });  // two balls of one body
        TriangleMesh other = pair;
        for (Vec3& x : other.vertices) x.x += 4.2f;
        const auto shift = std::uint32_t(pair.vertices.size());
        pair.vertices.insert(pair.vertices.end(), other.vertices.begin(), other.vertices.end());
        for (const auto& [a, b, c] : other.triangles)
            pair.triangles.push_back({a + shift, b + shift, c + shift});
        add_object(scene, surfaces, {"a", wax}, pair);
        add_object(scene, surfaces, {"b", wax}, test::ball(Vec3(-6, 0, 1), 2));
        const RayScene rays(surfaces);
        std::vector<SampledBody> bodies = {sampled(scene, surfaces, rays, 0, 0.4f),
                                           sampled(scene, surfaces, rays, 1, 0.4f)};
        Progress progress(true);
        Checkpoint checkpoint("unused.part", {}, {.resume = false, .seconds = 1e9});
        gather_indirect(scene, rays, bodies, {1, 64, 1e-3f}, checkpoint, progress);
        checkpoint.finish();
        double flux = 0;
        const SampledBody& body = bodies[receiver];
        for (std::size_t i = 0; i < body.samples.size(); ++i)
            flux += double(body.indirect[0].E_t[i].g * body.samples.area[i]);
        return flux;
    };
    EXPECT_GT(flux_on(false, 0), 0);
    EXPECT_LT(flux_on(false, 0), 0.3 * flux_on(true, 0));
    EXPECT_EQ(flux_on(false, 1), flux_on(true, 1));
}

}  // namespace
}  // namespace tallow
