// SPDX-License-Identifier: Apache-2.0
// A body's surface, a point inside, a light -> all refracted paths between them. Each kind of
// surface finds patches that obey Snell's law; what follows from a patch is common to all.
#include "render/refracted_connection.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "common/base/overloaded.h"
#include "common/cloud/morton.h"
#include "render/patch_gate.h"
#include "render/plane_of_incidence.h"
#include "render/refracting_face.h"

namespace tallow {
namespace {

// Queries that are searched together: at most so many, and not farther from the first than this
// part of its reach. Chosen by time on the standard cases.
constexpr std::size_t kGroup = BeamQueries::kMost;
constexpr float kSpan = 0.5f;

/// A solution and the geometric normal of the surface there.
struct Solution {
    Patch patch;
    DVec3 n_g;
};

void append(const std::vector<Patch>& patches, std::vector<Solution>& solutions) {
    for (const Patch& patch : patches) solutions.push_back({patch, patch.n});
}

/// A flat or curved patch of a plane or sphere; `curvature` is 1 / radius, in 1/mm.
Patch round_patch(DVec3 p, DVec3 n, double curvature) {
    const Frame frame = make_frame(Vec3(n));
    const DVec3 s = glm::normalize(DVec3(frame.s) - glm::dot(DVec3(frame.s), n) * n);
    const DVec3 t = glm::cross(n, s);
    return {p, n, {s, t}, {curvature * s, curvature * t}};
}

std::vector<Solution> find_on_plane(const PlaneSurface& plane, const Ends& ends) {
    const DVec3 n(glm::normalize(DVec3(plane.normal)));
    const auto p = refract_through_plane(ends, plane.point, n);
    if (!p || glm::length(*p - DVec3(plane.point)) > double(plane.radius)) return {};
    return {{round_patch(*p, n, 0), n}};
}

// Radius of the image of the unit sphere if that is a sphere.
std::optional<double> sphere_radius(const Affine& to_world) {
    const glm::dmat3 m(to_world.linear);
    const glm::dmat3 gram = glm::transpose(m) * m;
    const double r2 = (gram[0][0] + gram[1][1] + gram[2][2]) / 3;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (std::abs(gram[i][j] - (i == j ? r2 : 0)) > 1e-6 * r2) return std::nullopt;
    return std::sqrt(r2);
}

std::vector<Solution> find_on_ellipsoid(const SphereSurface& surface, const Ends& ends) {
    std::vector<Solution> solutions;
    if (const auto radius = sphere_radius(surface.to_world)) {
        const DVec3 center(surface.to_world.translation);
        for (DVec3 p : refract_through_sphere(ends, center, *radius)) {
            const DVec3 n = glm::normalize(p - center);
            solutions.push_back({round_patch(p, n, 1 / *radius), n});
        }
        return solutions;
    }
    const RefractionCull cull(ends);
    std::vector<Patch> patches;
    for (int octant = 0; octant < 8; ++octant)
        find_on_face(EllipsoidOctant(surface.to_world, octant), ends, cull, patches);
    append(patches, solutions);
    return solutions;
}

// Whether p, in the plane of the triangle, lies within it. Points just outside are accepted, so
// that none is lost on an edge; those found twice are recognised.
bool in_triangle(const Patch& patch, DVec3 origin) {
    constexpr double kEdge = 1e-7;
    const DVec3 n = glm::cross(patch.dp[0], patch.dp[1]);
    const DVec3 d = patch.p - origin;
    const double n2 = glm::dot(n, n);
    const double u = glm::dot(glm::cross(d, patch.dp[1]), n) / n2;
    const double v = glm::dot(glm::cross(patch.dp[0], d), n) / n2;
    return u >= -kEdge && v >= -kEdge && u + v <= 1 + kEdge;
}

void find_on_flat_triangle(const TriangleMesh& mesh, std::size_t t, const Ends& ends,
                           std::vector<Patch>& found) {
    const auto& [a, b, c] = mesh.triangles[t];
    const DVec3 origin(mesh.vertices[a]);
    Patch patch{origin,
                {},
                {DVec3(mesh.vertices[b]) - origin, DVec3(mesh.vertices[c]) - origin},
                {DVec3(0), DVec3(0)}};
    patch.n = glm::normalize(glm::cross(patch.dp[0], patch.dp[1]));
    const auto p = refract_through_plane(ends, origin, patch.n);
    if (!p) return;
    patch.p = *p;
    if (in_triangle(patch, origin)) add_once(ends, patch, found);
}

Ends ends_of(const ConnectionQuery& query, float eta) {
    const DVec3 position(query.y.position);
    return {DVec3(query.x), query.y.at_infinity ? glm::normalize(position) : position,
            query.y.at_infinity, double(eta)};
}

/// What one query finds of the triangles that it is called with.
class MeshSearch {
public:
    MeshSearch(const TriangleMesh& mesh, const Ends& ends, float reach)
        : mesh_(mesh), ends_(ends), reach_(reach), cull_(ends, reach) {}

