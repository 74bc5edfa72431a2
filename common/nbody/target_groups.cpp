// SPDX-License-Identifier: Apache-2.0
// Points -> Morton order -> groups, which are octants or runs of neighbouring octants under one
// parent -> packets, cut from a group in order.
#include "common/nbody/target_groups.h"

#include <algorithm>

#include "common/base/parallel.h"
#include "common/cloud/morton.h"

namespace tallow {
namespace {

// Points of a group at most. Measured on the bunny, 113k points, 1 %: 64 and 512 are slower by a
// tenth, 128 is as good.
constexpr std::uint32_t kGroupSize = 256;
constexpr int kBits =
    10;  // per axis: 30 bits sort in three passes, and order 1e6 points on a surface

struct Run {
    std::uint32_t begin, end;
    std::uint32_t size() const { return end - begin; }
};

class GroupCutter {
public:
    explicit GroupCutter(std::vector<std::uint64_t> codes) : codes_(std::move(codes)) {}

    std::vector<Run> cut() {
        if (!codes_.empty()) add({0, std::uint32_t(codes_.size())}, kBits - 1);
        return std::move(groups_);
    }

private:
    // Adds the groups of a run of points that share an octant above `level`.
    void add(Run run, int level) {
        if (run.size() <= kGroupSize) {
            groups_.push_back(run);
        } else if (level < 0) {  // all in one cell: any cut is as good
            for (std::uint32_t i = run.begin; i < run.end; i += kGroupSize)
                groups_.push_back({i, std::min(i + kGroupSize, run.end)});
        } else {
            add_octants(run, level);
        }
    }

    // Octants that fit into one group together become one.
    void add_octants(Run run, int level) {
        Run pending{run.begin, run.begin};
        while (pending.end < run.end) {
            const Run octant{pending.end, octant_end(pending.end, run.end, level)};
            if (octant.end - pending.begin > kGroupSize) {
                if (pending.size() > 0) groups_.push_back(pending);
                pending.begin = octant.begin;
                if (octant.size() > kGroupSize) {
                    add(octant, level - 1);
                    pending.begin = octant.end;
                }
            }
            pending.end = octant.end;
        }
        if (pending.size() > 0) groups_.push_back(pending);
    }

    std::uint32_t octant_end(std::uint32_t begin, std::uint32_t end, int level) const {
        const std::uint64_t octant = codes_[begin] >> (3 * level);
        const auto last =
            std::partition_point(codes_.begin() + begin, codes_.begin() + end,
                                 [&](std::uint64_t code) { return code >> (3 * level) == octant; });
        return std::uint32_t(last - codes_.begin());
    }

    std::vector<std::uint64_t> codes_;
    std::vector<Run> groups_;
};

struct Ball {
    Vec3 center;
    float radius;
};

// About the middle of the points' box; a little larger than in exact arithmetic.
Ball ball_around(std::span<const Vec3> points) {
    Vec3 low(kInfinity), high(-kInfinity);
    for (const Vec3 p : points) low = glm::min(low, p), high = glm::max(high, p);
    const Vec3 center = low + 0.5f * (high - low);
    float radius2 = 0;
    for (const Vec3 p : points) radius2 = std::max(radius2, length2(p - center));
    return {center, std::sqrt(radius2) * (1 + 1e-6f)};
}

}  // namespace

TargetGroups::TargetGroups(std::span<const Vec3> positions, double unit) : unit_(unit) {
    const std::vector<std::uint64_t> codes = morton_codes(positions, kBits);
    order_ = sorted_order(codes);
    std::vector<std::uint64_t> sorted(codes.size());
    std::vector<Vec3> points(codes.size());
    const float to_units = float(1 / unit);
    parallel_for(codes.size(), 16384, [&](std::size_t k) {
        sorted[k] = codes[order_[k]];
        points[k] = to_units * positions[order_[k]];
    });

    const std::vector<Run> runs = GroupCutter(std::move(sorted)).cut();
    std::uint32_t packets = 0;
    for (const Run& run : runs) {
        const std::uint32_t count = (run.size() + kPacketSize - 1) / kPacketSize;
        groups_.push_back({packets, count, run.size(), {}, 0});
        packets += count;
    }
    packets_.resize(packets);
    parallel_for(runs.size(), 64, [&](std::size_t g) {
        Group& group = groups_[g];
        const auto of_group = std::span(points).subspan(runs[g].begin, runs[g].size());
        const Ball ball = ball_around(of_group);
        group.center = ball.center, group.radius = ball.radius;
        for (std::uint32_t p = 0; p < group.packets; ++p) {
            const std::uint32_t begin = p * kPacketSize;
            const auto of_packet = of_group.subspan(
                begin, std::min<std::size_t>(kPacketSize, of_group.size() - begin));
            Packet& packet = packets_[group.first_packet + p];
            packet.first = runs[g].begin + begin, packet.count = std::uint32_t(of_packet.size());
            const Ball own = ball_around(of_packet);
            packet.center = own.center, packet.radius = own.radius;
            for (std::size_t i = 0; i < kPacketSize; ++i) {
                const Vec3 x = of_packet[std::min(i, of_packet.size() - 1)];
                packet.x[i] = x.x, packet.y[i] = x.y, packet.z[i] = x.z;
            }
        }
    });
}

}  // namespace tallow
