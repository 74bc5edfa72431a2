// SPDX-License-Identifier: Apache-2.0
//
// In: a signed distance function. Out: a triangle mesh of its zero level, and a report on it.
// A grid of the crossings seeds a Delaunay triangulation, CGAL's surface mesher refines it until
// every facet meets the criteria, and a few rounds of relaxation on the surface round the angles.

#include "surface_mesh.h"

#include <CGAL/Complex_2_in_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/IO/facets_in_complex_2_to_triangle_mesh.h>
#include <CGAL/Implicit_surface_3.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Random.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_default_triangulation_3.h>
#include <CGAL/make_surface_mesh.h>

#include <cstdio>
#include <stdexcept>

namespace tallow::sculpt {

namespace {

namespace pmp = CGAL::Polygon_mesh_processing;

using Triangulation = CGAL::Surface_mesh_default_triangulation_3;
using Complex = CGAL::Complex_2_in_triangulation_3<Triangulation>;
using Traits = Triangulation::Geom_traits;
using Point = Traits::Point_3;
using Surface = CGAL::Implicit_surface_3<Traits, std::function<double(Point)>>;
using Mesh = CGAL::Surface_mesh<CGAL::Exact_predicates_inexact_constructions_kernel::Point_3>;

Vec gradient(const Distance& f, Vec p) {
    constexpr double e = 1e-4;
    return (0.5 / e) * Vec{f({p.x + e, p.y, p.z}) - f({p.x - e, p.y, p.z}),
                           f({p.x, p.y + e, p.z}) - f({p.x, p.y - e, p.z}),
                           f({p.x, p.y, p.z + e}) - f({p.x, p.y, p.z - e})};
}

/// The zero level near p, by Newton steps along the gradient of at most `max_step` each.
Vec onto_surface(const Distance& f, Vec p, double max_step) {
    for (int i = 0; i < 30; ++i) {
        const double d = f(p);
        if (std::abs(d) < 1e-7) break;
        const Vec g = gradient(f, p);
        const double step = std::clamp(d / dot(g, g), -max_step, max_step);
        p = p - step * g;
    }
    return p;
}

/// Points where the edges of a grid cross the surface.
std::vector<Point> seed_points(const Distance& f, const MeshCriteria& c) {
    const double h = c.seed_grid_mm;
    const int n = static_cast<int>(std::ceil(2 * c.radius_mm / h));
    const Vec low = c.center - Vec{c.radius_mm, c.radius_mm, c.radius_mm};
    const auto corner = [&](int i, int j, int k) { return low + Vec{i * h, j * h, k * h}; };
    const auto index = [&](int i, int j, int k) {
        return (std::size_t(k) * (n + 1) + j) * (n + 1) + i;
    };
    std::vector<double> value(index(n, n, n) + 1);
    for (int k = 0; k <= n; ++k)
        for (int j = 0; j <= n; ++j)
            for (int i = 0; i <= n; ++i) value[index(i, j, k)] = f(corner(i, j, k));

    std::vector<Point> seeds;
    const auto cross = [&](Vec a, double fa, Vec b, double fb) {
        if ((fa < 0) == (fb < 0)) return;
        for (int i = 0; i < 40; ++i) {
            const Vec m = 0.5 * (a + b);
            ((f(m) < 0) == (fa < 0) ? a : b) = m;
        }
        seeds.emplace_back(a.x, a.y, a.z);
    };
    for (int k = 0; k < n; ++k)
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i) {
                const double v = value[index(i, j, k)];
                cross(corner(i, j, k), v, corner(i + 1, j, k), value[index(i + 1, j, k)]);
                cross(corner(i, j, k), v, corner(i, j + 1, k), value[index(i, j + 1, k)]);
                cross(corner(i, j, k), v, corner(i, j, k + 1), value[index(i, j, k + 1)]);
            }
    return seeds;
}

/// Inserts those seeds that keep a distance of `spacing` from all inserted before them.
void insert_seeds(Triangulation& triangulation, const std::vector<Point>& seeds, double spacing) {
    for (const Point& p : seeds) {
        if (triangulation.dimension() == 3) {
            const auto near = triangulation.nearest_vertex(p);
            if (CGAL::squared_distance(near->point(), p) < spacing * spacing) continue;
        }
        triangulation.insert(p);
    }
}

/// Moves every vertex towards the area-weighted centre of the triangles around it, then back onto
/// the surface. Where the surface bends within one edge length, moves are small by themselves.
void relax(const Distance& f, TriangleSoup& soup, double max_step) {
    std::vector<Vec> sum(soup.vertices.size());
    std::vector<double> weight(soup.vertices.size(), 0);
    for (const auto& t : soup.triangles) {
        const Vec a = soup.vertices[t[0]], b = soup.vertices[t[1]], c = soup.vertices[t[2]];
        const double area = length(cross(b - a, c - a));
        for (const int v : t) {
            sum[v] = sum[v] + (area / 3) * (a + b + c);
            weight[v] += area;
        }
    }
    for (std::size_t v = 0; v < soup.vertices.size(); ++v) {
        const Vec p = soup.vertices[v];
        const Vec n = normalized(gradient(f, p));
        const Vec move = (1 / weight[v]) * sum[v] - p;
        soup.vertices[v] = onto_surface(f, p + 0.5 * (move - dot(move, n) * n), max_step);
    }
}

Mesh to_mesh(const TriangleSoup& soup) {
    Mesh mesh;
    for (const Vec p : soup.vertices) mesh.add_vertex({p.x, p.y, p.z});
    for (const auto& t : soup.triangles) {
        const auto face = mesh.add_face(Mesh::Vertex_index(t[0]), Mesh::Vertex_index(t[1]),
                                        Mesh::Vertex_index(t[2]));
        if (face == Mesh::null_face()) throw std::runtime_error("the surface is not manifold");
    }
    return mesh;
}

/// Smallest angle of the triangle a b c, in degrees.
double smallest_angle_deg(Vec a, Vec b, Vec c) {
    const auto at = [](Vec p, Vec q, Vec r) {
        return std::atan2(length(cross(q - p, r - p)), dot(q - p, r - p));
    };
    return std::min({at(a, b, c), at(b, c, a), at(c, a, b)}) * 180 / CGAL_PI;
}

}  // namespace

