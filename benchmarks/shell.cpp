// SPDX-License-Identifier: Apache-2.0
#include "benchmarks/shell.h"

#include <cmath>
#include <map>

#include "common/base/check.h"
#include "common/base/rng.h"
#include "common/cloud/morton.h"
#include "common/optics/profile.h"
#include "common/scene/presets.h"
#include "precompute/build_octree.h"
#include "tests/support/ball_mesh.h"

namespace tallow {
namespace {

constexpr float kRadius = 20;  // mm

// Bumps of 5 % and half a radian: curvature differs from place to place, as on a scanned mesh.
Vec3 on_shell(Vec3 direction) {
    const Vec3 d = direction;
    return kRadius * (1 + 0.05f * std::sin(9 * d.x) * std::sin(11 * d.y) * std::sin(10 * d.z)) * d;
}

Vec3 direction_at(float z, float phi) {
    const float s = std::sqrt(std::max(0.0f, 1 - z * z));
    return {s * std::cos(phi), s * std::sin(phi), z};
}

Shell make_shell(std::size_t samples) {
    Shell result;
    const std::vector<Vec3> scattered = scattered_points(samples);
    for (const std::uint32_t i : sorted_order(morton_codes(scattered)))
        result.position.push_back(scattered[i]);
    for (const Vec3 p : result.position) {
        const float cell = 2 * kTwoPi * length2(p) / float(samples);
        const float light = 0.05f + std::max(0.0f, glm::dot(p, Vec3(0.6f, 0, -0.8f)) / kRadius);
        result.area.push_back(cell);
        result.weight.push_back(cell * light);
    }
    result.nodes = build_octree(result.position);
    return result;
}

}  // namespace

std::vector<Vec3> scattered_points(std::size_t count) {
    std::vector<Vec3> points(count);
    const double turn = 2 * std::numbers::pi / std::numbers::phi;  // Fibonacci's lattice, jittered
    for (std::size_t i = 0; i < count; ++i) {
        const auto random = [&](int stream) {
            return to_unit_float(random_bits(1, std::uint64_t(stream), i));
        };
        const double z = 1 - 2 * (double(i) + random(0)) / double(count);
        const double cell = std::sqrt(4 * std::numbers::pi / double(count));
        const double phi = std::fmod(turn * double(i), 2 * std::numbers::pi) +
                           cell * (random(1) - 0.5) / std::sqrt(1 - z * z + cell * cell);
        points[i] = on_shell(direction_at(float(z), float(phi)));
    }
    return points;
}

std::vector<Vec3> seen_points(std::size_t count) {
    const int side = int(std::lround(std::sqrt(4 / std::numbers::pi * double(count))));
    std::vector<Vec3> points;
    for (int row = 0; row < side; ++row)
        for (int column = 0; column < side; ++column) {
            const Vec2 p(2 * (float(column) + 0.5f) / float(side) - 1,
                         2 * (float(row) + 0.5f) / float(side) - 1);
            const float rest = 1 - glm::dot(p, p);
            if (rest > 0) points.push_back(on_shell({p.x, p.y, std::sqrt(rest)}));
        }
    return points;
}

TriangleMesh shell_mesh() {
    return test::ball_mesh(7, [](Vec3 d) { return glm::length(on_shell(d)); });
}

const Shell& shell(std::size_t samples) {
    static std::map<std::size_t, Shell> made;
    const auto found = made.find(samples);
    return found != made.end() ? found->second
                               : made.emplace(samples, make_shell(samples)).first->second;
}

const Medium& marble() {
    const Preset* preset = find_preset("marble");
    TALLOW_CHECK(preset != nullptr, "no preset marble");
    return preset->medium;
}

KernelTable marble_table() {
    const float scale = marble().mean_free_path().g;
    return tabulate(*make_profile(Model::dipole, marble(), 1, Orders::all), scale,
                    KernelTable::unit_near(scale));
}

}  // namespace tallow
