// SPDX-License-Identifier: Apache-2.0
// Textures through both programs, as a user runs them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <numeric>

#include "common/image/exr_io.h"
#include "common/optics/dipole.h"
#include "common/optics/fresnel.h"
#include "tests/support/process.h"
#include "tests/support/test_files.h"
#include "tests/support/texture_files.h"

namespace tallow::test {
namespace {

using std::filesystem::path;

/// A half-space under a white sky, seen from above in a square of `side` mm around (x, 0, z).
std::string ground(const std::string& albedo, double x = 0, double z = 0, double side = 0.4,
                   int samples = 1) {
    return fmt::format(R"(
cameras:
  main: {{type: perspective, position: [{0}, {2}, {1}], look_at: [{0}, 0, {1}], up: [0, 0, -1], fov_deg: 10, resolution: [4, 4]}}
textures:
  fine: {{type: checker, even: 1, odd: 0.25, period: 0.2}}
  coarse: {{type: checker, even: [1, 0.8, 0.6], odd: [0.2, 0.4, 0.5], coordinates: object, period: 16}}
  white: {{type: image, file: white.exr, coordinates: object, period: 3}}
materials:
  ground: {{type: subsurface, sigma_s_prime: [2, 2, 2], sigma_a: [0.5, 0.3, 0.2], eta: 1.3, model: dipole{3}}}
objects:
  - {{shape: plane, point: [0, 0, 0], normal: [0, 1, 0], radius: 14, material: ground}}
lights:
  - {{type: environment, radiance: 1}}
settings: {{tolerance: 0, samples: {4}, light_samples: 16}}
)",
                       x, z, side / (2 * std::tan(std::numbers::pi / 36)),
                       albedo.empty() ? "" : ", albedo: " + albedo, samples);
}

struct Picture {
    std::vector<double> M;      // mean exitance [channel]
    std::vector<float> values;  // of all layers, one after the other
    std::string png;
};

/// The folder must hold scene.yaml.
Picture render_scene(const path& folder, const std::string& spacing) {
    const std::string scene = folder / "scene.yaml", cache = folder / "scene.tallow";
    const Result made = precompute({scene, "-o", cache, "--spacing", spacing, "--quiet"});
    EXPECT_EQ(made.exit_code, 0) << made.err;
    const Result seen = render({scene, "--cache", cache, "-o", folder / "a.exr", "-o",
                                folder / "a.png", "--aovs", "all", "--quiet"});
    EXPECT_EQ(seen.exit_code, 0) << seen.err;
    Picture picture;
    const Image image = read_exr(folder / "a.exr");
    for (const Channel& channel : image.channels)
        picture.values.insert(picture.values.end(), channel.values.begin(), channel.values.end());
    for (const char* name : {"exitance.R", "exitance.G", "exitance.B"}) {
        const std::vector<float>& v = *image.find_channel(name);
        picture.M.push_back(std::accumulate(v.begin(), v.end(), 0.0) / double(v.size()));
    }
    picture.png = read_bytes(folder / "a.png");
    return picture;
}

Picture render_ground(const std::string& scene, const std::string& spacing = "0.14") {
    const path folder = fresh_folder();
    write_picture(folder / "white.exr", 2, 2, std::vector<Rgb>(4, Rgb(1)));
    write_bytes(folder / "scene.yaml", scene);
    return render_scene(folder, spacing);
}

// Measured 1e-7: the same sums, multiplied with the root of t twice.
TEST(Textures, ConstantAlbedoScalesAHalfSpace) {
    const Picture plain = render_ground(ground("")),
                  tinted = render_ground(ground("[0.5, 0.09, 1]"));
    EXPECT_NEAR(tinted.M[0], 0.5 * plain.M[0], 1e-6 * plain.M[0]);
    EXPECT_NEAR(tinted.M[1], 0.09 * plain.M[1], 1e-6 * plain.M[1]);
    EXPECT_EQ(tinted.M[2], plain.M[2]);
    // And what is scaled is right: measured 0.04 %.
    const Medium medium{{0.5f, 0.3f, 0.2f}, {2, 2, 2}, 0, 1.3f};
    const double R = total_reflectance(dipole_channel<double>(medium, 0, mismatch_A(1.3)));
    const double E_t = std::numbers::pi * diffuse_fresnel_transmittance(1.3);
    EXPECT_NEAR(tinted.M[0], 0.5 * R * E_t, 0.002 * 0.5 * R * E_t);
}

// In the middle of squares of 8 mm, eight diffusion lengths from their borders, a checker is its
// colour. Measured 4e-4.
TEST(Textures, WideSquaresOfAHalfSpaceHaveTheirAlbedo) {
    const Picture plain = render_ground(ground("", 4, 4));
    const Picture even = render_ground(ground("{texture: coarse}", 4, 4));
    const Picture odd = render_ground(ground("{texture: coarse, scale: 0.5}", -4, 4));
    const double expected_even[] = {1, 0.8, 0.6}, expected_odd[] = {0.1, 0.2, 0.25};
    for (std::size_t c = 0; c < 3; ++c) {
        EXPECT_NEAR(even.M[c] / plain.M[c], expected_even[c], 1e-3) << c;
        EXPECT_NEAR(odd.M[c] / plain.M[c], expected_odd[c], 1e-3) << c;
    }
}

// Squares of 0.1 mm, far below the mean free path of 0.4 mm and below the spacing: light that
// enters anywhere leaves anywhere, so that M is the mean tint squared, (3/4)^2. Measured 0.0045:
// the tints of samples are noisy.
TEST(Textures, FineSquaresAreMixedInside) {
    const Picture plain = render_ground(ground("", 0.7, 0.9, 2, 256));
    const Picture fine = render_ground(ground("{texture: fine}", 0.7, 0.9, 2, 256));
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(fine.M[c] / plain.M[c], 0.5625, 0.01) << c;
}

TEST(Textures, WhiteIsNoTextureByteForByte) {
    const Picture plain = render_ground(ground("", 0.3, 0.2, 3));
    for (const char* albedo : {"1", "{texture: white}", "{texture: white, scale: [1, 1, 1]}"}) {
        const Picture white = render_ground(ground(albedo, 0.3, 0.2, 3));
        EXPECT_EQ(white.values, plain.values) << albedo;
        EXPECT_EQ(white.png, plain.png) << albedo;
    }
}

TEST(Textures, CacheKnowsTheAlbedo) {
    const path folder = fresh_folder();
    write_picture(folder / "white.exr", 2, 2, std::vector<Rgb>(4, Rgb(1)));
    write_bytes(folder / "scene.yaml", ground("{texture: white}"));
    render_scene(folder, "1");
    const auto refusal = [&](const std::vector<std::string>& flags) {
        std::vector<std::string> arguments = {folder / "scene.yaml",   "--cache",
                                              folder / "scene.tallow", "-o",
                                              folder / "b.exr",        "--quiet"};
        arguments.insert(arguments.end(), flags.begin(), flags.end());
        const Result result = render(arguments);
        EXPECT_EQ(result.exit_code, 3);
        const std::string line = result.first_error_line();
        return line.substr(std::min(line.size(), line.find("made from")));
    };
    EXPECT_EQ(refusal({"--set", "textures.white.period=2"}),
              "made from objects[0].albedo.period = 3 3 3, but the scene has 2 2 2; re-run "
              "tallow-precompute");
    EXPECT_EQ(refusal({"--set", "materials.ground.albedo=0.5"}),
              "made from objects[0].albedo = 1 1 1, but the scene has 0.5 0.5 0.5; re-run "
              "tallow-precompute");
    write_picture(folder / "white.exr", 2, 2, std::vector<Rgb>(4, Rgb(0.9f)));
    EXPECT_TRUE(refusal({}).starts_with("made from objects[0].albedo.image = 2 x 2 xxh3:"));
}

// Diffuse light of a floor under a white sky is its reflectance.
TEST(Textures, DiffuseFloorsShowTheirTexture) {
    const path folder = fresh_folder();
    write_picture(folder / "two.exr", 2, 1, {Rgb(0.25f, 0.5f, 1), Rgb(0)});
    write_bytes(folder / "scene.yaml", R"(
unit: cm
cameras:
  main: {type: perspective, position: [1, 10, 0], look_at: [1, 0, 0], up: [0, 0, -1], fov_deg: 0.1, resolution: [1, 1]}
textures:
  two: {type: image, file: two.exr, period: 40}
materials:
  floor: {type: diffuse, reflectance: {texture: two, scale: [1, 0.5, 0.5]}}
objects:
  - {shape: plane, point: [0, 0, 0], normal: [0, 1, 0], material: floor}
lights:
  - {type: environment, radiance: 1}
settings: {samples: 1}
)");
    const std::string scene = folder / "scene.yaml", cache = folder / "scene.tallow";
    ASSERT_EQ(precompute({scene, "-o", cache, "--quiet"}).exit_code, 0);
    const Result seen =
        render({scene, "--cache", cache, "-o", folder / "a.exr", "--aovs", "all", "--quiet"});
    ASSERT_EQ(seen.exit_code, 0) << seen.err;
    const Image image = read_exr(folder / "a.exr");
    // u is 10 mm of 40: the centre of the left pixel.
    const Rgb expected(0.25f, 0.25f, 0.5f);
    for (int c = 0; c < 3; ++c) {
        const std::string name(1, "RGB"[c]);
        EXPECT_NEAR(image.find_channel(name)->at(0), expected[c], 1e-3f);  // half floats
        EXPECT_NEAR(image.find_channel("albedo." + name)->at(0), expected[c], 1e-3f);
    }
}

}  // namespace
}  // namespace tallow::test
