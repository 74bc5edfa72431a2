// SPDX-License-Identifier: Apache-2.0
// Mutations of a valid scene under a fixed seed. Allowed outcomes: a scene, or InputError of one
// line that starts with the file's name. Anything else (crash, sanitizer report, other exception)
// fails.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <random>

#include "common/base/errors.h"
#include "tests/support/scene_text.h"

namespace tallow {
namespace {

using Random = std::mt19937;  // the same numbers with every library, unlike the distributions

std::size_t below(Random& random, std::size_t n) { return random() % n; }

void flip_byte(std::string& text, Random& random) {
    text[below(random, text.size())] = static_cast<char>(random() & 0xff);
}

void truncate(std::string& text, Random& random) { text.resize(below(random, text.size())); }

void erase_range(std::string& text, Random& random) {
    text.erase(below(random, text.size()), 1 + below(random, 40));
}

/// Copies a piece of the text to another place.
void splice(std::string& text, Random& random) {
    const std::string piece = text.substr(below(random, text.size()), 1 + below(random, 80));
    text.insert(below(random, text.size()), piece);
}

/// Inserts what YAML gives a meaning, or what numbers break on.
void insert_token(std::string& text, Random& random) {
    static const std::vector<std::string> kTokens = {
        "[",  "]",  "{",    "}",    "&a ",  "*a",   "- ",     ": ",   ", ", "!!int ",
        "\"", "'",  "|\n",  ">\n",  "\t",   "\n",   "---\n",  "? ",   "#",  "%YAML 1.2\n",
        "~",  "<<", "1e39", "-0.0", ".nan", ".inf", "1e-300", "0x10", "@",  "`"};
    text.insert(below(random, text.size()), kTokens[below(random, kTokens.size())]);
}

std::string mutate(std::string text, Random& random) {
    using Mutation = void (*)(std::string&, Random&);
    constexpr Mutation kMutations[] = {flip_byte, truncate, erase_range, splice, insert_token};
    const std::size_t count = 1 + below(random, 2);
    for (std::size_t i = 0; i < count && !text.empty(); ++i)
        kMutations[below(random, std::size(kMutations))](text, random);
    return text;
}

const std::string kMovingCameras = R"(cameras:
  turn: {type: perspective, position: [0, 2, 9], look_at: [0, 1, 0], fov_deg: 30, resolution: [9, 9], turntable: {frames: 36, axis: [0, 1, 0.1], degrees: -360}}
  lens: {type: thin-lens, position: [0, 2, 9], look_at: [0, 1, 0], fov_deg: 30, resolution: [9, 9], aperture_mm: 0.5, focus_at: [0, 1, 1]}
  way: {type: thin-lens, look_at: [0, 1, 0], fov_deg: 30, resolution: [9, 9], aperture_mm: 0.5, focus_mm: 8, keyframes: [{frame: 0, position: [0, 2, 9]}, {frame: 9, position: [4, 2, 9], fov_deg: 12}, {frame: 24, position: [4, 2, 0], look_at: [1, 1, 0]}]}
)";

const std::string kTexturedScene = kCamera + R"(
textures:
  board: {type: checker, even: [1, 0.5, 0], odd: 0.125, coordinates: object, period: [1, 2, 3]}
  tiles: {type: checker, even: 0.5, odd: 0, period: [0.25, 4]}
materials:
  body: {type: subsurface, preset: marble, albedo: {texture: board}}
  floor: {type: diffuse, reflectance: {texture: tiles, scale: [0.5, 0.25, 0]}}
  cup: {type: plastic, reflectance: {texture: board, scale: 0.5}}
)";

TEST(SceneFuzz, MutatedScenesLoadOrAreRefused) {
    Random random(20021);
    const auto start = std::chrono::steady_clock::now();
    int loaded = 0, refused = 0;
    for (int i = 0; i < 3000; ++i) {
        const std::string text = mutate(i % 4 == 0   ? kTexturedScene
                                        : i % 4 == 1 ? kMovingCameras
                                                     : kFullScene,
                                        random);
        try {
            scene_of(text);
            ++loaded;
        } catch (const InputError& error) {
            ++refused;
            const std::string message = error.what();
            ASSERT_TRUE(message.starts_with("folder/scene.yaml:")) << message << "\n" << text;
            ASSERT_EQ(std::ranges::count(message, '\n'), 0) << message << "\n" << text;
        }
    }
    // Both outcomes must occur, or the mutations are too weak or too strong to test anything.
    EXPECT_GT(loaded, 50);
    EXPECT_GT(refused, 500);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    EXPECT_LT(elapsed.count(), 60);  // measured 0.4 s, 2.3 s with sanitizers
}

TEST(SceneFuzz, MutatedOverridesApplyOrAreRefused) {
    Random random(20022);
    int loaded = 0, refused = 0;
    for (int i = 0; i < 1000; ++i) {
        const std::string text =
            mutate("materials.candle.sigma_a=[0.123456789, 0.123456789, 0.123456789]", random);
        try {
            scene_of(kFullScene, {text});
            ++loaded;
        } catch (const UsageError& error) {
            ++refused;
            ASSERT_TRUE(std::string(error.what()).starts_with("--set")) << text;
        } catch (const InputError&) {
            ++refused;  // the flag left something behind that the file contradicts
        }
    }
    EXPECT_GT(loaded, 5);
    EXPECT_GT(refused, 500);
}

// Pieces that are small as text and would be large, deep or slow as a tree.
TEST(SceneFuzz, BoundsWhatAFileCanCost) {
    std::string laughs = "a: &a [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n";
    for (char c = 'b'; c < 'l'; ++c) {
        laughs += fmt::format("{}: &{} [", c, c);
        for (int i = 0; i < 10; ++i) laughs += fmt::format("*{}, ", static_cast<char>(c - 1));
        laughs += "1]\n";
    }
    const std::vector<std::string> texts = {
        laughs,
        "a: &a [*a]\n",
        "a: &a {b: *a}\n",
        std::string(100000, '['),
        std::string(100000, '{'),
        std::string(100000, '-'),
        std::string(5000, '\n') + std::string(300000, ' ') + "x",
        "a: \"" + std::string(1000000, 'x'),
        [] {
            std::string text;
            for (int i = 0; i < 3000; ++i)
                text += std::string(static_cast<std::size_t>(i), ' ') + "a:\n";
            return text;
        }(),
        [] {
            std::string text;
            for (int i = 0; i < 3000; ++i) text += "- ";
            return text;
        }(),
        std::string("\0\0\0\0", 4),
        "\xff\xfe\x00\xd8",
    };
    const auto start = std::chrono::steady_clock::now();
    for (const std::string& text : texts)
        EXPECT_THROW(scene_of(text), InputError) << text.substr(0, 80);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    EXPECT_LT(elapsed.count(), 30);  // measured 0.3 s
}

}  // namespace
}  // namespace tallow
