// SPDX-License-Identifier: Apache-2.0
// Triangles -> beams -> cells, and the one-dimensional problem of refraction by a plane.
#include "experiments/reference/camera_beams.h"

#include <algorithm>
#include <cmath>

#include "common/base/parallel.h"

namespace tallow::reference {
namespace {

/// Direction inside of light from direction `from` (unit, towards the light): into the body.
DVec3 refracted(DVec3 from, DVec3 normal, double eta) {
    const double cos_out = glm::dot(from, normal);
    const double cos_in = std::sqrt(1 - (1 - cos_out * cos_out) / (eta * eta));
    return (cos_out / eta - cos_in) * normal - from / eta;
}

/// Distance s from x's foot, of D between the feet of x and the camera, at which the ray goes
/// through the plane; x at `depth` below, the camera at `height` above.
///
///     f(s) = eta s / sqrt(s^2 + depth^2) - (D - s) / sqrt((D - s)^2 + height^2) = 0
///
/// f grows with s, and is concave in s >= 0 but for the second term, whose curvature is smaller by
/// (depth / height)^2: Newton's method from the left, kept in [0, D] by bisection.
double refraction_offset(double eta, double depth, double height, double D) {
    constexpr int kMost = 60;
    double low = 0, high = D;
    const double sine = D / std::sqrt(D * D + height * height) / eta;
    double s = std::min(D, depth * sine / std::sqrt(1 - sine * sine));
    for (int i = 0; i < kMost; ++i) {
        const double in2 = s * s + depth * depth, out2 = (D - s) * (D - s) + height * height;
        const double in = std::sqrt(in2), out = std::sqrt(out2);
        const double f = eta * s / in - (D - s) / out;
        const double slope = eta * depth * depth / (in2 * in) + height * height / (out2 * out);
        (f < 0 ? low : high) = s;
        double next = s - f / slope;
        if (!(next >= low && next <= high)) next = (low + high) / 2;
        const double step = std::abs(next - s);
        s = next;
        if (step <= 1e-12 * (D + depth)) break;
    }
    return s;
}

struct Corners {
    DVec3 p[3];
    Corners(const TriangleMesh& mesh, std::uint32_t facet) {
        for (std::size_t i = 0; i < 3; ++i) p[i] = DVec3(mesh.vertices[mesh.triangles[facet][i]]);
    }
    DVec3 middle() const { return (p[0] + p[1] + p[2]) / 3.0; }
};

}  // namespace

bool CameraBeams::Gate::may_hold(Vec3 x, float reach) const {
    const Vec3 to_x = x - corner;
    const float depth = -glm::dot(to_x, normal);
    if (!(depth > 0) || depth > reach) return false;
    const Vec3 on_plane = to_x - depth * along;
    const float u = glm::dot(u_of, on_plane), v = glm::dot(v_of, on_plane);
    const float miss = slack + depth * slack_by_depth;
    return u > -miss && v > -miss && u + v < 1 + miss;
}

CameraBeams::CameraBeams(const TriangleMesh& mesh, double eta, DVec3 camera, const Cells& cells,
                         double reach, const Probe& probe)
    : cells_(cells), eta_(eta) {
    for (std::uint32_t facet = 0; facet < mesh.triangles.size(); ++facet)
        add(mesh, facet, camera, reach);
    parallel_for(beams_.size(), 64, [&](std::size_t i) {
        beams_[i].open = open_length(mesh, beams_[i], camera, probe);
    });
    sort_into_cells(mesh, camera, reach);
}

void CameraBeams::add(const TriangleMesh& mesh, std::uint32_t facet, DVec3 camera, double reach) {
    const Corners corners(mesh, facet);
    const DVec3 e1 = corners.p[1] - corners.p[0], e2 = corners.p[2] - corners.p[0];
    const DVec3 across = glm::cross(e1, e2);
    Beam beam{};
    beam.corner = corners.p[0];
    beam.normal = glm::normalize(across);
    beam.height = glm::dot(camera - beam.corner, beam.normal);
    if (!(beam.height > 0)) return;
    beam.foot = camera - beam.height * beam.normal;
    const double area2 = glm::dot(across, across);
    beam.u_of = glm::cross(e2, across) / area2;
    beam.v_of = glm::cross(across, e1) / area2;
    beam.facet = facet;
    beams_.push_back(beam);

    const auto inward = [&](DVec3 p) {
        const DVec3 w = refracted(glm::normalize(camera - p), beam.normal, eta_);
        return w / -glm::dot(w, beam.normal);
    };
    const DVec3 along = inward(corners.middle());
    double turn = 0;  // of `along`, over the triangle; twice the corners' for what lies between
    for (DVec3 p : corners.p) turn = std::max(turn, 2 * glm::length(inward(p) - along));
    const double steepest = std::max(glm::length(beam.u_of), glm::length(beam.v_of));
    const double rounding = 1e-5 * (glm::length(beam.corner) + reach);
    gates_.push_back({Vec3(beam.corner), Vec3(beam.normal), Vec3(along), Vec3(beam.u_of),
                      Vec3(beam.v_of), float(2 * steepest * rounding), float(2 * steepest * turn)});
}

// The least of a few points' lengths, with some distance kept.
double CameraBeams::open_length(const TriangleMesh& mesh, const Beam& beam, DVec3 camera,
                                const Probe& probe) const {
    constexpr double kOfLength = 0.9;
    constexpr double kPoints[][3] = {
        {1. / 3, 1. / 3, 1. / 3}, {0.9, 0.05, 0.05},  {0.05, 0.9, 0.05}, {0.05, 0.05, 0.9},
        {0.48, 0.48, 0.04},       {0.48, 0.04, 0.48}, {0.04, 0.48, 0.48}};
    const Corners corners(mesh, beam.facet);
    double least = double(kInfinity);
    for (const auto& b : kPoints) {
        const DVec3 p = b[0] * corners.p[0] + b[1] * corners.p[1] + b[2] * corners.p[2];
        const DVec3 w = refracted(glm::normalize(camera - p), beam.normal, eta_);
        least = std::min(least, kOfLength * double(probe(beam.facet, Vec3(p), Vec3(w))));
        if (least == 0) break;
    }
    return least;
}

// A beam is cut into slices as deep as a cell is wide; a slice takes the cells of its box.
std::vector<std::uint32_t> CameraBeams::cells_of(const TriangleMesh& mesh, const Beam& beam,
                                                 DVec3 camera, double reach) const {
    const Corners corners(mesh, beam.facet);
    DVec3 inward[3];
    for (int i = 0; i < 3; ++i)
        inward[i] = refracted(glm::normalize(camera - corners.p[i]), beam.normal, eta_);
    const double step = double(cells_.size);
    // Rays between the corners' bend away from straight interpolation by less than their
    // directions differ.
    double turn = 0;
    for (int i = 0; i < 3; ++i) turn = std::max(turn, glm::length(inward[i] - inward[(i + 1) % 3]));
    std::vector<std::uint32_t> found;
    for (double from = 0; from < reach; from += step) {
        const double to = std::min(reach, from + step);
        Box box;
        for (int i = 0; i < 3; ++i)
            for (double s : {from, to}) box.add(Vec3(corners.p[i] + s * inward[i]));
        const float margin = float(turn * turn * to + 1e-5 * (glm::length(beam.corner) + reach));
        int low[3], high[3];
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = std::max(0, cells_.along(axis, box.low[axis] - margin));
            high[axis] =
                std::min(cells_.count[axis] - 1, cells_.along(axis, box.high[axis] + margin));
        }
        for (int z = low[2]; z <= high[2]; ++z)
            for (int y = low[1]; y <= high[1]; ++y)
                for (int x = low[0]; x <= high[0]; ++x)
                    found.push_back(std::uint32_t(cells_.index(x, y, z)));
    }
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
}

