// SPDX-License-Identifier: Apache-2.0
#include "common/nbody/sum_tree.h"

#include <gtest/gtest.h>

#include "common/nbody/target_groups.h"
#include "tests/support/point_clouds.h"

namespace tallow {
namespace {

using test::Draw;
using test::WeightedCloud;

constexpr double kUnit = 0.25;

WeightedCloud box(std::uint64_t seed, std::size_t n, const DVec3& origin, bool some_dark) {
    Draw draw(seed);
    std::vector<Vec3> points(n);
    for (Vec3& p : points) p = Vec3(origin + 10.0 * draw.in_box());
    std::vector<float> weights = test::random_weights(draw, n);
    if (some_dark)
        for (float& w : weights) w = draw.one_in(2) ? w : 0;
    return test::sorted_cloud(points, weights);
}

SumTree tree_of(const WeightedCloud& cloud) {
    return {cloud.positions, cloud.weights, cloud.nodes, kUnit};
}

/// Moments by a loop over the points, about a given center.
struct Loop {
    double weight = 0, radius = 0, cubes = 0, reach = 0;
    DVec3 mean{0}, first{0};
    glm::dmat3 second{0};

    Loop(std::span<const SumTree::Point> points, const DVec3& center) {
        for (const SumTree::Point& p : points) {
            const DVec3 x(p.x, p.y, p.z), d = x - center;
            const double w = p.weight, r = glm::length(d);
            weight += w, cubes += w * r * r * r, mean += w * x, first += w * d;
            second += w * glm::outerProduct(d, d);
            radius = std::max(radius, r), reach = std::max(reach, glm::length(x));
        }
        if (weight > 0) mean /= weight;
    }
    double spread() const { return weight > 0 ? std::cbrt(cubes / weight) : 0; }
    double trace() const { return second[0][0] + second[1][1] + second[2][2]; }
};

void check_bounds(const SumTree::Block& block, int lane, const Loop& loop) {
    EXPECT_GE(block.radius[lane], loop.radius);
    EXPECT_LE(block.spread[lane], block.radius[lane]);
    EXPECT_GE(block.spread[lane], loop.spread() * (1 - 1e-7));
    EXPECT_GE(block.drift[lane] * (1 + 1e-6), glm::length(loop.first) - 1e-14 * loop.reach);
    // Large nodes add up bounds of their children's: measured 1.66 times as large at most.
    EXPECT_LE(block.radius[lane], 2 * loop.radius + 1e-6 * loop.reach);
    EXPECT_LE(block.spread[lane], 2 * loop.spread() + 1e-6 * loop.reach);
}

// Floats rounded once from doubles: half an ulp, 6e-8.
void check_moments(const SumTree::Block& block, int lane, const Loop& loop) {
    const DVec3 center(block.x[lane], block.y[lane], block.z[lane]);
    if (loop.weight > 0) {
        ASSERT_LT(glm::length(center - loop.mean), 1.1e-7 * loop.reach);
    }
    ASSERT_NEAR(block.weight[lane], loop.weight, 7e-8 * loop.weight);
    const double error = 7e-8 * loop.trace() + 1e-14 * loop.reach * loop.reach;
    ASSERT_NEAR(block.xx[lane], loop.second[0][0], error);
    ASSERT_NEAR(block.yy[lane], loop.second[1][1], error);
    ASSERT_NEAR(block.zz[lane], loop.second[2][2], error);
    ASSERT_NEAR(block.xy[lane], loop.second[0][1], error);
    ASSERT_NEAR(block.xz[lane], loop.second[0][2], error);
    ASSERT_NEAR(block.yz[lane], loop.second[1][2], error);
}

// Calls body(block, lane) for all lanes of a tree that hold points.
template <class Body>
void for_each_node(const SumTree& tree, const Body& body) {
    for (const SumTree::Block& block : tree.blocks())
        for (int lane = 0; lane < SumTree::kChildren; ++lane)
            if (block.count[lane] > 0) body(block, lane);
}

void check_tree(const SumTree& tree) {
    for_each_node(tree, [&](const SumTree::Block& block, int lane) {
        const auto points = tree.points().subspan(block.first[lane], block.count[lane]);
        const Loop loop(points, DVec3(block.x[lane], block.y[lane], block.z[lane]));
        check_bounds(block, lane, loop);
        check_moments(block, lane, loop);
    });
}

TEST(SumTree, MomentsAreThoseOfTheirPoints) {
    for (std::uint64_t seed = 0; seed < 6; ++seed)
        for (const std::size_t n : {1, 7, 300, 5000})
            for (const double distance : {0.0, 1e2, 1e6})
                check_tree(tree_of(box(seed, n, DVec3(distance), seed % 2 == 1)));
}

TEST(SumTree, MomentsOnASurface) {
    Draw draw(1);
    const auto points = test::bumpy_shell(draw, 20000);
    check_tree(tree_of(test::sorted_cloud(points, test::random_weights(draw, points.size()))));
}

TEST(SumTree, WithoutAnyWeight) {
    WeightedCloud cloud = box(0, 1000, DVec3(0), false);
    std::fill(cloud.weights.begin(), cloud.weights.end(), 0.0f);
    const SumTree tree = tree_of(cloud);
    EXPECT_EQ(tree.total_weight(), 0);
    check_tree(tree);
}

// Leaves reached from the root, and how often each of their points was.
void visit(const SumTree& tree, std::uint32_t b, int lane, std::vector<int>& visits) {
    const SumTree::Block& block = tree.blocks()[b];
    const std::uint32_t first = block.first[lane], end = first + block.count[lane];
    const std::uint32_t child = block.child[lane];
    if (child == SumTree::kLeaf) {
        for (std::uint32_t j = first; j < end; ++j) ++visits[j];
        return;
    }
    ASSERT_GT(child, b);  // so that no walk is endless
    ASSERT_LT(child, tree.blocks().size());
    const SumTree::Block& below = tree.blocks()[child];
    for (int k = 0; k < SumTree::kChildren; ++k) {
        if (below.count[k] > 0) {
            ASSERT_TRUE(below.first[k] >= first && below.first[k] + below.count[k] <= end);
        }
        visit(tree, child, k, visits);
    }
}

TEST(SumTree, EveryPointIsInExactlyOneLeaf) {
    for (const std::size_t n : {1, 2, 8, 9, 100, 20000}) {
        const SumTree tree = tree_of(box(n, n, DVec3(0), false));
        std::vector<int> visits(n);
        visit(tree, 0, 0, visits);
        EXPECT_EQ(tree.blocks()[0].count[0], n);
        for (int lane = 1; lane < SumTree::kChildren; ++lane)
            EXPECT_EQ(tree.blocks()[0].count[lane], 0u);
        for (const int v : visits) ASSERT_EQ(v, 1);
    }
}

TEST(SumTree, MissingSiblingsWeighNothing) {
    const SumTree tree = tree_of(box(3, 3000, DVec3(1e3), false));
    for (const SumTree::Block& block : tree.blocks())
        for (int lane = 0; lane < SumTree::kChildren; ++lane) {
            if (block.count[lane] > 0) continue;
            EXPECT_EQ(block.weight[lane], 0);
            EXPECT_EQ(block.child[lane], SumTree::kLeaf);
            EXPECT_EQ(block.radius[lane], 0);
            EXPECT_EQ(block.xx[lane] + block.yy[lane] + block.zz[lane], 0);
        }
}

TEST(SumTree, OfNoPointsIsEmpty) { EXPECT_TRUE(tree_of({}).blocks().empty()); }

}  // namespace
}  // namespace tallow