TriangleSoup mesh_surface(const Distance& f, const MeshCriteria& c) {
    CGAL::get_default_random() = CGAL::Random(0);

    Triangulation triangulation;
    insert_seeds(triangulation, seed_points(f, c), 0.5 * c.seed_grid_mm);

    const auto value = [&f](const Point& p) { return f({p.x(), p.y(), p.z()}); };
    const Traits::Sphere_3 bounds({c.center.x, c.center.y, c.center.z},
                                  4 * c.radius_mm * c.radius_mm);  // CGAL wants the square; roomy
    const Surface surface(value, bounds, 1e-5);
    Complex complex(triangulation);
    const CGAL::Surface_mesh_default_criteria_3<Triangulation> criteria(
        c.min_angle_deg, c.max_size_mm, c.max_error_mm);
    CGAL::make_surface_mesh(complex, surface, criteria, CGAL::Manifold_tag(), 0);

    Mesh mesh;
    CGAL::facets_in_complex_2_to_triangle_mesh(complex, mesh);
    if (!CGAL::is_closed(mesh)) throw std::runtime_error("the surface is not closed");
    pmp::orient_to_bound_a_volume(mesh);

    TriangleSoup soup;
    for (const auto v : mesh.vertices())
        soup.vertices.push_back({mesh.point(v).x(), mesh.point(v).y(), mesh.point(v).z()});
    for (const auto face : mesh.faces()) {
        std::array<int, 3> t{};
        int i = 0;
        for (const auto v : CGAL::vertices_around_face(mesh.halfedge(face), mesh))
            t[i++] = static_cast<int>(v);
        soup.triangles.push_back(t);
    }
    for (int round = 0; round < 3; ++round) relax(f, soup, 0.1 * c.max_size_mm);
    return soup;
}

