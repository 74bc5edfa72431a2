// SPDX-License-Identifier: Apache-2.0
#include "common/optics/invert_medium.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/base/errors.h"
#include "tests/support/error_text.h"
#include "tests/support/scene_text.h"

namespace tallow {
namespace {

double reflectance(Model model, const Medium& medium, int channel) {
    return make_profile(model, medium, channel, Orders::all)->total_reflectance();
}

// Round trip through the coefficients as the renderer will hold them, in float and at a mean free
// path far from 1. Measured: below 1e-7 but for transport, whose table is interpolated.
TEST(InvertMedium, FindsTheMediumOfAColour) {
    for (const auto& [name, model] : kModels)
        for (const float eta : {1.0f, 1.33f, 1.5f, 2.0f}) {
            const double largest = largest_reflectance(model, eta, 0);
            for (const double share : {0.001, 0.01, 0.1, 0.3, 0.6, 0.9, 0.99, 0.9999, 1.0}) {
                const double wanted = share * largest;
                const auto absorbed = invert_reflectance(model, wanted, eta, 0);
                ASSERT_TRUE(absorbed) << name;
                const auto k = channel_coefficients(*absorbed, 0.037);
                const Medium medium{Rgb(k.sigma_a), Rgb(k.sigma_s_prime), 0, eta};
                EXPECT_NEAR(reflectance(model, medium, 1), wanted, 1e-6)
                    << name << " eta " << eta << " reflectance " << wanted;
                EXPECT_NEAR(1 / double(medium.sigma_t_prime().g), 0.037, 1e-8) << name;
            }
        }
}

// Analytic limit: without absorption all light comes back, save where a model leaves out the first
// order of scattering.
TEST(InvertMedium, LargestReflectanceIsOneWhereAModelHoldsAllOrders) {
    EXPECT_NEAR(largest_reflectance(Model::dipole, 1.4f, 0), 1, 1e-12);
    EXPECT_NEAR(largest_reflectance(Model::better_dipole, 1.4f, 0), 1, 1e-6);
    EXPECT_LT(largest_reflectance(Model::photon_beam_diffusion, 1.4f, 0), 0.999);
}

TEST(InvertMedium, EndsOfTheRange) {
    EXPECT_EQ(invert_reflectance(Model::dipole, 0, 1.4f, 0), 1.0);
    EXPECT_EQ(invert_reflectance(Model::dipole, 1, 1.4f, 0), 0.0);
    EXPECT_FALSE(invert_reflectance(Model::dipole, 1.00001, 1.4f, 0));
}

TEST(InvertMedium, BrighterColoursAbsorbLess) {
    for (const auto& [name, model] : kModels) {
        double previous = 1;
        for (double colour = 0.05; colour < 0.9; colour += 0.05) {
            const double absorbed = *invert_reflectance(model, colour, 1.4f, 0);
            EXPECT_LT(absorbed, previous) << name << " " << colour;
            previous = absorbed;
        }
    }
}

const SubsurfaceMaterial& first_material(const Scene& scene) {
    return std::get<SubsurfaceMaterial>(scene.materials.at(0).kind);
}

TEST(InvertMedium, ScenesGiveColoursAndLengthsInTheirUnit) {
    const Scene scene = scene_of("unit: cm\n" + kCamera +
                                 "materials: {a: {type: subsurface, diffuse_color: [0.8, 0.5, 0.4],"
                                 " mean_free_path: [0.1, 0.05, 0.02], eta: 1.4, g: 0.5, model: "
                                 "better-dipole}}\n");
    const SubsurfaceMaterial& material = first_material(scene);
    EXPECT_EQ(material.model, Model::better_dipole);
    EXPECT_EQ(material.medium.g, 0.5f);
    EXPECT_EQ(material.medium.eta, 1.4f);
    const Rgb color(0.8f, 0.5f, 0.4f), length(1, 0.5f, 0.2f);  // mm
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(reflectance(material.model, material.medium, c), double(color[c]), 1e-6);
        EXPECT_NEAR(material.medium.mean_free_path()[c], length[c], 1e-6f);
    }
}

TEST(InvertMedium, ScenesMayNameEveryModel) {
    for (const auto& [name, model] : kModels)
        EXPECT_EQ(first_material(scene_of(kCamera +
                                          "materials: {a: {type: subsurface, preset: "
                                          "marble, model: " +
                                          std::string(name) + "}}\n"))
                      .model,
                  model);
    EXPECT_EQ(first_material(scene_of(kCamera + "materials: {a: {type: subsurface, preset: "
                                                "marble}}\n"))
                  .model,
              Model::body_aware);
}

std::string refusal(const std::string& material) {
    return error_text<InputError>(
        [&] { scene_of(kCamera + "materials: {a: {type: subsurface, " + material + "}}\n"); });
}

TEST(InvertMedium, ScenesAreToldWhatIsWrong) {
    const std::string at = "folder/scene.yaml:2:";
    EXPECT_EQ(refusal("diffuse_color: 0.5, eta: 1.4"), at + "16: missing key 'mean_free_path'");
    EXPECT_EQ(refusal("diffuse_color: 0.5, mean_free_path: 1"), at + "16: missing key 'eta'");
    EXPECT_EQ(refusal("mean_free_path: 1, preset: marble"),
              at + "35: mean_free_path: needs 'diffuse_color' beside it");
    EXPECT_EQ(refusal("diffuse_color: 0.5, preset: marble, mean_free_path: 1, eta: 1.4"),
              at + "55: preset: cannot be given together with 'diffuse_color'");
    EXPECT_EQ(refusal("diffuse_color: [0.5, 1.5, 0.5], mean_free_path: 1, eta: 1.4"),
              at + "56: diffuse_color: expected a number in [0, 1], got '1.5'");
    EXPECT_EQ(refusal("diffuse_color: 0.5, mean_free_path: 0, eta: 1.4"),
              at + "71: mean_free_path: expected a number > 0, got '0'");
    EXPECT_EQ(refusal("diffuse_color: 0.5, mean_free_path: [1, 1, 2e6], eta: 1.4"),
              at + "78: mean_free_path: expected at most 1e+06 mm, got '2e6'");
    const std::string too_bright = refusal(
        "diffuse_color: [0.5, 0.5, 0.99], mean_free_path: 1, eta: 1.4, model: "
        "photon-beam-diffusion");
    EXPECT_TRUE(too_bright.starts_with(at + "50: diffuse_color: expected at most 0.9"))
        << too_bright;
    EXPECT_TRUE(
        too_bright.ends_with("which model 'photon-beam-diffusion' reflects without any "
                             "absorption at eta 1.4, got 0.99 in blue"))
        << too_bright;
}

}  // namespace
}  // namespace tallow
