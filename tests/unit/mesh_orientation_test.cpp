// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "common/base/rng.h"
#include "tests/support/mesh_soups.h"

namespace tallow {
namespace {

TEST(MeshOrientation, TurnsFacesAsTheirNeighbours) {
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
        PolygonSoup soup = sphere(2, 2);
        std::size_t turned = 0;
        for (std::size_t f = 0; f < soup.polygons.size(); ++f)
            if (random_bits(seed, 0, f) % 3 == 0) {
                std::swap(soup.polygons[f][0], soup.polygons[f][1]);
                ++turned;
            }
        const RepairedMesh result = repair(soup);
        expect_body(result, volume(repair(sphere(2, 2)).mesh));
        EXPECT_EQ(result.report.flipped_faces, turned) << "seed " << seed;
        EXPECT_EQ(result.report.flipped_components, 0u) << "seed " << seed;
    }
}

TEST(MeshOrientation, TurnsComponentsThatAreInsideOut) {
    const RepairedMesh result = repair(join(unit_cube(), inside_out(box({5, 0, 0}, {7, 2, 2}))));
    expect_body(result, 1 + 8, 2);
    EXPECT_EQ(result.report.flipped_components, 1u);
    EXPECT_EQ(result.report.flipped_faces, 0u);
}

TEST(MeshOrientation, ShellOfACavityFacesIntoTheCavity) {
    // A ball in the hollow of a ball, whatever way the file turns the three shells.
    const PolygonSoup outer = sphere(3, 2), hollow = sphere(2, 2), core = sphere(1, 2);
    const auto ball = [](const PolygonSoup& soup) { return volume(repair(soup).mesh); };
    const double expected = ball(outer) - ball(hollow) + ball(core);
    for (int turn = 0; turn < 8; ++turn) {
        const auto as = [&](const PolygonSoup& s, int bit) {
            return turn & bit ? inside_out(s) : s;
        };
        const RepairedMesh result = repair(join(join(as(hollow, 1), as(outer, 2)), as(core, 4)));
        expect_body(result, expected, 3);
        const std::size_t flips = (turn & 1 ? 0 : 1) + (turn & 2 ? 1 : 0) + (turn & 4 ? 1 : 0);
        EXPECT_EQ(result.report.flipped_components, flips) << "turn " << turn;
    }
}

TEST(MeshOrientation, PartsThatCrossAreNoCavities) {
    const RepairedMesh result = repair(join(box({0, 0, 0}, {4, 4, 4}), box({1, 1, 1}, {2, 2, 6})));
    expect_body(result, 64 + 5, 2);
}

}  // namespace
}  // namespace tallow
