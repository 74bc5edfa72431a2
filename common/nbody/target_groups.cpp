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

// The radius of a group of more than one packet at most, in units: of what is near to a wider one
// little is near to each of its packets. Measured on clusters of the bunny, three units apart: 3 to
// 12 are alike, no limit takes a half longer.
constexpr float kGroupRadius = 8;

constexpr int kBits =
    10;  // per axis: 30 bits sort in three passes, and order 1e6 points on a surface

// Half the diagonal of a packet's box at most, in units, which are about a mean free path. Wider
// ones have so many near nodes, each summed for all their points, that fewer points at a time are
// faster. Measured on the bunny, 64 to 512 pixels across: 2.5 and 4 are alike, 1 and no limit
// slower; on 2000 clusters 2 is faster by 6 %, but thresholds were fitted to 3.
constexpr float kPacketRadius = 3;

struct Run {
    std::uint32_t begin, end;
    std::uint32_t size() const { return end - begin; }
};

float half_diagonal(std::span<const Vec3> points) {
    Vec3 low(kInfinity), high(-kInfinity);
    for (const Vec3 p : points) low = glm::min(low, p), high = glm::max(high, p);
    return glm::length(high - low) / 2;
}

class GroupCutter {
public:
    /// Points in units, and their codes, in the order of these.
    GroupCutter(std::vector<std::uint64_t> codes, std::span<const Vec3> points)
        : codes_(std::move(codes)), points_(points) {}

    std::vector<Run> cut() {
        if (!codes_.empty()) add({0, std::uint32_t(codes_.size())}, kBits - 1);
        return std::move(groups_);
    }

private:
    bool is_group(Run run) const {
        if (run.size() > kGroupSize) return false;
        return run.size() <= TargetGroups::kPacketSize ||
               half_diagonal(points_.subspan(run.begin, run.size())) <= kGroupRadius;
    }

    // Adds the groups of a run of points that share an octant above `level`.
    void add(Run run, int level) {
        if (is_group(run)) {
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
            if (!is_group({pending.begin, octant.end})) {
                if (pending.size() > 0) groups_.push_back(pending);
                pending.begin = octant.begin;
                if (!is_group(octant)) {
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
    std::span<const Vec3> points_;
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

// Cuts a group into packets: runs of up to kPacketSize points that a ball of kPacketRadius holds.
std::vector<Run> cut_into_packets(std::span<const Vec3> points, const Run& group) {
    std::vector<Run> packets;
    for (std::uint32_t begin = group.begin; begin < group.end;) {
        std::uint32_t end = begin + 1;
        Vec3 low = points[begin], high = low;
        for (; end < group.end && end - begin < TargetGroups::kPacketSize; ++end) {
            const Vec3 p = points[end];
            low = glm::min(low, p), high = glm::max(high, p);
            if (length2(high - low) > 4 * kPacketRadius * kPacketRadius) break;
        }
        packets.push_back({begin, end});
        begin = end;
    }
    return packets;
}

TargetGroups::Packet make_packet(std::span<const Vec3> points, const Run& run) {
    const auto of_packet = points.subspan(run.begin, run.size());
    const Ball ball = ball_around(of_packet);
    TargetGroups::Packet packet;
    packet.first = run.begin, packet.count = run.size();
    packet.center = ball.center, packet.radius = ball.radius;
    for (std::uint32_t i = 0; i < TargetGroups::kPacketSize; ++i) {
        const Vec3 x = of_packet[std::min(i, run.size() - 1)];
        packet.x[i] = x.x, packet.y[i] = x.y, packet.z[i] = x.z;
    }
    return packet;
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

    const std::vector<Run> groups = GroupCutter(std::move(sorted), points).cut();
    std::vector<std::vector<Run>> packets(groups.size());
    parallel_for(groups.size(), 64,
                 [&](std::size_t g) { packets[g] = cut_into_packets(points, groups[g]); });
    std::uint32_t count = 0;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        const Ball ball = ball_around(std::span(points).subspan(groups[g].begin, groups[g].size()));
        groups_.push_back(
            {count, std::uint32_t(packets[g].size()), groups[g].size(), ball.center, ball.radius});
        count += std::uint32_t(packets[g].size());
    }
    packets_.resize(count);
    parallel_for(groups.size(), 64, [&](std::size_t g) {
        for (std::size_t p = 0; p < packets[g].size(); ++p)
            packets_[groups_[g].first_packet + p] = make_packet(points, packets[g][p]);
    });
}

}  // namespace tallow
