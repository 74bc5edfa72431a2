// SPDX-License-Identifier: Apache-2.0
// Both programs and the file between them, as a user runs them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "common/base/vec.h"
#include "common/image/exr_io.h"
#include "common/optics/dipole.h"
#include "common/optics/fresnel.h"
#include "tests/cli/pyramid.h"
#include "tests/support/process.h"
#include "tests/support/test_files.h"

namespace tallow::test {
namespace {

// Uniform irradiance on a large translucent plane: the exitance in its middle is E_t R_total.
// The opening's radius is 16 diffusion lengths; measured error 0.04 %.
TEST(Pipeline, UniformlyLitHalfSpaceGivesTheTotalReflectance) {
    const path folder = fresh_folder();
    write_bytes(folder / "scene.yaml", R"(
cameras:
  main: {type: perspective, position: [0, 4, 0], look_at: [0, 0, 0], up: [0, 0, 1], fov_deg: 10, resolution: [4, 4]}
materials:
  ground: {type: subsurface, sigma_s_prime: [2, 2, 2], sigma_a: [0.5, 0.3, 0.2], eta: 1.3, model: dipole}
objects:
  - {shape: plane, point: [0, 0, 0], normal: [0, 1, 0], radius: 14, material: ground}
lights:
  - {type: environment, radiance: 1}
settings: {tolerance: 0, samples: 1, light_samples: 64}
)");
    make_cache(folder, {"--spacing", "0.14"});
    const Result result = render_to(folder, "image.exr", {"--aovs", "exitance"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const Medium medium{{0.5f, 0.3f, 0.2f}, {2, 2, 2}, 0, 1.3f};
    const double E_t = std::numbers::pi * diffuse_fresnel_transmittance(1.3);
    for (int c = 0; c < 3; ++c) {
        const auto profile = dipole_channel<double>(medium, c, mismatch_A(1.3));
        const double expected = E_t * total_reflectance(profile);
        for (float M : channel(folder / "image.exr", std::string("exitance.") + "RGB"[c]))
            EXPECT_NEAR(M, expected, 0.002 * expected) << c;
    }
}

TEST(Pipeline, OneThreadAndManyGiveTheSameBytes) {
    const path one = pyramid_folder("1"), two = pyramid_folder("2");
    make_cache(one, {"--threads", "1"});
    make_cache(two, {"--threads", "2"});
    EXPECT_EQ(read_bytes(one / "scene.tallow"), read_bytes(two / "scene.tallow"));
    ASSERT_EQ(render_to(one, "image.png", {"--threads", "1"}).exit_code, 0);
    ASSERT_EQ(render_to(two, "image.png", {"--threads", "2"}).exit_code, 0);
    EXPECT_EQ(read_bytes(one / "image.png"), read_bytes(two / "image.png"));

    // The EXR names its scene's path in its metadata: render both from one folder.
    ASSERT_EQ(render_to(one, "a.exr", {"--aovs", "all", "--threads", "1"}).exit_code, 0);
    ASSERT_EQ(render_to(one, "b.exr", {"--aovs", "all", "--threads", "2"}).exit_code, 0);
    EXPECT_EQ(read_bytes(one / "a.exr"), read_bytes(one / "b.exr"));
}

TEST(Pipeline, RadianceLayersSumToThePicture) {
    const path folder = pyramid_folder();
    make_cache(folder);
    ASSERT_EQ(render_to(folder, "image.exr", {"--aovs", "all"}).exit_code, 0);
    for (const char* c : {"R", "G", "B"}) {
        const std::vector<float> picture = channel(folder / "image.exr", c);
        std::vector<double> sum(picture.size(), 0);
        for (const char* layer :
             {"multiple", "single", "diffuse", "specular", "transmitted", "emission"}) {
            const auto values = channel(folder / "image.exr", std::string(layer) + "." + c);
            double total = 0;
            for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += values[i], total += values[i];
            EXPECT_GT(total, 0) << layer;
        }
        for (std::size_t i = 0; i < sum.size(); ++i) EXPECT_NEAR(picture[i], sum[i], 1e-5);
        // What scattered is seen directly and in mirrors.
        const auto layer = [&](const std::string& name) {
            return channel(folder / "image.exr", name + "." + c);
        };
        const auto scattered = layer("scattered"), multiple = layer("multiple"),
                   single = layer("single"), specular = layer("specular");
        for (std::size_t i = 0; i < sum.size(); ++i) {
            EXPECT_GE(scattered[i], multiple[i] + single[i] - 1e-5);
            EXPECT_LE(scattered[i], multiple[i] + single[i] + specular[i] + 1e-5);
        }
    }
}

TEST(Pipeline, ACropIsThatPartOfTheWholeImage) {
    const path folder = pyramid_folder();
    make_cache(folder);
    // With the plain sum; the hierarchy groups neighbours, and a crop has others. So do the paths
    // of single scattering, which are found together and differ in their last bits.
    ASSERT_EQ(render_to(folder, "whole.exr", {"--tolerance", "0", "--samples", "1"}).exit_code, 0);
    ASSERT_EQ(render_to(folder, "part.exr",
                        {"--tolerance", "0", "--samples", "1", "--crop", "10,5,30,25"})
                  .exit_code,
              0);
    const auto whole = channel(folder / "whole.exr", "G"), part = channel(folder / "part.exr", "G");
    ASSERT_EQ(part.size(), 400u);
    for (std::size_t y = 0; y < 20; ++y)
        for (std::size_t x = 0; x < 20; ++x)
            ASSERT_FLOAT_EQ(part[20 * y + x], whole[48 * (y + 5) + x + 10]);
}

// relRMSE of the exitance of fast.exr against plain.exr, where there is any.
double exitance_error(const path& folder) {
    double error2 = 0, mean = 0, count = 0;
    for (const char* name : {"exitance.R", "exitance.G", "exitance.B"}) {
        const auto plain = channel(folder / "plain.exr", name);
        const auto fast = channel(folder / "fast.exr", name);
        for (std::size_t i = 0; i < plain.size(); ++i) {
            if (plain[i] == 0) continue;
            error2 += std::pow(double(fast[i]) - plain[i], 2);
            mean += plain[i];
            ++count;
        }
    }
    EXPECT_GT(count, 300);
    return std::sqrt(error2 / count) / (mean / count);
}

TEST(Pipeline, HierarchyErrorIsWithinTheTolerance) {
    const path folder = pyramid_folder();
    make_cache(folder, {"--spacing", "0.12", "--bounces", "0"});
    ASSERT_EQ(render_to(folder, "plain.exr",
                        {"--tolerance", "0", "--aovs", "exitance", "--set", "settings.bounces=0"})
                  .exit_code,
              0);
    for (const char* criterion : {"error", "solid-angle"}) {
        const std::vector<std::string> flags = {
            "--tolerance", "0.01",     "--criterion", criterion,
            "--aovs",      "exitance", "--set",       "settings.bounces=0"};
        ASSERT_EQ(render_to(folder, "fast.exr", flags).exit_code, 0);
        const double error = exitance_error(folder);
        EXPECT_GT(error, 0) << criterion;
        EXPECT_LT(error, 0.01) << criterion;
    }
}

// The setting decides; auto takes the tolerance.
TEST(Pipeline, DepthsOfSingleScatteringCanBeSet) {
    const path folder = pyramid_folder();
    make_cache(folder, {"--set", "settings.bounces=0"});
    const auto single = [&](const std::string& depths) {
        const std::string image = "depths_" + depths + ".exr";
        const Result result =
            render_to(folder, image,
                      {"--aovs", "single", "--samples", "1", "--tolerance", "0.01", "--set",
                       "settings.bounces=0", "--set", "materials.stone.single_scattering=on",
                       "--set", "settings.single_scattering_depths=" + depths});
        EXPECT_EQ(result.exit_code, 0) << result.err;
        return channel(folder / image, "single.R");
    };
    const std::vector<float> reference = single("1024");
    const auto error = [&](const std::string& depths) {
        const std::vector<float> values = single(depths);
        double squares = 0;
        for (std::size_t i = 0; i < values.size(); ++i)
            squares += double((values[i] - reference[i]) * (values[i] - reference[i]));
        return std::sqrt(squares / double(values.size()));
    };
    // Rays to the sky are drawn: chance alone would give 0.25. Measured 0.18 and 0.046.
    EXPECT_LT(error("64"), 0.22 * error("4"));
    EXPECT_LT(error("auto"), 0.1 * error("1"));
}

// In every pixel and channel. The plain sum's own kernel is a table of floats, good to 1e-6.
TEST(Pipeline, CertificateHoldsInEveryPixel) {
    const path folder = pyramid_folder();
    make_cache(folder, {"--spacing", "0.15", "--bounces", "0"});
    ASSERT_EQ(render_to(folder, "plain.exr",
                        {"--tolerance", "0", "--aovs", "exitance", "--set", "settings.bounces=0"})
                  .exit_code,
              0);
    for (const double tolerance : {0.03, 0.001}) {
        const std::vector<std::string> flags = {"--certify", fmt::format("{}", tolerance),
                                                "--aovs",    "all",
                                                "--set",     "settings.bounces=0"};
        ASSERT_EQ(render_to(folder, "fast.exr", flags).exit_code, 0);
        for (const char* c : {"R", "G", "B"}) {
            const auto plain = channel(folder / "plain.exr", fmt::format("exitance.{}", c));
            const auto fast = channel(folder / "fast.exr", fmt::format("exitance.{}", c));
            const auto bound = channel(folder / "fast.exr", fmt::format("error_bound.{}", c));
            for (std::size_t i = 0; i < plain.size(); ++i) {
                ASSERT_LE(std::abs(double(fast[i]) - plain[i]), bound[i] + 1e-6 * plain[i]);
                ASSERT_LE(bound[i], tolerance * plain[i]);
            }
        }
    }
}

// The certificate is about the sum; the body's solve is the same for any accuracy of the sums.
TEST(Pipeline, CertificateHoldsForBodyAwareMaterials) {
    const path folder = pyramid_folder();
    const std::string model = "materials.stone.model=body-aware";
    make_cache(folder, {"--spacing", "0.25", "--set", model});
    ASSERT_EQ(
        render_to(folder, "plain.exr", {"--tolerance", "0", "--aovs", "exitance", "--set", model})
            .exit_code,
        0);
    ASSERT_EQ(render_to(folder, "fast.exr", {"--certify", "0.01", "--aovs", "all", "--set", model})
                  .exit_code,
              0);
    for (const char* c : {"R", "G", "B"}) {
        const auto plain = channel(folder / "plain.exr", fmt::format("exitance.{}", c));
        const auto fast = channel(folder / "fast.exr", fmt::format("exitance.{}", c));
        const auto bound = channel(folder / "fast.exr", fmt::format("error_bound.{}", c));
        for (std::size_t i = 0; i < plain.size(); ++i) {
            ASSERT_LE(std::abs(double(fast[i]) - plain[i]), bound[i] + 1e-6 * plain[i]);
            ASSERT_LE(bound[i], 0.0101 * plain[i]);
        }
    }
}

// Bodies of very different size that touch, one of them unlit, one channel that absorbs all, a few
// samples, a single light behind: rendering fails where a pixel is not finite.
TEST(Pipeline, BodyAwareScenesOfManyKindsRender) {
    const path folder = fresh_folder();
    write_bytes(folder / "scene.yaml", R"(
cameras:
  main: {type: perspective, position: [4, 6, 30], look_at: [0, 0, 0], fov_deg: 50, resolution: [40, 32]}
materials:
  stone: {type: subsurface, sigma_s_prime: [1, 1, 0], sigma_a: [0, 0.1, 2], eta: 1.4, model: body-aware}
  coal: {type: subsurface, sigma_s_prime: [1e-3, 1, 1], sigma_a: [20, 20, 1e-3], eta: 1.5, model: body-aware}
  floor: {type: diffuse, reflectance: 0.4}
objects:
  - {shape: sphere, center: [0, 0, 0], radius: 6, material: stone}
  - {shape: cube, center: [6.1, 0, 0], size: 0.2, material: stone}
  - {shape: cube, center: [-8, 0, 0], size: [4, 4, 0.01], material: coal}
  - {shape: sphere, center: [0, 2, 60], radius: 1, material: coal}
  - {shape: plane, point: [0, -6, 0], normal: [0, 1, 0], material: floor}
lights:
  - {type: point, position: [0, 9, -20], intensity: 2000}
settings: {samples: 1, light_samples: 4, tolerance: 0.05, bounces: 1}
)");
    make_cache(folder, {"--everything", "--points", "40000"});
    const Result result =
        render_to(folder, "image.exr", {"--everything", "--stats", (folder / "s.json").string()});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const std::string stats = read_bytes(folder / "s.json");
    EXPECT_NE(stats.find("\"objects[0].diffusion\": "), std::string::npos) << stats;
    EXPECT_NE(stats.find("\"diffusion\": "), std::string::npos);
    EXPECT_NE(stats.find("\"diffusion_iterations\": "), std::string::npos);
}

TEST(Pipeline, OneCacheServesEveryCameraMediumAndGroupScale) {
    const path folder = pyramid_folder();
    make_cache(folder);
    const std::string cache = read_bytes(folder / "scene.tallow");
    for (const std::vector<std::string>& flags : std::vector<std::vector<std::string>>{
             {"--camera", "above"},
             {"--set", "materials.stone.sigma_a=[0.1, 0.1, 0.1]", "--set", "settings.bounces=0"},
             {"--set", "materials.floor.reflectance=0.1", "--set", "settings.bounces=0"},
             {"--set", "groups.key.scale=[2, 1, 0.5]"},
             {"--set", "cameras.main.fov_deg=20"}}) {
        const Result result = render_to(folder, "image.exr", flags);
        EXPECT_EQ(result.exit_code, 0) << result.err;
    }
    EXPECT_EQ(read_bytes(folder / "scene.tallow"), cache);
}

// Indirect light depends on what reflects it; the direct light beside it does not.
TEST(Pipeline, RefusesIndirectLightOfAnotherFloor) {
    const path folder = pyramid_folder();
    make_cache(folder);
    const Result result =
        render_to(folder, "image.exr", {"--set", "materials.floor.reflectance=0.1"});
    EXPECT_EQ(result.exit_code, 3);
    EXPECT_NE(
        result.err.find("scene.tallow: indirect light was made from "
                        "indirect.objects[1].reflectance = 0.4 0.4 0.4, but the scene has "
                        "0.1 0.1 0.1; re-run tallow-precompute, which keeps the direct light, "
                        "or do without with --set settings.bounces=0"),
        std::string::npos)
        << result.err;
}

// Light adds: the picture with both groups is the sum of the pictures with one of them dark. (The
// body-aware factor is made of all light together, and adds up to some tenths of a per cent only.)
TEST(Pipeline, LightGroupsAddUp) {
    const path folder = pyramid_folder();
    const std::string of_model = "materials.stone.model=transport";
    make_cache(folder, {"--set", of_model});
    const auto scaled = [&](const std::string& image, float key, float rest) {
        const Result result = render_to(folder, image,
                                        {"--tolerance", "0", "--samples", "1", "--set", of_model,
                                         "--set", "groups.key.scale=" + std::to_string(key),
                                         "--set", "groups.default.scale=" + std::to_string(rest),
                                         "--set", "groups.sky.scale=" + std::to_string(rest)});
        EXPECT_EQ(result.exit_code, 0) << result.err;
        return channel(folder / image, "R");
    };
    const auto both = scaled("both.exr", 3, 1), key = scaled("key.exr", 1, 0),
               rest = scaled("rest.exr", 0, 1);
    for (std::size_t i = 0; i < both.size(); ++i)
        EXPECT_NEAR(both[i], 3 * key[i] + rest[i], 1e-4 * (both[i] + 1e-3));
}

TEST(Pipeline, OpaqueScenesNeedNoCache) {
    const path folder = fresh_folder();
    write_bytes(folder / "scene.yaml", R"(
cameras:
  main: {type: perspective, position: [0, 2, 0], look_at: [0, 0, 0], up: [0, 0, 1], fov_deg: 5, resolution: [2, 2]}
materials:
  white: {type: diffuse, reflectance: 0.5}
objects:
  - {shape: disc, center: [0, 0, 0], normal: [0, 1, 0], radius: 5, material: white}
lights:
  - {type: environment, radiance: 2}
settings: {samples: 1}
)");
    const Result result =
        render({(folder / "scene.yaml").string(), "-o", (folder / "image.exr").string()});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    // Half of the light from everywhere comes back, whatever the direction. Measured 6e-7.
    for (float value : channel(folder / "image.exr", "R")) EXPECT_NEAR(value, 1, 1e-4);
}

// The plan is told before any work, and no file is written.
TEST(Pipeline, PlanIsPrintedAndNothingIsDone) {
    const path folder = pyramid_folder();
    const Result one = precompute({folder / "scene.yaml", "--plan", "--bounces", "0"});
    EXPECT_EQ(one.exit_code, 0) << one.err;
    EXPECT_NE(one.out.find("scene                    indirect light       left out  0 bounces; "
                           "forced\n"),
              std::string::npos)
        << one.out;
    EXPECT_NE(one.out.find("materials.stone          single scattering    computed"),
              std::string::npos)
        << one.out;
    EXPECT_NE(one.out.find("predicted_seconds"), std::string::npos);
    const Result two = render({folder / "scene.yaml", "--plan", "--set", "groups.key.scale=0"});
    EXPECT_EQ(two.exit_code, 0) << two.err;
    EXPECT_NE(two.out.find("lights[0]                shadow rays          left out"),
              std::string::npos)
        << two.out;
    EXPECT_FALSE(std::filesystem::exists(folder / "scene.tallow"));
}

TEST(Pipeline, StatsNameWhatRan) {
    const path folder = pyramid_folder();
    make_cache(folder, {"--stats", (folder / "one.json").string()});
    ASSERT_EQ(render_to(folder, "image.exr", {"--stats", (folder / "two.json").string()}).exit_code,
              0);
    const std::string one = read_bytes(folder / "one.json"), two = read_bytes(folder / "two.json");
    for (const char* phase : {"load", "bvh", "sample", "irradiance", "octree", "write", "total"})
        EXPECT_NE(one.find('"' + std::string(phase) + "\": "), std::string::npos) << phase;
    for (const char* phase :
         {"load", "bvh", "map", "primary", "exitance", "single", "surface", "write", "total"})
        EXPECT_NE(two.find('"' + std::string(phase) + "\": "), std::string::npos) << phase;
    EXPECT_EQ(two.find("\"irradiance\""), std::string::npos);
}

}  // namespace
}  // namespace tallow::test
