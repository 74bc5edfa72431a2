// SPDX-License-Identifier: Apache-2.0
// Cuts spheres and discs into cells of known area in their own coordinates, where the area of a
// cell is a closed form or a smooth integral.
#include "precompute/surface_cells.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_inverse.hpp>

#include "common/base/parallel.h"

namespace tallow {
namespace {

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

// A latitude band of an ellipsoid, from z0 to z1 on the unit sphere.
struct Band {
    double z0, z1;
    int cells;
};

class Ellipsoid {
public:
    explicit Ellipsoid(const SphereSurface& sphere)
        : to_world_(sphere.to_world),
          linear_(sphere.to_world.linear),
          cofactor_(glm::abs(glm::determinant(linear_)) * glm::inverseTranspose(linear_)),
          stretch_(largest_stretch(linear_)) {
        const glm::dmat3 error = glm::transpose(linear_) * linear_ / (stretch_ * stretch_);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) round_ &= std::abs(error[i][j] - (i == j)) < 1e-6;
    }

    // Bands as wide as the spacing where the map stretches most, with area / spacing^2 cells each.
    std::vector<Band> bands(double spacing) const {
        const int count = std::max(2, int(std::lround(std::numbers::pi * stretch_ / spacing)));
        std::vector<Band> bands(static_cast<std::size_t>(count));
        parallel_for(bands.size(), 16, [&](std::size_t b) {
            const double z0 = std::cos(std::numbers::pi * double(b + 1) / count);
            const double z1 = std::cos(std::numbers::pi * double(b) / count);
            const double cells = band_area(z0, z1) / (spacing * spacing) + dither(b);
            bands[b] = {z0, z1, std::max(3, int(cells))};
        });
        return bands;
    }

    void append(const Band& band, std::vector<Cell>& cells) const {
        const double z = (band.z0 + band.z1) / 2, step = 2 * std::numbers::pi / band.cells;
        for (int k = 0; k < band.cells; ++k) {
            const DVec3 p = sphere_point(z, (k + 0.5) * step);
            const double area = round_ ? stretch_ * stretch_ * step * (band.z1 - band.z0)
                                       : area_between(band.z0, band.z1, k * step, (k + 1) * step);
            cells.push_back({to_world_.point(Vec3(p)), to_world_.normal(Vec3(p)), float(area)});
        }
    }

private:
    double band_area(double z0, double z1) const {
        const double turn = 2 * std::numbers::pi;
        return round_ ? stretch_ * stretch_ * turn * (z1 - z0) : area_between(z0, z1, 0, turn);
    }

    // In panels narrow enough for the quadrature.
    double area_between(double z0, double z1, double phi0, double phi1) const {
        const int panels = int(std::ceil((phi1 - phi0) / 0.2));
        const double step = (phi1 - phi0) / panels;
        double area = 0;
        for (int k = 0; k < panels; ++k)
            area += mapped_area(cofactor_, z0, z1, phi0 + k * step, phi0 + (k + 1) * step);
        return area;
    }

    Affine to_world_;
    glm::dmat3 linear_, cofactor_;
    double stretch_;
    bool round_ = true;
};

// A ring of a disc.
struct Ring {
    double r0, r1;
    int cells;

    double area() const { return std::numbers::pi * (r1 * r1 - r0 * r0); }
};

std::vector<Ring> disc_rings(double radius, double spacing) {
    const int count = std::max(1, int(std::lround(radius / spacing)));
    std::vector<Ring> rings;
    for (int i = 0; i < count; ++i) {
        Ring ring{radius * i / count, radius * (i + 1) / count, 0};
        const double cells = ring.area() / (spacing * spacing) + dither(std::uint64_t(i));
        ring.cells = std::max(3, int(cells));
        rings.push_back(ring);
    }
    return rings;
}

// Calls append(part, cells) for all parts of a surface at once; the cells in their order.
template <class Part, class Append>
std::vector<Cell> append_all(const std::vector<Part>& parts, const Append& append) {
    std::vector<std::vector<Cell>> of_part(parts.size());
    parallel_for(parts.size(), 4, [&](std::size_t i) {
        of_part[i].reserve(std::size_t(parts[i].cells));
        append(parts[i], of_part[i]);
    });
    std::vector<Cell> cells;
    for (const std::vector<Cell>& some : of_part)
        cells.insert(cells.end(), some.begin(), some.end());
    return cells;
}

template <class Part>
double count_cells(const std::vector<Part>& parts) {
    double count = 0;
    for (const Part& part : parts) count += part.cells;
    return count;
}

}  // namespace

std::vector<Cell> sphere_cells(const SphereSurface& sphere, float spacing) {
    const Ellipsoid ellipsoid(sphere);
    return append_all(ellipsoid.bands(spacing), [&](const Band& band, std::vector<Cell>& cells) {
        ellipsoid.append(band, cells);
    });
}

std::vector<Cell> plane_cells(const PlaneSurface& plane, float spacing) {
    const Frame frame = make_frame(plane.normal);
    const auto append = [&](const Ring& ring, std::vector<Cell>& cells) {
        const auto [r0, r1, count] = ring;
        const double angle = 2 * std::numbers::pi / count;
        // Distance of a ring sector's centroid from the centre.
        const double r = 2.0 / 3 * (r1 * r1 * r1 - r0 * r0 * r0) / (r1 * r1 - r0 * r0) *
                         std::sin(angle / 2) / (angle / 2);
        for (int k = 0; k < count; ++k) {
            const double phi = (k + 0.5) * angle;
            const Vec3 offset =
                float(r * std::cos(phi)) * frame.s + float(r * std::sin(phi)) * frame.t;
            cells.push_back({plane.point + offset, plane.normal, float(ring.area() / count)});
        }
    };
    return append_all(disc_rings(plane.radius, spacing), append);
}

double count_sphere_cells(const SphereSurface& sphere, float spacing) {
    return count_cells(Ellipsoid(sphere).bands(spacing));
}

double count_plane_cells(const PlaneSurface& plane, float spacing) {
    return count_cells(disc_rings(plane.radius, spacing));
}

}  // namespace tallow
