// SPDX-License-Identifier: Apache-2.0
// Whole renders at the ends of what scenes may say: each against the same scene in ordinary terms.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>

#include "common/cloud/cache_io.h"
#include "common/exitance/exitance_field.h"
#include "common/image/image.h"
#include "precompute/precompute.h"
#include "render/render_image.h"
#include "tests/hard_cases/hard_cases.h"
#include "tests/support/scene_text.h"
#include "tests/support/test_files.h"

namespace tallow::test {
namespace {

/// A small lit scene whose every length, coefficient, place and radiance can be changed.
struct SceneTerms {
    double scale = 1;   // of lengths; coefficients go with its inverse
    double offset = 0;  // mm along x
    double radiance = 1;
    double spacing = 0.3;
    double sigma = 1;              // of the coefficients alone
    std::string single = "exact";  // single_scattering
    std::string shape = "shape: sphere, radius: {}, center: [{}, 0, 0]";

    Scene scene() const {
        const auto x = [&](double value) { return fmt::format("{:.9g}", value * scale + offset); };
        const auto l = [&](double value) { return fmt::format("{:.9g}", value * scale); };
        const auto c = [&](double value) { return fmt::format("{:.9g}", value * sigma / scale); };
        return scene_of(fmt::format(
            "cameras: {{main: {{type: perspective, position: [{}, {}, {}], look_at: [{}, 0, 0], "
            "fov_deg: 30, resolution: [16, 16]}}}}\n"
            "materials: {{wax: {{type: subsurface, sigma_a: [{}, {}, {}], sigma_s_prime: [{}, {}, "
            "{}], eta: 1.4, single_scattering: {}}}}}\n"
            "objects: [{{material: wax, {}}}]\n"
            "lights: [{{type: quad, position: [{}, {}, 0], look_at: [{}, 0, 0], size: [{}, {}], "
            "radiance: {:g}}}]\n"
            "settings: {{samples: 1, light_samples: 4, tolerance: 0}}\n",
            x(0.5), l(3), l(8), x(0), c(0.02), c(0.1), c(0.3), c(1), c(2), c(3), single,
            fmt::format(fmt::runtime(shape), l(2), x(0)), x(4), l(6), x(0), l(3), l(3), radiance));
    }
};

std::vector<float> render(const SceneTerms& terms) {
    const Scene scene = terms.scene();
    Progress quiet(true);
    Stats stats;
    const auto cache = test_out("cache.tallow");
    precompute(scene, {{float(terms.spacing * terms.scale), {}}}, cache, quiet, stats);
    const MappedCache mapped(cache);
    const SceneGeometry geometry = load_geometry(scene, stats);
    const PreparedScene world(scene, geometry, mapped.view(), {scene.settings.tolerance}, {},
                              stats);
    const Image image = render_image(world, scene.cameras.front(),
                                     {{0, 0, 16, 16}, scene.settings.samples}, quiet, stats);
    std::vector<float> values;
    for (const char* name : {"R", "G", "B"}) {
        const std::vector<float>* channel = image.find_channel(name);
        values.insert(values.end(), channel->begin(), channel->end());
    }
    return values;
}

// relRMSE of `picture` / `gain` against `expected`.
double difference(const std::vector<float>& picture, const std::vector<float>& expected,
                  double gain = 1) {
    double error2 = 0, mean = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
        error2 += std::pow(double(picture[i]) / gain - expected[i], 2);
        mean += expected[i];
    }
    return std::sqrt(error2 * double(expected.size())) / mean;
}

// Radiance is in 1/mm^2 of the light's own surface: it does not scale with lengths. Sums over the
// sources of diffusion do, in steps: their groups follow a unit that is a power of two, and their
// tolerance is 1e-2. Measured 1.1e-3.
TEST(HardScenes, ScaledWithTheirMedia) {
    const auto ordinary = render({});
    for (double scale : {1e-3, 1e3, 1e6}) {
        SceneTerms terms;
        terms.scale = scale;
        expect_within(fmt::format("scene x {:g}, coefficients / {:g}", scale, scale),
                      "the scene at scale 1, relRMSE", difference(render(terms), ordinary), 2e-3);
    }
}

// Measured along straight lines 6e-5. Along refracted paths 1.7e-3, of which one place makes most:
// it lies near a caustic of the ball, where density is the inverse root of the distance, so that
// rounding shows.
TEST(HardScenes, FarFromTheOrigin) {
    for (const bool straight : {true, false}) {
        SceneTerms terms;
        terms.single = straight ? "straight" : "exact";
        const auto ordinary = render(terms);
        for (double offset : {1e3, 1e6}) {
            terms.offset = offset;
            expect_within(fmt::format("scene moved {:g} mm, {}", offset, terms.single),
                          "the scene at the origin, relRMSE", difference(render(terms), ordinary),
                          straight ? 1e-3 : 2.5e-3);
        }
    }
}

TEST(HardScenes, ExtremeRadiance) {
    const auto ordinary = render({});
    for (double radiance : {1e-30, 1e30}) {
        SceneTerms terms;
        terms.radiance = radiance;
        expect_within(fmt::format("radiance {:g}", radiance), "radiance 1, relRMSE",
                      difference(render(terms), ordinary, radiance), 1e-5);
    }
}

TEST(HardScenes, NoLightNoPicture) {
    SceneTerms terms;
    terms.radiance = 0;
    double most = 0;
    for (float value : render(terms)) most = std::max(most, std::abs(double(value)));
    expect_within("all lights dark", "0, absolute", most, 0);
}

// A cube whose file repeats every vertex, holds a face twice, faces of no area and a sliver.
TEST(HardScenes, DirtyMesh) {
    const std::string vertices =
        "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n";
    const auto faces = [](int first) {
        std::string text;
        for (const auto& [a, b, c] : std::vector<std::array<int, 3>>{{1, 4, 3},
                                                                     {1, 3, 2},
                                                                     {5, 6, 7},
                                                                     {5, 7, 8},
                                                                     {1, 2, 6},
                                                                     {1, 6, 5},
                                                                     {4, 8, 7},
                                                                     {4, 7, 3},
                                                                     {1, 5, 8},
                                                                     {1, 8, 4},
                                                                     {2, 3, 7},
                                                                     {2, 7, 6}})
            text += fmt::format("f {} {} {}\n", a + first, b + first, c + first);
        return text;
    };
    write_bytes(test_out("clean.obj"), vertices + faces(0));
    // The second copy of the vertices is used by the faces; the first by the rubbish.
    write_bytes(test_out("dirty.obj"), vertices + vertices + "f 1 2 1\nf 1 2 2\nf 3 3 3\n" +
                                           faces(8) + "f 9 12 11\nv 0 0 0\n");
    SceneTerms clean, dirty;
    clean.shape =
        fmt::format("shape: mesh, normals: flat, file: \"{}\"", test_out("clean.obj").string());
    dirty.shape =
        fmt::format("shape: mesh, normals: flat, file: \"{}\"", test_out("dirty.obj").string());
    expect_within("zero-area, repeated and doubled faces, coincident vertices",
                  "the clean mesh, relRMSE", difference(render(dirty), render(clean)), 1e-3);
}

// Pass two on samples made by hand: the kernel at r = 0, coincident samples, none at all.
TEST(HardScenes, ShadingPointOnASample) {
    const Medium medium{Rgb(0.1f), Rgb(1), 0, 1.3f};
    const auto profile = make_profile(Model::dipole, medium, 0, Orders::all);
    for (std::uint32_t count : {0u, 1u, 100u}) {
        LitSamples samples;
        samples.position.assign(count, Vec3(1, 2, 3));
        samples.E_t.assign(count, Rgb(2));
        samples.w_i.assign(count, Vec3(0, -1, 0));
        samples.area.assign(count, 0.5f);
        if (count > 0) samples.nodes = {{0, count, 1}};
        const ExitanceField field(samples, tabulate_profiles(Model::dipole, medium, Orders::all),
                                  ExitanceAccuracy{});
        const std::vector<ExitancePoint> point = {{Vec3(1, 2, 3), Vec3(0, 1, 0), Vec3(0, 1, 0)}};
        const Rgb exitance = field.gather(point).M[0];
        const double expected = count * (*profile)(0);
        expect_within(
            fmt::format("shading point on {} coincident samples", count), "closed form E A R(0)",
            count == 0 ? double(exitance.r) : std::abs(double(exitance.r) / expected - 1), 3e-5);
    }
}

// A spacing far above the body's size: a handful of samples, finite pixels.
TEST(HardScenes, HardlyAnySamples) {
    SceneTerms terms;
    terms.spacing = 100;
    double violation = 0;
    for (float value : render(terms))
        if (!(value >= 0) || !std::isfinite(value)) violation = NAN;
    expect_within("spacing 50 times the body's radius", "finite and >= 0", violation, 0);
}

TEST(HardScenes, ExtremeDensity) {
    for (double sigma : {1e-5, 1e5}) {
        SceneTerms terms;
        terms.sigma = sigma;
        double violation = 0;
        for (float value : render(terms))
            if (!(value >= 0) || !std::isfinite(value)) violation = NAN;
        expect_within(fmt::format("coefficients x {:g}", sigma), "finite and >= 0", violation, 0);
    }
}

}  // namespace
}  // namespace tallow::test