    const RefractionCull& cull() const { return cull_; }
    const Ends& ends() const { return ends_; }

    void try_flat(std::uint32_t triangle) {
        find_on_flat_triangle(mesh_, triangle, ends_, patches_);
    }
    void try_smooth(std::uint32_t triangle, const PatchBound& bound) {
        find_on_face(SmoothTriangle(mesh_, triangle), bound, ends_, cull_, patches_);
    }

    std::vector<Solution> solutions() const {
        std::vector<Solution> solutions;
        for (const Patch& patch : patches_) {
            const DVec3 n_g = glm::normalize(glm::cross(patch.dp[0], patch.dp[1]));
            if (on_both_sides(ends_, patch, n_g) &&
                glm::length(patch.p - ends_.x) <= double(reach_))
                solutions.push_back({patch, n_g});
        }
        return solutions;
    }

private:
    const TriangleMesh& mesh_;
    Ends ends_;
    float reach_;
    RefractionCull cull_;
    std::vector<Patch> patches_;
};

/// A ball around points, from their box.
struct Ball {
    Vec3 center;
    float radius;
    explicit Ball(const Box& box)
        : center(0.5f * (box.low + box.high)),
          radius(0.5f * glm::length(box.high - box.low) * (1 + 1e-5f)) {}
};

constexpr int kPlaceBits = 16, kPartShift = 3 * kPlaceBits;

// Which of 8 x 8 parts of the sphere a direction belongs to, by the octahedral map.
std::uint64_t part_of_sphere(Vec3 w) {
    w /= std::abs(w.x) + std::abs(w.y) + std::abs(w.z);
    Vec2 p(w.x, w.y);
    if (w.z < 0) p = {std::copysign(1 - std::abs(w.y), w.x), std::copysign(1 - std::abs(w.x), w.y)};
    const auto cell = [](float v) { return std::uint64_t(std::clamp(int(4 * (v + 1)), 0, 7)); };
    return cell(p.x) << 3 | cell(p.y);
}

/// Queries in an order in which neighbours are near one another and lit from about the same
/// direction.
std::vector<std::uint32_t> order_of(std::span<const ConnectionQuery> queries,
                                    std::vector<std::uint64_t>& keys) {
    std::vector<Vec3> places;
    for (const ConnectionQuery& query : queries) places.push_back(query.x);
    keys = morton_codes(places, kPlaceBits);
    std::vector<std::uint32_t> order(queries.size());
    for (std::size_t i = 0; i < queries.size(); ++i) {
        const auto& [x, y, reach] = queries[i];
        keys[i] |= part_of_sphere(y.at_infinity ? y.position : y.position - x) << kPartShift;
        order[i] = std::uint32_t(i);
    }
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return std::pair(keys[a], a) < std::pair(keys[b], b);
    });
    return order;
}

RefractedPath make_path(const Ends& ends, const Solution& solution) {
    const DVec3 to_x = ends.x - solution.patch.p;
    const DVec3 to_y = ends.y_at_infinity ? ends.y : ends.y - solution.patch.p;
    const double inside = glm::length(to_x), outside = glm::length(to_y);
    return {Vec3(solution.patch.p),
            Vec3(solution.n_g),
            Vec3(solution.patch.n),
            Vec3(to_y / outside),
            Vec3(to_x / inside),
            float(inside),
            ends.y_at_infinity ? kInfinity : float(outside),
            float(spread(ends, solution.patch))};
}

}  // namespace

