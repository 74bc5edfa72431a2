// SPDX-License-Identifier: Apache-2.0
#include "common/scene/presets.h"

#include <gtest/gtest.h>

namespace tallow {
namespace {

struct Printed {
    std::string name;
    Medium medium;
    Rgb reflectance;
};

// Figure 5 of [JMLH01], written out a second time so that a slip in data/materials.yaml shows.
const std::vector<Printed> kFigure5 = {
    {"apple", {{0.0030f, 0.0034f, 0.046f}, {2.29f, 2.39f, 1.97f}, 0, 1.3f}, {0.85f, 0.84f, 0.53f}},
    {"chicken1", {{0.015f, 0.077f, 0.19f}, {0.15f, 0.21f, 0.38f}, 0, 1.3f}, {0.31f, 0.15f, 0.10f}},
    {"chicken2", {{0.018f, 0.088f, 0.20f}, {0.19f, 0.25f, 0.32f}, 0, 1.3f}, {0.32f, 0.16f, 0.10f}},
    {"cream", {{0.0002f, 0.0028f, 0.0163f}, {7.38f, 5.47f, 3.15f}, 0, 1.3f}, {0.98f, 0.90f, 0.73f}},
    {"ketchup", {{0.061f, 0.97f, 1.45f}, {0.18f, 0.07f, 0.03f}, 0, 1.3f}, {0.16f, 0.01f, 0.00f}},
    {"marble",
     {{0.0021f, 0.0041f, 0.0071f}, {2.19f, 2.62f, 3.00f}, 0, 1.5f},
     {0.83f, 0.79f, 0.75f}},
    {"potato", {{0.0024f, 0.0090f, 0.12f}, {0.68f, 0.70f, 0.55f}, 0, 1.3f}, {0.77f, 0.62f, 0.21f}},
    {"skimmilk",
     {{0.0014f, 0.0025f, 0.0142f}, {0.70f, 1.22f, 1.90f}, 0, 1.3f},
     {0.81f, 0.81f, 0.69f}},
    {"skin1", {{0.032f, 0.17f, 0.48f}, {0.74f, 0.88f, 1.01f}, 0, 1.3f}, {0.44f, 0.22f, 0.13f}},
    {"skin2", {{0.013f, 0.070f, 0.145f}, {1.09f, 1.59f, 1.79f}, 0, 1.3f}, {0.63f, 0.44f, 0.34f}},
    {"spectralon", {{0.00f, 0.00f, 0.00f}, {11.6f, 20.4f, 14.9f}, 0, 1.3f}, {1.00f, 1.00f, 1.00f}},
    {"wholemilk",
     {{0.0011f, 0.0024f, 0.014f}, {2.55f, 3.21f, 3.77f}, 0, 1.3f},
     {0.91f, 0.88f, 0.76f}},
};

TEST(Presets, HoldTheNumbersOfFigure5) {
    for (const Printed& printed : kFigure5) {
        ASSERT_NE(find_preset(printed.name), nullptr) << printed.name;
        const Preset& got = *find_preset(printed.name);
        EXPECT_FALSE(got.dilutable);
        EXPECT_EQ(got.medium.sigma_a, printed.medium.sigma_a) << got.name;
        EXPECT_EQ(got.medium.sigma_s_prime, printed.medium.sigma_s_prime) << got.name;
        EXPECT_EQ(got.medium.eta, printed.medium.eta) << got.name;
        EXPECT_EQ(got.medium.g, 0) << got.name;
        EXPECT_EQ(got.printed_reflectance, printed.reflectance) << got.name;
        EXPECT_EQ(got.source, "JMLH01") << got.name;
    }
}

TEST(Presets, AreFoundByTheirExactName) {
    EXPECT_EQ(find_preset("ketchup")->medium.sigma_a, Rgb(0.061f, 0.97f, 1.45f));
    EXPECT_EQ(find_preset("Ketchup"), nullptr);
    EXPECT_EQ(find_preset(""), nullptr);
    EXPECT_EQ(preset_names().front(), "apple");
}

}  // namespace
}  // namespace tallow
