// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <bit>

#include "common/base/parallel.h"
#include "common/base/rng.h"
#include "common/cloud/morton.h"
#include "precompute/build_octree.h"

namespace tallow {
namespace {

// Points of a bumpy surface in Morton order: some coincide, a third is crowded into a corner.
std::vector<Vec3> sorted_points(std::uint64_t seed, std::size_t n) {
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < n; ++i) {
        const float u = to_unit_float(random_bits(seed, 0, i));
        const float v = to_unit_float(random_bits(seed, 1, i));
        const Vec3 p(u, v, 0.2f * std::sin(9 * u) * v);
        points.push_back(i % 3 == 0 ? Vec3(1) + 1e-3f * p : p);
    }
    for (std::size_t i = 0; i + 4 < n; i += 50) points[i + 3] = points[i];
    std::vector<Vec3> sorted;
    for (std::uint32_t i : sorted_order(morton_codes(points))) sorted.push_back(points[i]);
    return sorted;
}

// One pass for every node and no tasks: what build_octree must agree with.
void append_twin(std::span<const std::uint64_t> codes, std::uint32_t first, std::uint32_t last,
                 std::vector<OctreeNode>& nodes) {
    const std::size_t self = nodes.size();
    nodes.push_back({first, last - first, 1});
    const std::uint64_t differing = codes[first] ^ codes[last - 1];
    if (last - first > kLeafSize && differing != 0) {
        const int shift = (int(std::bit_width(differing)) - 1) / 3 * 3;
        for (std::uint32_t i = first + 1, begin = first; i <= last; ++i)
            if (i == last || codes[i] >> shift != codes[begin] >> shift) {
                append_twin(codes, begin, i, nodes);
                begin = i;
            }
    }
    nodes[self].skip = std::uint32_t(nodes.size() - self);
}

// Up to sizes that are built in several tasks.
TEST(Octree, AgreesWithItsPlainTwin) {
    for (std::size_t n : {1u, 7u, 8u, 9u, 100u, 5000u, 60000u}) {
        const std::vector<Vec3> points = sorted_points(n, n);
        std::vector<OctreeNode> expected;
        append_twin(morton_codes(points), 0, std::uint32_t(n), expected);
        EXPECT_EQ(build_octree(points), expected) << n << " points";
    }
    EXPECT_TRUE(build_octree({}).empty());
}

// Children partition their parent; a walk by skips visits every point once.
TEST(Octree, ChildrenPartitionTheirParent) {
    for (std::size_t n : {1u, 7u, 9u, 100u, 60000u}) {
        const std::vector<OctreeNode> nodes = build_octree(sorted_points(n, n));
        ASSERT_FALSE(nodes.empty());
        EXPECT_EQ(nodes[0].skip, nodes.size());
        EXPECT_EQ(nodes[0].count, n);
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            if (nodes[i].skip == 1) continue;
            std::uint32_t next = nodes[i].first, children = 0;
            for (std::size_t c = i + 1; c < i + nodes[i].skip; c += nodes[c].skip, ++children) {
                EXPECT_EQ(nodes[c].first, next);
                next += nodes[c].count;
            }
            EXPECT_EQ(next, nodes[i].first + nodes[i].count);
            EXPECT_GE(children, 2u);
            EXPECT_LE(children, 8u);
        }
    }
}

TEST(Octree, CoincidentPointsShareALeaf) {
    for (std::uint32_t n : {100u, 40000u}) {
        const std::vector<Vec3> same(n, Vec3(1, 2, 3));
        EXPECT_EQ(build_octree(same), (std::vector<OctreeNode>{{0, n, 1}}));
    }
}

TEST(Octree, IsTheSameForAnyNumberOfThreads) {
    const std::vector<Vec3> points = sorted_points(1, 150000);
    const std::vector<OctreeNode> expected = build_octree(points);
    for (int threads : {1, 2, 5}) {
        const ThreadLimit limit(threads);
        EXPECT_EQ(build_octree(points), expected) << threads << " threads";
    }
}

}  // namespace
}  // namespace tallow