std::vector<Vec> vertex_normals(const Distance& f, const TriangleSoup& soup) {
    constexpr double min_cosine = 0.2;  // chosen; 1 vertex in 300 of the elephant is below
    constexpr int max_rounds = 100;     // the elephant needs 3
    std::vector<Vec> normals;
    for (const Vec p : soup.vertices) normals.push_back(normalized(gradient(f, p)));

    bool turned = true;
    for (int round = 0; turned && round < max_rounds; ++round) {
        turned = false;
        for (const auto& t : soup.triangles) {
            const Vec a = soup.vertices[t[0]];
            const Vec face = normalized(cross(soup.vertices[t[1]] - a, soup.vertices[t[2]] - a));
            for (const int v : t) {
                if (dot(face, normals[v]) >= min_cosine) continue;
                normals[v] = normalized(normals[v] + 0.25 * face);
                turned = true;
            }
        }
    }
    return normals;
}

MeshReport inspect(const TriangleSoup& soup) {
    const Mesh mesh = to_mesh(soup);
    MeshReport r{};
    r.vertices = mesh.number_of_vertices();
    r.triangles = mesh.number_of_faces();
    r.closed = CGAL::is_closed(mesh);
    r.outward = r.closed && pmp::is_outward_oriented(mesh);
    r.self_intersecting = pmp::does_self_intersect(mesh);
    r.volume_mm3 = pmp::volume(mesh);
    r.area_mm2 = pmp::area(mesh);

    Mesh copy = mesh;
    const auto component = copy.add_property_map<Mesh::Face_index, std::size_t>("f:c").first;
    r.components = pmp::connected_components(copy, component);
    const int euler = static_cast<int>(r.vertices) - static_cast<int>(mesh.number_of_edges()) +
                      static_cast<int>(r.triangles);
    r.genus = static_cast<int>(r.components) - euler / 2;

    r.min_angle_deg = 60;
    r.min_edge_mm = 1e300;
    for (const auto& t : soup.triangles) {
        const Vec a = soup.vertices[t[0]], b = soup.vertices[t[1]], c = soup.vertices[t[2]];
        const double angle = smallest_angle_deg(a, b, c);
        r.min_angle_deg = std::min(r.min_angle_deg, angle);
        r.mean_min_angle_deg += angle / double(r.triangles);
        if (angle < 20) r.share_below_20_deg += 1.0 / double(r.triangles);
        for (const double e : {length(a - b), length(b - c), length(c - a)}) {
            r.min_edge_mm = std::min(r.min_edge_mm, e);
            r.max_edge_mm = std::max(r.max_edge_mm, e);
        }
    }
    r.low = r.high = soup.vertices.at(0);
    for (const Vec p : soup.vertices) {
        r.low = {std::min(r.low.x, p.x), std::min(r.low.y, p.y), std::min(r.low.z, p.z)};
        r.high = {std::max(r.high.x, p.x), std::max(r.high.y, p.y), std::max(r.high.z, p.z)};
    }
    return r;
}

std::string MeshReport::text() const {
    char buffer[1024];
    const auto yes = [](bool b) { return b ? "yes" : "no"; };
    std::snprintf(buffer, sizeof buffer,
                  "vertices           %zu\n"
                  "triangles          %zu\n"
                  "components         %zu\n"
                  "genus              %d\n"
                  "closed             %s\n"
                  "outward            %s\n"
                  "self-intersecting  %s\n"
                  "volume_mm3         %.1f\n"
                  "area_mm2           %.1f\n"
                  "angle_deg          min %.2f, mean of minima %.2f, share below 20: %.6f\n"
                  "edge_mm            %.4f to %.4f\n"
                  "box_mm             (%.3f, %.3f, %.3f) to (%.3f, %.3f, %.3f)\n",
                  vertices, triangles, components, genus, yes(closed), yes(outward),
                  yes(self_intersecting), volume_mm3, area_mm2, min_angle_deg, mean_min_angle_deg,
                  share_below_20_deg, min_edge_mm, max_edge_mm, low.x, low.y, low.z, high.x, high.y,
                  high.z);
    return buffer;
}

}  // namespace tallow::sculpt
