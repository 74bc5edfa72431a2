// SPDX-License-Identifier: Apache-2.0
// A body's surface, a point inside, a light -> all refracted paths between them. Each kind of
// surface finds patches that obey Snell's law; what follows from a patch is common to all.
#include "render/refracted_connection.h"

#include "common/base/overloaded.h"
#include "render/plane_of_incidence.h"
#include "render/refracting_face.h"

namespace tallow {
namespace {

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

/// Tries the triangles that it is called with.
class MeshSearch {
public:
    MeshSearch(const TriangleMesh& mesh, const RefractionTree& tree,
               const std::vector<BeamGate>& gates, const Ends& ends, float reach)
        : mesh_(mesh),
          tree_(tree),
          gates_(gates),
          ends_(ends),
          cull_(ends, reach),
          query_(beam_query(ends, reach)) {}

    const RefractionCull& cull() const { return cull_; }

    void operator()(std::size_t place) {
        if (gates_.empty())
            find_on_face(SmoothTriangle(mesh_, tree_.order()[place]), ends_, cull_, patches_);
        else if (gates_[place].may_hold(query_))
            find_on_flat_triangle(mesh_, tree_.order()[place], ends_, patches_);
    }

    std::vector<Solution> solutions() const {
        std::vector<Solution> solutions;
        for (const Patch& patch : patches_) {
            const DVec3 n_g = glm::normalize(glm::cross(patch.dp[0], patch.dp[1]));
            if (on_both_sides(ends_, patch, n_g)) solutions.push_back({patch, n_g});
        }
        return solutions;
    }

private:
    const TriangleMesh& mesh_;
    const RefractionTree& tree_;
    const std::vector<BeamGate>& gates_;  // [place in the tree's order], of a flat mesh
    const Ends& ends_;
    RefractionCull cull_;
    BeamQuery query_;
    std::vector<Patch> patches_;
};

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
    if (mesh->corner_normals.empty())
        for (std::uint32_t triangle : tree_->order()) gates_.emplace_back(*mesh, triangle);
}

std::vector<RefractedPath> RefractedConnections::find(Vec3 x, const LightPoint& y,
                                                      float reach) const {
    const DVec3 position(y.position);
    const Ends ends{DVec3(x), y.at_infinity ? glm::normalize(position) : position, y.at_infinity,
                    double(eta_)};
    const auto solutions =
        std::visit(Overloaded{
                       [&](const TriangleMesh& mesh) {
                           MeshSearch search(mesh, *tree_, gates_, ends, reach);
                           tree_->visit(search.cull(), search);
                           return search.solutions();
                       },
                       [&](const SphereSurface& sphere) { return find_on_ellipsoid(sphere, ends); },
                       [&](const PlaneSurface& plane) { return find_on_plane(plane, ends); },
                       [](const DiscSurface&) { return std::vector<Solution>{}; },
                   },
                   surface_);
    std::vector<RefractedPath> paths;
    for (const Solution& solution : solutions)
        if (!tree_ || glm::length(solution.patch.p - ends.x) <= double(reach))
            paths.push_back(make_path(ends, solution));
    return paths;
}

}  // namespace tallow
