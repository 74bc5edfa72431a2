// SPDX-License-Identifier: Apache-2.0
// data/materials.yaml against the papers, and what a scene may do with a preset.
#include <gtest/gtest.h>

#include "common/base/errors.h"
#include "common/scene/presets.h"
#include "tests/support/error_text.h"
#include "tests/support/scene_text.h"

namespace tallow {
namespace {

// Rows of [NGD06] table 2, written out a second time: extinction and scattering in 1e-2/mm, mean
// cosines, ml in 23 litres.
struct Row {
    const char* name;
    Rgb extinction, scattering, g;
    float volume_ml;
};
const std::vector<Row> kTable2 = {
    {"lowfat-milk",
     {0.9126f, 1.0748f, 1.2500f},
     {0.9124f, 1.0744f, 1.2492f},
     {0.932f, 0.902f, 0.859f},
     16},
    {"regular-milk",
     {1.1874f, 1.3296f, 1.4602f},
     {1.1873f, 1.3293f, 1.4589f},
     {0.750f, 0.714f, 0.681f},
     15},
    {"espresso",
     {0.4376f, 0.5115f, 0.6048f},
     {0.2707f, 0.2828f, 0.2970f},
     {0.907f, 0.896f, 0.880f},
     8},
    {"merlot", {0.7639f, 1.6429f, 1.9196f}, {0.0053f, 0, 0}, {0.974f, 0, 0}, 1500},
    {"shampoo",
     {0.0288f, 0.0710f, 0.0952f},
     {0.0104f, 0.0114f, 0.0147f},
     {0.910f, 0.905f, 0.920f},
     300},
};

TEST(MaterialsData, UndilutedLiquidsAreTable2OverTheirShareOfTheTank) {
    for (const Row& row : kTable2) {
        const Preset* preset = find_preset(row.name);
        ASSERT_TRUE(preset) << row.name;
        EXPECT_TRUE(preset->dilutable);
        EXPECT_EQ(preset->source, "NGD06");
        EXPECT_EQ(preset->medium.eta, 1.33f);
        for (int c = 0; c < 3; ++c) {
            const double undiluted = 0.01 * 23000 / double(row.volume_ml);
            const double sigma_s = undiluted * double(row.scattering[c]);
            const double sigma_a = undiluted * double(row.extinction[c]) - sigma_s;
            // Half a unit of the last printed digit.
            EXPECT_NEAR(double(preset->medium.sigma_a[c]), sigma_a, undiluted * 5e-5) << row.name;
            EXPECT_NEAR(double(preset->medium.sigma_s_prime[c]), (1 - double(row.g[c])) * sigma_s,
                        1e-6 * sigma_s)
                << row.name;
        }
    }
}

// The same liquids as two renderers list them, undiluted: pbrt-v3 (sigma_s' and sigma_a, 1/mm).
TEST(MaterialsData, UndilutedLiquidsAgreeWithAnotherRenderersTable) {
    const auto expect_near = [](const char* name, Rgb sigma_s_prime, Rgb sigma_a) {
        const Medium& medium = find_preset(name)->medium;
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(medium.sigma_s_prime[c], sigma_s_prime[c], 1e-4f * sigma_s_prime[c])
                << name;
            EXPECT_NEAR(medium.sigma_a[c], sigma_a[c], 1e-4f * sigma_a[c]) << name;
        }
    };
    expect_near("lowfat-milk", {0.89187f, 1.5136f, 2.532f}, {0.002875f, 0.00575f, 0.0115f});
    expect_near("espresso", {0.72378f, 0.84557f, 1.0247f}, {4.7984f, 6.5751f, 8.8493f});
    expect_near("white-grapefruit-juice", {0.22826f, 0.23998f, 0.32748f},
                {0.0138f, 0.018831f, 0.056781f});
    expect_near("head-and-shoulders-shampoo", {0.023805f, 0.028804f, 0.034306f},
                {0.084621f, 0.15688f, 0.20365f});
}

TEST(MaterialsData, MeanCosineIsThatOfTheChannelsThatScatter) {
    EXPECT_NEAR(find_preset("espresso")->medium.g, (0.907 + 0.896 + 0.88) / 3, 1e-6);
    EXPECT_NEAR(find_preset("merlot")->medium.g, 0.974, 1e-6);
    EXPECT_NEAR(find_preset("coke")->medium.g, (0.965 + 0.972) / 2, 1e-6);
}

TEST(MaterialsData, OnlyLiquidsOfTable2AreDilutable) {
    EXPECT_EQ(dilutable_preset_names().size(), 27u);
    EXPECT_EQ(preset_names().size(), 39u);
    for (const Preset& preset : presets())
        EXPECT_EQ(preset.dilutable, !preset.printed_reflectance.has_value()) << preset.name;
}

Medium medium_of(const std::string& material) {
    const Scene scene =
        scene_of(kCamera + "materials: {a: {type: subsurface, " + material + "}}\n");
    return std::get<SubsurfaceMaterial>(scene.materials.at(0).kind).medium;
}

TEST(MaterialsData, DilutionScalesBothCoefficientsAndNothingElse) {
    const Medium whole = medium_of("preset: lowfat-milk");
    EXPECT_EQ(whole.sigma_a, medium_of("preset: lowfat-milk, dilution: 1").sigma_a);
    const Medium quarter = medium_of("preset: lowfat-milk, dilution: 0.25");
    EXPECT_EQ(quarter.sigma_a, 0.25f * whole.sigma_a);
    EXPECT_EQ(quarter.sigma_s_prime, 0.25f * whole.sigma_s_prime);
    EXPECT_EQ(quarter.g, whole.g);
    EXPECT_EQ(quarter.eta, whole.eta);
}

std::string refusal(const std::string& material) {
    return error_text<InputError>([&] { medium_of(material); });
}

TEST(MaterialsData, DilutionIsRefusedWhereItMeansNothing) {
    EXPECT_TRUE(refusal("preset: marble, dilution: 0.5")
                    .starts_with("folder/scene.yaml:2:51: dilution: 'marble' cannot be diluted, "
                                 "expected one of the liquids apple-juice, "));
    EXPECT_EQ(refusal("preset: espresso, dilution: 0"),
              "folder/scene.yaml:2:63: dilution: expected a share in (0, 1], got '0'");
    EXPECT_EQ(refusal("preset: espresso, dilution: 1.5"),
              "folder/scene.yaml:2:63: dilution: expected a share in (0, 1], got '1.5'");
    EXPECT_EQ(
        refusal("preset: sprite, dilution: 1e-5"),
        "folder/scene.yaml:2:61: dilution: expected a mixture with sigma_a + sigma_s_prime >= "
        "1e-06, got 1.83721e-08");
    EXPECT_EQ(refusal("sigma_a: 1, sigma_s_prime: 1, eta: 1.3, dilution: 0.5"),
              "folder/scene.yaml:2:75: dilution: needs 'preset' beside it");
}

}  // namespace
}  // namespace tallow
