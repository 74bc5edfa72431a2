// SPDX-License-Identifier: Apache-2.0
// Cuts surfaces into cells of known area: meshes by bisection, spheres and discs in their own
// coordinates, where the area of a cell is a closed form or a smooth integral.
#include "precompute/surface_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/matrix_inverse.hpp>

#include "common/base/parallel.h"

namespace tallow {
namespace {

// ---- triangles -----------------------------------------------------------------------------

struct Corner {
    Vec3 position;
    Vec3 normal;
};

Corner midpoint(const Corner& a, const Corner& b) {
    return {0.5f * (a.position + b.position), 0.5f * (a.normal + b.normal)};
}

// Longest edge of a cell in spacings. Bisected right-angled triangles then have areas between 0.71
// and 1.41 of spacing^2.
constexpr float kLongestEdge = 2.3784142f;  // 2^(5/4)

class Bisection {
public:
    Bisection(float spacing, std::vector<Cell>& cells)
        : limit2_(kLongestEdge * kLongestEdge * spacing * spacing), cells_(cells) {}

    // `area` is halved exactly with each cut: the cells of a triangle sum to its area.
    void cut(const Corner& a, const Corner& b, const Corner& c, double area) {
        const float ab = length2(b.position - a.position);
        const float bc = length2(c.position - b.position);
        const float ca = length2(a.position - c.position);
        const float longest = std::max({ab, bc, ca});
        if (longest <= limit2_) return emit(a, b, c, area);
        if (longest == ab) return cut_first_edge(a, b, c, area);
        if (longest == bc) return cut_first_edge(b, c, a, area);
        cut_first_edge(c, a, b, area);
    }

private:
    void cut_first_edge(const Corner& a, const Corner& b, const Corner& c, double area) {
        const Corner m = midpoint(a, b);
        cut(a, m, c, area / 2);
        cut(m, b, c, area / 2);
    }

    void emit(const Corner& a, const Corner& b, const Corner& c, double area) {
        const Vec3 center = (a.position + b.position + c.position) / 3.0f;
        cells_.push_back({center, glm::normalize(a.normal + b.normal + c.normal), float(area)});
    }

    float limit2_;
    std::vector<Cell>& cells_;
};

std::array<Corner, 3> corners(const TriangleMesh& mesh, std::size_t t) {
    std::array<Corner, 3> result;
    const Vec3 flat = mesh.corner_normals.empty() ? triangle_normal(mesh, t) : Vec3(0);
    for (std::size_t k = 0; k < 3; ++k)
        result[k] = {mesh.vertices[mesh.triangles[t][k]],
                     mesh.corner_normals.empty() ? flat : mesh.corner_normals[3 * t + k]};
    return result;
}

// ---- bands and rings -----------------------------------------------------------------------

// Three-point Gauss-Legendre rule on [-1, 1].
constexpr double kNode[3] = {-0.7745966692414834, 0, 0.7745966692414834};
constexpr double kWeight[3] = {5.0 / 9, 8.0 / 9, 5.0 / 9};

// Largest factor by which the map stretches a length: the square root of the largest eigenvalue of
// L^T L, bounded by its trace's root and found by power iteration.
double largest_stretch(const glm::dmat3& linear) {
    const glm::dmat3 square = glm::transpose(linear) * linear;
    DVec3 v(1, 1, 1);
    for (int i = 0; i < 64; ++i) {
        const DVec3 next = square * v;
        v = glm::length(next) > 0 ? glm::normalize(next) : DVec3(square[i % 3]);
    }
    return std::sqrt(glm::length(square * v));
}

DVec3 sphere_point(double z, double phi) {
    const double s = std::sqrt(std::max(0.0, 1 - z * z));
    return {s * std::cos(phi), s * std::sin(phi), z};
}

// Area of the image of the cell [z0, z1] x [phi0, phi1] of the unit sphere: on it dA = dz dphi, and
// the map scales an area with unit normal n by |cofactor(linear) n|.
double mapped_area(const glm::dmat3& cofactor, double z0, double z1, double phi0, double phi1) {
    double sum = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const double z = (z0 + z1) / 2 + kNode[i] * (z1 - z0) / 2;
            const double phi = (phi0 + phi1) / 2 + kNode[j] * (phi1 - phi0) / 2;
            sum += kWeight[i] * kWeight[j] * glm::length(cofactor * sphere_point(z, phi));
        }
    return sum * (z1 - z0) * (phi1 - phi0) / 4;
}

}  // namespace

