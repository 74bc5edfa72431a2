// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/vec.h"
#include "common/cloud/point_octree.h"

namespace tallow {

/// The sum of PointSum by the method of [JB02]: one point at a time, in scalar code, a node's
/// points replaced by their centroid where the node's area is seen under a small enough solid
/// angle. The baseline that experiments compare PointSum with; with a solid angle of 0 the plain
/// sum.
///
///     M(x) = sum over j of w_j K(|x - x_j|^2)
class SolidAngleSum {
public:
    struct Node {
        Vec3 centroid;  // of the weights
        float weight;   // sum of the weights beneath
        float radius2;  // squared radius of the ball around the centroid that holds all points
        float area;     // sum of the areas beneath
        std::uint32_t first, count, skip;
    };
    struct Point {
        Vec3 position;
        float weight;
    };

    /// `areas` are the surface cells of the points; they decide when a node is far enough. All
    /// spans but the nodes have one item a point, in the order that the nodes refer to.
    SolidAngleSum(std::span<const Vec3> positions, std::span<const float> weights,
                  std::span<const float> areas, std::span<const OctreeNode> nodes);

    /// The sum at x. A node stands for its points if x lies outside the ball around its centroid
    /// that holds them, and the node's area is seen from x under at most `max_solid_angle`
    /// (area / distance^2); 0 gives the plain sum over all points.
    ///
    /// Kernel   float(float r2), r2 in mm^2. `evaluations` grows by the number of its calls.
    /// Source   [JB02] section 3.3.
    template <class Kernel>
    double evaluate(Vec3 x, float max_solid_angle, const Kernel& kernel,
                    std::uint64_t& evaluations) const;

    std::span<const Node> nodes() const { return nodes_; }
    std::span<const Point> points() const { return points_; }

private:
    std::vector<Node> nodes_;
    std::vector<Point> points_;
};

template <class Kernel>
double SolidAngleSum::evaluate(Vec3 x, float max_solid_angle, const Kernel& kernel,
                               std::uint64_t& evaluations) const {
    double sum = 0;
    for (std::size_t i = 0; i < nodes_.size();) {
        const Node& node = nodes_[i];
        const float d2 = length2(x - node.centroid);
        if (d2 > node.radius2 && node.area <= max_solid_angle * d2) {
            sum += double(node.weight) * double(kernel(d2));
            evaluations += 1;
            i += node.skip;
        } else if (node.skip > 1) {
            ++i;
        } else {
            for (std::uint32_t j = node.first; j < node.first + node.count; ++j)
                sum += double(points_[j].weight) * double(kernel(length2(x - points_[j].position)));
            evaluations += node.count;
            ++i;
        }
    }
    return sum;
}

}  // namespace tallow
