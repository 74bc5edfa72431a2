// SPDX-License-Identifier: Apache-2.0
#include "common/nbody/target_groups.h"

#include <gtest/gtest.h>

#include "tests/support/point_clouds.h"

namespace tallow {
namespace {

using test::Draw;

constexpr double kUnit = 0.25;  // a power of two: positions in units are exact
constexpr std::uint32_t kMostPoints = 256;

double distance(Vec3 a, Vec3 b) { return glm::length(DVec3(a) - DVec3(b)); }

void check_packet(const TargetGroups& targets, const TargetGroups::Packet& packet,
                  const TargetGroups::Group& group, std::span<const Vec3> positions,
                  std::vector<int>& visits) {
    ASSERT_TRUE(packet.count >= 1 && packet.count <= TargetGroups::kPacketSize);
    for (std::uint32_t i = 0; i < TargetGroups::kPacketSize; ++i) {
        const std::uint32_t k = packet.first + std::min(i, packet.count - 1);
        const std::uint32_t target = targets.order()[k];
        const Vec3 x(packet.x[i], packet.y[i], packet.z[i]);
        EXPECT_EQ(x, float(1 / kUnit) * positions[target]);
        EXPECT_LE(distance(x, packet.center), packet.radius);
        EXPECT_LE(distance(x, group.center), group.radius);
        if (i < packet.count) ++visits[target];
    }
}

void check(std::span<const Vec3> positions) {
    const TargetGroups targets(positions, kUnit);
    std::vector<int> visits(positions.size());
    std::uint32_t packets = 0;
    for (const TargetGroups::Group& group : targets.groups()) {
        ASSERT_EQ(group.first_packet, packets);
        packets += group.packets;
        EXPECT_LE(group.points, kMostPoints);
        std::uint32_t points = 0;
        for (std::uint32_t p = group.first_packet; p < packets; ++p) {
            check_packet(targets, targets.packets()[p], group, positions, visits);
            points += targets.packets()[p].count;
        }
        EXPECT_EQ(points, group.points);
    }
    EXPECT_EQ(packets, targets.packets().size());
    for (const int v : visits) ASSERT_EQ(v, 1);
}

TEST(TargetGroups, HoldEveryTargetOnce) {
    Draw draw(1);
    for (const std::size_t n : {1, 2, 15, 16, 17, 256, 257, 20000})
        check(test::bumpy_shell(draw, n));
}

TEST(TargetGroups, FarFromTheOrigin) {
    Draw draw(2);
    std::vector<Vec3> points(3000);
    for (Vec3& p : points) p = Vec3(1e6 + draw.in_box());
    check(points);
}

// More of them than a group holds, with and without others around.
TEST(TargetGroups, CoincidentPoints) {
    std::vector<Vec3> points(1000, Vec3(1, 2, 3));
    check(points);
    const TargetGroups targets(points, kUnit);
    for (const TargetGroups::Group& group : targets.groups()) EXPECT_EQ(group.radius, 0);
    Draw draw(3);
    for (int i = 0; i < 1000; ++i) points.push_back(Vec3(1e3 * draw.in_box()));
    check(points);
}

TEST(TargetGroups, CollinearPoints) {
    std::vector<Vec3> points;
    for (int i = 0; i < 5000; ++i) points.push_back(float(i % 1777) * Vec3(1, 0, 0));
    check(points);
}

// Groups are worth it only if they hold many points. Measured 151 a group, 15.2 a packet.
TEST(TargetGroups, AreWellFilled) {
    Draw draw(4);
    const auto points = test::bumpy_shell(draw, 20000);
    const TargetGroups targets(points, kUnit);
    EXPECT_GT(double(points.size()) / double(targets.groups().size()), 100);
    EXPECT_GT(double(points.size()) / double(targets.packets().size()), 14);
}

TEST(TargetGroups, OfNoPoints) { check({}); }

}  // namespace
}  // namespace tallow