std::vector<Cell> mesh_cells(const TriangleMesh& mesh, float spacing) {
    // Blocks of fixed size, joined in order: the same cells for any number of threads.
    constexpr std::size_t kBlock = 4096;
    const std::size_t blocks = (mesh.triangles.size() + kBlock - 1) / kBlock;
    std::vector<std::vector<Cell>> parts(blocks);
    parallel_for(blocks, 1, [&](std::size_t block) {
        Bisection bisection(spacing, parts[block]);
        const std::size_t end = std::min(mesh.triangles.size(), (block + 1) * kBlock);
        for (std::size_t t = block * kBlock; t < end; ++t) {
            const auto [a, b, c] = corners(mesh, t);
            bisection.cut(a, b, c, triangle_area(mesh, t));
        }
    });
    std::vector<Cell> cells;
    for (const auto& part : parts) cells.insert(cells.end(), part.begin(), part.end());
    return cells;
}

std::vector<Cell> sphere_cells(const SphereSurface& sphere, float spacing) {
    const glm::dmat3 linear(sphere.to_world.linear);
    const glm::dmat3 cofactor = glm::abs(glm::determinant(linear)) * glm::inverseTranspose(linear);
    const double step = spacing / largest_stretch(linear);  // on the unit sphere
    const int bands = std::max(2, int(std::ceil(std::numbers::pi / step)));

    std::vector<Cell> cells;
    for (int band = 0; band < bands; ++band) {
        const double theta0 = std::numbers::pi * band / bands;
        const double theta1 = std::numbers::pi * (band + 1) / bands;
        const double z0 = std::cos(theta1), z1 = std::cos(theta0), z = (z0 + z1) / 2;
        const double circumference = 2 * std::numbers::pi * std::sqrt(1 - z * z);
        const int count = std::max(3, int(std::ceil(circumference * bands / std::numbers::pi)));
        for (int k = 0; k < count; ++k) {
            const double phi0 = 2 * std::numbers::pi * k / count;
            const double phi1 = 2 * std::numbers::pi * (k + 1) / count;
            const DVec3 p = sphere_point(z, (phi0 + phi1) / 2);
            cells.push_back({sphere.to_world.point(Vec3(p)), sphere.to_world.normal(Vec3(p)),
                             float(mapped_area(cofactor, z0, z1, phi0, phi1))});
        }
    }
    return cells;
}

std::vector<Cell> plane_cells(const PlaneSurface& plane, float spacing) {
    const Frame frame = make_frame(plane.normal);
    const int rings = std::max(1, int(std::ceil(plane.radius / spacing)));
    const double width = double(plane.radius) / rings;
    std::vector<Cell> cells;
    for (int ring = 0; ring < rings; ++ring) {
        const double r0 = ring * width, r1 = (ring + 1) * width;
        const int count = ring == 0 ? 4 : int(std::ceil(std::numbers::pi * (r0 + r1) / width));
        const double angle = 2 * std::numbers::pi / count;
        // Distance of a ring sector's centroid from the centre.
        const double r = 2.0 / 3 * (r1 * r1 * r1 - r0 * r0 * r0) / (r1 * r1 - r0 * r0) *
                         std::sin(angle / 2) / (angle / 2);
        const auto area = float(angle * (r1 * r1 - r0 * r0) / 2);
        for (int k = 0; k < count; ++k) {
            const double phi = (k + 0.5) * angle;
            const Vec3 offset =
                float(r * std::cos(phi)) * frame.s + float(r * std::sin(phi)) * frame.t;
            cells.push_back({plane.point + offset, plane.normal, area});
        }
    }
    return cells;
}

}  // namespace tallow