void CameraBeams::sort_into_cells(const TriangleMesh& mesh, DVec3 camera, double reach) {
    std::vector<std::vector<std::uint32_t>> cells(beams_.size());
    parallel_for(beams_.size(), 64,
                 [&](std::size_t i) { cells[i] = cells_of(mesh, beams_[i], camera, reach); });
    first_.assign(cells_.total() + 1, 0);
    for (const auto& of_beam : cells)
        for (std::uint32_t cell : of_beam) ++first_[cell + 1];
    for (std::size_t cell = 0; cell < cells_.total(); ++cell) first_[cell + 1] += first_[cell];
    entries_.resize(first_.back());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t i = 0; i < beams_.size(); ++i) {
        for (std::uint32_t cell : cells[i]) entries_[next[cell]++] = i;
        cells[i] = {};
    }
}

std::optional<CameraLink> CameraBeams::link_through(const Beam& beam, Vec3 from,
                                                    float reach) const {
    const DVec3 x(from);
    const double depth = -glm::dot(x - beam.corner, beam.normal);
    if (!(depth > 0)) return std::nullopt;
    const DVec3 x_foot = x + depth * beam.normal, aside = beam.foot - x_foot;
    const double D = glm::length(aside);
    const double s = D > 0 ? refraction_offset(eta_, depth, beam.height, D) : 0;
    CameraLink link{};
    link.position = D > 0 ? x_foot + s / D * aside : x_foot;
    const DVec3 in_triangle = link.position - beam.corner;
    const double u = glm::dot(beam.u_of, in_triangle), v = glm::dot(beam.v_of, in_triangle);
    if (!(u >= 0 && v >= 0 && u + v <= 1)) return std::nullopt;
    link.inside = std::sqrt(s * s + depth * depth);
    if (link.inside > double(reach)) return std::nullopt;
    link.outside = std::sqrt((D - s) * (D - s) + beam.height * beam.height);
    link.w = (link.position - x) / link.inside;
    link.cos_in = depth / link.inside, link.cos_out = beam.height / link.outside;
    link.spread = Pencil(eta_, 0, link.outside, link.cos_in, link.cos_out)
                      .spread(link.inside, link.outside, link.cos_in, link.cos_out);
    link.facet = beam.facet;
    link.open = link.inside < beam.open;
    return link;
}

}  // namespace tallow::reference
