// SPDX-License-Identifier: Apache-2.0
#include "common/diffusion/layered_nodes.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/point_clouds.h"

namespace tallow {
namespace {

constexpr std::uint32_t kLayers = 5;

test::WeightedCloud shell(std::size_t n) {
    test::Draw draw(1);
    return test::sorted_cloud(test::bumpy_shell(draw, n), std::vector<float>(n, 0.1f));
}

// Children part what their parent has, in order.
void expect_tree(std::span<const OctreeNode> nodes) {
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        ASSERT_GE(nodes[i].skip, 1u);
        ASSERT_LE(i + nodes[i].skip, nodes.size());
        std::uint32_t next = nodes[i].first;
        for (std::size_t c = i + 1; c < i + nodes[i].skip; c += nodes[c].skip) {
            ASSERT_EQ(nodes[c].first, next);
            next += nodes[c].count;
        }
        if (nodes[i].skip == 1) continue;
        ASSERT_EQ(next, nodes[i].first + nodes[i].count);
    }
}

TEST(LayeredNodes, AreATreeOverAllPoints) {
    for (const std::size_t n : {1, 2, 9, 5000}) {
        const test::WeightedCloud cloud = shell(n);
        for (const double split_area : {0.0, 0.3, 20.0, 1e9}) {
            const LayeredNodes nodes(cloud.nodes, cloud.weights, kLayers, split_area);
            ASSERT_EQ(nodes.size(), kLayers * n);
            expect_tree(nodes.nodes());
            EXPECT_EQ(nodes.nodes()[0].count, kLayers * n);
            EXPECT_EQ(nodes.nodes()[0].skip, nodes.nodes().size());
            std::vector<std::size_t> points;
            for (std::size_t i = 0; i < n; ++i)
                for (std::uint32_t k = 0; k < kLayers; ++k) points.push_back(nodes.point(i, k));
            std::ranges::sort(points);
            for (std::size_t p = 0; p < points.size(); ++p) ASSERT_EQ(points[p], p);
        }
    }
}

// A leaf holds points of one layer only.
TEST(LayeredNodes, SmallNodesHaveOneLayer) {
    const test::WeightedCloud cloud = shell(5000);
    const LayeredNodes nodes(cloud.nodes, cloud.weights, kLayers, 2);
    std::vector<std::uint32_t> layer(nodes.size());
    for (std::size_t i = 0; i < 5000; ++i)
        for (std::uint32_t k = 0; k < kLayers; ++k) layer[nodes.point(i, k)] = k;
    for (const OctreeNode& node : nodes.nodes()) {
        if (node.skip > 1) continue;
        EXPECT_LE(node.count, 16u);
        for (std::uint32_t p = node.first; p < node.first + node.count; ++p)
            EXPECT_EQ(layer[p], layer[node.first]);
    }
}

TEST(LayeredNodes, OfNothing) {
    const LayeredNodes nodes({}, {}, kLayers, 1);
    EXPECT_TRUE(nodes.nodes().empty());
    EXPECT_EQ(nodes.size(), 0u);
}

}  // namespace
}  // namespace tallow
