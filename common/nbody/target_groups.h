// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/vec.h"

namespace tallow {

/// Points at which sums are wanted, sorted so that neighbours share work: packets of up to 16, and
/// groups of neighbouring packets. All lengths in `unit`.
class TargetGroups {
public:
    static constexpr int kPacketSize = 16;  // floats in the widest SIMD register there is

    /// Balls hold their points.
    struct Packet {
        alignas(64) float x[kPacketSize], y[kPacketSize], z[kPacketSize];  // last one repeated
        std::uint32_t first, count;                                        // its points in order()
        Vec3 center;
        float radius;
    };
    struct Group {
        std::uint32_t first_packet, packets;
        std::uint32_t points;
        Vec3 center;
        float radius;
    };

    TargetGroups(std::span<const Vec3> positions, double unit);

    std::span<const Packet> packets() const { return packets_; }
    std::span<const Group> groups() const { return groups_; }
    /// order()[k] is the index of the k-th sorted point.
    std::span<const std::uint32_t> order() const { return order_; }
    double unit() const { return unit_; }

private:
    std::vector<std::uint32_t> order_;
    std::vector<Packet> packets_;
    std::vector<Group> groups_;
    double unit_;
};

}  // namespace tallow