RefractedConnections::RefractedConnections(const Surface& surface, float eta)
    : surface_(surface), eta_(eta) {
    const auto* mesh = std::get_if<TriangleMesh>(&surface);
    if (mesh == nullptr) return;
    tree_.emplace(*mesh);
    for (const std::uint32_t& triangle : tree_->order())
        if (mesh->corner_normals.empty())
            gates_.emplace_back(*mesh, triangle);
        else
            bounds_.push_back(bound_triangles(*mesh, &triangle, &triangle + 1));
}

std::vector<RefractedPath> RefractedConnections::find(Vec3 x, const LightPoint& y,
                                                      float reach) const {
    std::vector<RefractedPath> paths;
    const ConnectionQuery query{x, y, reach};
    find({&query, 1}, [&](std::size_t, const RefractedPath& path) { paths.push_back(path); });
    return paths;
}

void RefractedConnections::find(std::span<const ConnectionQuery> queries, const Use& use) const {
    if (const auto* mesh = std::get_if<TriangleMesh>(&surface_)) {
        std::vector<std::uint64_t> keys;
        const std::vector<std::uint32_t> order = order_of(queries, keys);
        for (std::size_t first = 0, last = 0; first < order.size(); first = last) {
            const ConnectionQuery& query = queries[order[first]];
            const auto belongs = [&](std::uint32_t i) {
                const auto& other = queries[i];
                return other.y.at_infinity == query.y.at_infinity &&
                       keys[i] >> kPartShift == keys[order[first]] >> kPartShift &&
                       length2(other.x - query.x) <= kSpan * kSpan * query.reach * query.reach;
            };
            while (last < order.size() && last - first < kGroup && belongs(order[last])) ++last;
            find_together(*mesh, queries, {order.data() + first, last - first}, use);
        }
        return;
    }
    for (std::size_t i = 0; i < queries.size(); ++i) {
        const Ends ends = ends_of(queries[i], eta_);
        const auto solutions = std::visit(
            Overloaded{
                [&](const SphereSurface& sphere) { return find_on_ellipsoid(sphere, ends); },
                [&](const PlaneSurface& plane) { return find_on_plane(plane, ends); },
                [](const auto&) { return std::vector<Solution>{}; },
            },
            surface_);
        for (const Solution& solution : solutions) use(i, make_path(ends, solution));
    }
}

void RefractedConnections::find_together(const TriangleMesh& mesh,
                                         std::span<const ConnectionQuery> queries,
                                         std::span<const std::uint32_t> group,
                                         const Use& use) const {
    std::vector<MeshSearch> searches;
    Box places, lights;
    float farthest = 0;
    searches.reserve(group.size());
    BeamQueries beams(double{eta_});
    for (std::uint32_t i : group) {
        const Ends ends = ends_of(queries[i], eta_);
        beams.set(searches.size(), ends, queries[i].reach);
        searches.emplace_back(mesh, ends, queries[i].reach);
        places.add(queries[i].x), lights.add(Vec3(ends.y));
        farthest = std::max(farthest, queries[i].reach);
    }
    const auto visit = [&](const RefractionCull& cull) {
        tree_->visit(cull, [&](std::size_t place) {
            const std::uint32_t triangle = tree_->order()[place];
            const bool smooth = gates_.empty();
            std::uint32_t left =
                smooth ? may_refract(bounds_[place], beams) : gates_[place].may_hold(beams);
            for (; left != 0; left &= left - 1) {
                MeshSearch& search = searches[std::size_t(std::countr_zero(left))];
                if (smooth)
                    search.try_smooth(triangle, bounds_[place]);
                else
                    search.try_flat(triangle);
            }
        });
    };
    if (group.size() == 1) {
        visit(searches.front().cull());
    } else {
        const Ball x(places), y(lights);
        visit(RefractionCull(
            {DVec3(x.center), DVec3(y.center), queries[group[0]].y.at_infinity, double(eta_)},
            x.radius, y.radius, farthest));
    }
    for (std::size_t k = 0; k < searches.size(); ++k)
        for (const Solution& solution : searches[k].solutions())
            use(group[k], make_path(searches[k].ends(), solution));
}

}  // namespace tallow
