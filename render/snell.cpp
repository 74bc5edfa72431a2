// SPDX-License-Identifier: Apache-2.0
// Snell's law on a path with fixed ends, differentiated.
#include "render/snell.h"

#include <cmath>

namespace tallow {
namespace {

/// Unit direction to a point and its distance.
struct Leg {
    DVec3 w;
    double length;
    /// Change of w when the start moves by dp.
    DVec3 moved(DVec3 dp) const { return (w * glm::dot(w, dp) - dp) / length; }
};

Leg leg(DVec3 from, DVec3 to) {
    const DVec3 d = to - from;
    const double length = glm::length(d);
    return {d / length, length};
}

Leg light_leg(const Ends& ends, DVec3 p) {
    if (ends.y_at_infinity) return {ends.y, double(kInfinity)};
    return leg(p, ends.y);
}

DVec3 tangential(DVec3 v, DVec3 n) { return v - glm::dot(v, n) * n; }

}  // namespace

SnellError snell_error(const Ends& ends, const Patch& patch) {
    const Leg to_x = leg(patch.p, ends.x), to_y = light_leg(ends, patch.p);
    const DVec3 h = ends.eta * to_x.w + to_y.w;
    const DVec3 h_t = tangential(h, patch.n);
    SnellError error;
    error.off = glm::length(h_t);
    for (int k = 0; k < 2; ++k) error.f[k] = glm::dot(h_t, patch.dp[k]);
    // The second derivatives of p are along it in f = h_t . dp and vanish with h_t at the solution.
    for (int j = 0; j < 2; ++j) {
        const DVec3 dh = ends.eta * to_x.moved(patch.dp[j]) + to_y.moved(patch.dp[j]);
        const DVec3 dh_t = tangential(dh, patch.n) - glm::dot(h, patch.dn[j]) * patch.n -
                           glm::dot(h, patch.n) * patch.dn[j];
        for (int k = 0; k < 2; ++k) error.df[j][k] = glm::dot(dh_t, patch.dp[k]);
    }
    return error;
}

bool on_both_sides(const Ends& ends, const Patch& patch, DVec3 normal) {
    const DVec3 to_y = ends.y_at_infinity ? ends.y : ends.y - patch.p;
    return glm::dot(ends.x - patch.p, normal) < 0 && glm::dot(to_y, normal) > 0;
}

double spread(const Ends& ends, const Patch& patch) {
    const Leg to_x = leg(patch.p, ends.x), to_y = light_leg(ends, patch.p);
    const Frame frame = make_frame(Vec3(to_x.w));
    const DVec3 across = glm::normalize(tangential(DVec3(frame.s), to_x.w));
    const DVec3 q[2] = {across, glm::cross(to_x.w, across)};
    glm::dmat2 by_x;
    for (int j = 0; j < 2; ++j)
        for (int k = 0; k < 2; ++k)
            by_x[j][k] = ends.eta / to_x.length * glm::dot(q[j], tangential(patch.dp[k], patch.n));
    const double seen = std::abs(glm::dot(glm::cross(patch.dp[0], patch.dp[1]), to_y.w));
    const double moved =
        std::abs(glm::determinant(by_x) / glm::determinant(snell_error(ends, patch).df));
    return moved * seen / (ends.y_at_infinity ? 1 : to_y.length * to_y.length);
}

}  // namespace tallow
