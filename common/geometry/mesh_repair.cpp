// SPDX-License-Identifier: Apache-2.0
//
// A polygon soup in, an oriented manifold triangle mesh and a report out. The topology is CGAL's
// polygon mesh processing: clean the soup, orient polygons coherently (cutting where sheets meet
// in one edge), sew up the cuts that need not be, triangulate, remove degenerate triangles; then
// turn each closed component to face outward, or into the cavity that it bounds.
// Source: CGAL 5.5 manual, "Polygon Mesh Processing"; Gueziec et al. 2001, "Cutting and Stitching".

#include "common/geometry/mesh_repair.h"

// Its planar triangulation hangs on polygons that cross themselves (found by the fuzz test); the
// one without takes any closed chain of corners.
#define CGAL_TRIANGULATE_FACES_DO_NOT_USE_CDT2
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_degeneracies.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/stitch_borders.h>
#include <CGAL/Polygon_mesh_processing/triangulate_faces.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Surface_mesh.h>
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "common/base/errors.h"
#include "common/geometry/mesh_normals.h"

namespace tallow {

namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using HalfEdgeMesh = CGAL::Surface_mesh<Point>;
using HalfEdge = HalfEdgeMesh::Halfedge_index;
using Face = HalfEdgeMesh::Face_index;
using Polygon = std::vector<std::size_t>;

DVec3 to_vec(const Point& p) { return {p.x(), p.y(), p.z()}; }

// ---- soup ---------------------------------------------------------------------------------------

struct Soup {
    std::vector<Point> points;
    std::vector<Polygon> polygons;
};

Soup to_soup(const PolygonSoup& file) {
    Soup soup;
    soup.points.reserve(file.vertices.size());
    for (const Vec3 v : file.vertices) soup.points.emplace_back(v.x, v.y, v.z);
    soup.polygons.reserve(file.polygons.size());
    for (const auto& p : file.polygons) soup.polygons.emplace_back(p.begin(), p.end());
    return soup;
}

/// Replaces polygons that visit a point twice by the loops between the visits.
class CornerMender {
public:
    explicit CornerMender(std::size_t points) : place_(points, kAbsent) {}

    /// Appends the loops of three corners or more to `result`; returns whether any corner repeats.
    bool mend(const Polygon& polygon, std::vector<Polygon>& result) {
        bool repeats = false;
        path_.clear();
        for (const std::size_t corner : polygon) {
            if (place_[corner] != kAbsent) {
                repeats = true;
                cut(place_[corner], result);
            }
            place_[corner] = path_.size();
            path_.push_back(corner);
        }
        cut(0, result);
        return repeats;
    }

private:
    /// Takes path_[first, end) off as a loop of its own.
    void cut(std::size_t first, std::vector<Polygon>& result) {
        const auto begin = path_.begin() + static_cast<std::ptrdiff_t>(first);
        for (auto corner = begin; corner != path_.end(); ++corner) place_[*corner] = kAbsent;
        if (path_.end() - begin >= 3) result.emplace_back(begin, path_.end());
        path_.erase(begin, path_.end());
    }

    static constexpr std::size_t kAbsent = std::numeric_limits<std::size_t>::max();
    std::vector<std::size_t> place_;  // [point] where in path_
    Polygon path_;
};

void clean(Soup& soup, RepairReport& report) {
    report.unused_vertices =
        pmp::remove_isolated_points_in_polygon_soup(soup.points, soup.polygons);
    report.merged_vertices =
        pmp::merge_duplicate_points_in_polygon_soup(soup.points, soup.polygons);
    CornerMender mender(soup.points.size());
    std::vector<Polygon> mended;
    mended.reserve(soup.polygons.size());
    for (const Polygon& polygon : soup.polygons)
        report.degenerate_faces += mender.mend(polygon, mended);
    soup.polygons = std::move(mended);
    report.duplicate_faces =
        pmp::merge_duplicate_polygons_in_polygon_soup(soup.points, soup.polygons);
}

// ---- orientation of neighbours ------------------------------------------------------------------

/// Notes which polygons CGAL turns around.
struct TurnRecorder : pmp::Default_orientation_visitor {
    std::vector<bool>* turned;
    explicit TurnRecorder(std::vector<bool>& flags) : turned(&flags) {}
    void polygon_orientation_reversed(std::size_t polygon) const {
        (*turned)[polygon] = !(*turned)[polygon];
    }
};

using Component = HalfEdgeMesh::Property_map<Face, std::size_t>;

/// Numbers the connected components in the returned map.
std::pair<Component, std::size_t> label_components(HalfEdgeMesh& mesh) {
    const Component component = mesh.add_property_map<Face, std::size_t>("f:component").first;
    return {component, pmp::connected_components(mesh, component)};
}

/// Turns components most of whose polygons CGAL has turned: the file's majority decides, not its
/// first polygon. Returns how many polygons then differ from the file.
std::size_t follow_majority(HalfEdgeMesh& mesh, const std::vector<bool>& turned) {
    const auto [component, count] = label_components(mesh);
    std::vector<std::size_t> size(count, 0), reversed(count, 0);
    for (const Face f : mesh.faces()) {
        ++size[component[f]];
        reversed[component[f]] += turned[f];
    }
    std::vector<Face> wrong;
    for (const Face f : mesh.faces())
        if (2 * reversed[component[f]] > size[component[f]]) wrong.push_back(f);
    pmp::reverse_face_orientations(wrong, mesh);
    std::size_t changed = 0;
    for (std::size_t k = 0; k < count; ++k) changed += std::min(reversed[k], size[k] - reversed[k]);
    return changed;
}

HalfEdgeMesh orient(Soup& soup, RepairReport& report) {
    std::vector<bool> turned(soup.polygons.size(), false);
    const std::size_t points = soup.points.size();
    pmp::orient_polygon_soup(soup.points, soup.polygons,
                             CGAL::parameters::visitor(TurnRecorder(turned)));
    report.split_vertices = soup.points.size() - points;
    HalfEdgeMesh mesh;
    pmp::polygon_soup_to_polygon_mesh(soup.points, soup.polygons, mesh);
    report.flipped_faces = follow_majority(mesh, turned);
    return mesh;
}

// ---- sewing -------------------------------------------------------------------------------------

/// Border half-edges between the same two points, seen along the line from the smaller one.
struct Seam {
    HalfEdge border;
    bool forward;  // the face's own half-edge runs along the line
    double angle;  // of the face around the line
};

using Line = std::pair<Point, Point>;

double angle_around(const Line& line, const Point& p) {
    const DVec3 axis = glm::normalize(to_vec(line.second) - to_vec(line.first));
    const DVec3 least = glm::abs(axis.x) < 0.5 ? DVec3(1, 0, 0) : DVec3(0, 1, 0);
    const DVec3 u = glm::normalize(glm::cross(axis, least)), v = glm::cross(axis, u);
    const DVec3 d = to_vec(p) - to_vec(line.first);
    return std::atan2(glm::dot(d, v), glm::dot(d, u));
}

std::map<Line, std::vector<Seam>> find_seams(const HalfEdgeMesh& mesh) {
    std::map<Line, std::vector<Seam>> seams;
    for (const HalfEdge h : mesh.halfedges()) {
        if (!mesh.is_border(h)) continue;
        const HalfEdge inner = mesh.opposite(h);
        const Point &from = mesh.point(mesh.source(inner)), &to = mesh.point(mesh.target(inner));
        const bool forward = from < to;
        const Line line = forward ? Line(from, to) : Line(to, from);
        const Point& side = mesh.point(mesh.target(mesh.next(inner)));
        seams[line].push_back({h, forward, angle_around(line, side)});
    }
    return seams;
}

using BorderPair = std::pair<HalfEdge, HalfEdge>;

/// Pairs faces around one line across the inside of the body, so that bodies which touch stay two.
/// A face that runs backward has its inside at larger angles, one that runs forward at smaller
/// ones: they match like parentheses, twice around the circle. (Sheets that cross each other nest.)
void match(std::vector<Seam>& around, std::vector<BorderPair>& pairs) {
    std::stable_sort(around.begin(), around.end(),
                     [](const Seam& a, const Seam& b) { return a.angle < b.angle; });
    std::vector<HalfEdge> waiting;
    std::vector<bool> matched(around.size(), false);
    for (std::size_t i = 0; i < 2 * around.size(); ++i) {
        const std::size_t k = i % around.size();
        if (!around[k].forward) {
            if (i == k) waiting.push_back(around[k].border);
        } else if (!matched[k] && !waiting.empty()) {
            pairs.emplace_back(waiting.back(), around[k].border);
            waiting.pop_back();
            matched[k] = true;
        }
    }
}

/// Where sheets met in one edge, orient() has cut them apart, and some cuts leave a slit in a
/// surface that was closed. Sews slits up. (Borders that lie together have no other cause: points
/// have been merged before.)
void sew(HalfEdgeMesh& mesh) {
    std::vector<BorderPair> pairs;
    for (auto& [line, around] : find_seams(mesh)) match(around, pairs);
    if (!pairs.empty()) pmp::stitch_borders(mesh, pairs);
}

// ---- triangles ----------------------------------------------------------------------------------

/// Cuts a polygon that CGAL cannot (its corners lie on a line) into a fan.
void cut_into_fan(HalfEdgeMesh& mesh, Face face) {
    while (mesh.degree(face) > 3) {
        const HalfEdge first = mesh.halfedge(face);
        const HalfEdge diagonal = CGAL::Euler::split_face(first, mesh.next(mesh.next(first)), mesh);
        const Face one = mesh.face(diagonal), other = mesh.face(mesh.opposite(diagonal));
        face = mesh.degree(one) > mesh.degree(other) ? one : other;
    }
}

void triangulate(HalfEdgeMesh& mesh, RepairReport& report) {
    std::vector<Face> polygons;
    for (const Face f : mesh.faces())
        if (mesh.degree(f) > 3) polygons.push_back(f);
    report.triangulated_polygons = polygons.size();
    if (polygons.empty() || pmp::triangulate_faces(polygons, mesh)) return;
    for (const Face f : polygons)
        if (!mesh.is_removed(f)) cut_into_fan(mesh, f);
}

/// Whether triangle_area() will be positive: the same corner first, for rounding depends on it.
bool has_area(const HalfEdgeMesh& mesh, Face face) {
    const HalfEdge h = mesh.halfedge(face), next = mesh.next(h);
    const DVec3 a = to_vec(mesh.point(mesh.target(h))), b = to_vec(mesh.point(mesh.target(next)));
    const DVec3 c = to_vec(mesh.point(mesh.source(h)));
    return glm::length(glm::cross(b - a, c - a)) > 0;
}

/// Removes triangles of zero area by collapsing and flipping edges around them, so that no hole
/// opens. What survives that (area lost to rounding) is dropped.
void remove_degenerate_triangles(HalfEdgeMesh& mesh, RepairReport& report) {
    const auto flat = [&mesh] {
        std::vector<Face> faces;
        for (const Face f : mesh.faces())
            if (!has_area(mesh, f)) faces.push_back(f);
        return faces;
    };
    const std::vector<Face> degenerate = flat();
    if (degenerate.empty()) return;
    report.degenerate_faces += degenerate.size();
    pmp::remove_degenerate_faces(mesh);
    for (const Face f : flat()) CGAL::Euler::remove_face(mesh.halfedge(f), mesh);
}

// ---- outside and inside -------------------------------------------------------------------------

/// A connected component of the result.
struct Shell {
    std::vector<std::size_t> triangles;
    bool closed = true;
    double volume = 0;  // signed: negative if the triangles face inward
    DVec3 low{std::numeric_limits<double>::infinity()}, high{-low};
};

struct Result {
    TriangleMesh mesh;
    TriangleOrigin origin;
    std::vector<Shell> shells;
};

/// Copies the mesh into plain arrays, its vertices in the order of their first use.
Result to_triangles(HalfEdgeMesh& mesh) {
    const auto [component, count] = label_components(mesh);
    Result result;
    result.shells.resize(count);
    result.origin.turned.resize(count, false);
    constexpr auto kNew = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> number(mesh.num_vertices() + mesh.number_of_removed_vertices(),
                                      kNew);
    for (const Face f : mesh.faces()) {
        Shell& shell = result.shells[component[f]];
        Triangle triangle;
        std::size_t corner = 0;
        for (const HalfEdge h : mesh.halfedges_around_face(mesh.halfedge(f))) {
            std::uint32_t& vertex = number[mesh.target(h)];
            if (vertex == kNew) {
                vertex = static_cast<std::uint32_t>(result.mesh.vertices.size());
                result.mesh.vertices.emplace_back(to_vec(mesh.point(mesh.target(h))));
            }
            triangle[corner++] = vertex;
            shell.closed = shell.closed && !mesh.is_border(mesh.opposite(h));
        }
        shell.triangles.push_back(result.mesh.triangles.size());
        result.mesh.triangles.push_back(triangle);
        result.origin.component.push_back(static_cast<std::uint32_t>(component[f]));
    }
    return result;
}

void measure(const TriangleMesh& mesh, Shell& shell) {
    const DVec3 origin = mesh.vertices[mesh.triangles[shell.triangles[0]][0]];
    for (const std::size_t t : shell.triangles) {
        DVec3 p[3];
        for (std::size_t c = 0; c < 3; ++c) {
            p[c] = mesh.vertices[mesh.triangles[t][c]];
            shell.low = glm::min(shell.low, p[c]);
            shell.high = glm::max(shell.high, p[c]);
        }
        shell.volume += glm::dot(p[0] - origin, glm::cross(p[1] - origin, p[2] - origin)) / 6;
    }
}

HalfEdgeMesh copy_shell(const TriangleMesh& mesh, const Shell& shell) {
    std::vector<Point> points;
    std::vector<Polygon> triangles;
    for (const std::size_t t : shell.triangles) {
        triangles.emplace_back();
        for (const std::uint32_t v : mesh.triangles[t]) {
            triangles.back().push_back(points.size());
            points.emplace_back(mesh.vertices[v].x, mesh.vertices[v].y, mesh.vertices[v].z);
        }
    }
    HalfEdgeMesh copy;
    pmp::polygon_soup_to_polygon_mesh(points, triangles, copy);
    return copy;
}

using Sides = CGAL::Side_of_triangle_mesh<HalfEdgeMesh, Kernel>;

/// Whether a shell lies inside another: some of its vertices strictly, none outside. Shells that
/// cross each other are no cavities, which is why CGAL's own orient_to_bound_a_volume, which asks
/// a single vertex, is not used.
bool lies_inside(const TriangleMesh& mesh, const Shell& shell, const Sides& sides) {
    constexpr std::size_t kProbes = 32;
    const std::size_t step = std::max<std::size_t>(1, shell.triangles.size() / kProbes);
    bool inside = false;
    for (std::size_t i = 0; i < shell.triangles.size(); i += step) {
        const Vec3 p = mesh.vertices[mesh.triangles[shell.triangles[i]][0]];
        const CGAL::Bounded_side side = sides(Point(p.x, p.y, p.z));
        if (side == CGAL::ON_UNBOUNDED_SIDE) return false;
        inside = inside || side == CGAL::ON_BOUNDED_SIDE;
    }
    return inside;
}

/// For each closed shell, how many others it lies inside of.
std::vector<int> nesting_depths(const TriangleMesh& mesh, const std::vector<Shell>& shells) {
    std::vector<int> depth(shells.size(), 0);
    for (std::size_t outer = 0; outer < shells.size(); ++outer) {
        const Shell& o = shells[outer];
        std::vector<std::size_t> candidates;
        for (std::size_t inner = 0; inner < shells.size(); ++inner)
            if (const Shell& i = shells[inner]; inner != outer && o.closed && i.closed &&
                                                glm::all(glm::lessThanEqual(o.low, i.low)) &&
                                                glm::all(glm::lessThanEqual(i.high, o.high)))
                candidates.push_back(inner);
        if (candidates.empty()) continue;
        const HalfEdgeMesh copy = copy_shell(mesh, o);
        const Sides sides(copy);
        for (const std::size_t inner : candidates)
            depth[inner] += lies_inside(mesh, shells[inner], sides);
    }
    return depth;
}

/// Turns closed shells so that they face away from the material.
void face_outward(Result& result, RepairReport& report) {
    for (Shell& shell : result.shells) measure(result.mesh, shell);
    const std::vector<int> depth = nesting_depths(result.mesh, result.shells);
    for (std::size_t k = 0; k < result.shells.size(); ++k) {
        const Shell& shell = result.shells[k];
        const double outward = depth[k] % 2 == 0 ? shell.volume : -shell.volume;
        if (!shell.closed || outward >= 0) continue;
        for (const std::size_t t : shell.triangles)
            std::swap(result.mesh.triangles[t][1], result.mesh.triangles[t][2]);
        result.origin.turned[k] = true;
        ++report.flipped_components;
    }
}

// ---- boundary -----------------------------------------------------------------------------------

struct Loop {
    std::size_t edges = 0;
    double length = 0;
    DVec3 through{0};
};

Loop follow(const HalfEdgeMesh& mesh, HalfEdge start, std::vector<bool>& seen) {
    Loop loop;
    loop.through = to_vec(mesh.point(mesh.source(start)));
    HalfEdge h = start;
    do {
        seen[h] = true;
        ++loop.edges;
        loop.length +=
            glm::distance(to_vec(mesh.point(mesh.source(h))), to_vec(mesh.point(mesh.target(h))));
        h = mesh.next(h);
    } while (h != start);
    return loop;
}

void describe_boundary(const HalfEdgeMesh& mesh, RepairReport& report) {
    std::vector<bool> seen(mesh.num_halfedges(), false);
    Loop longest;
    for (const HalfEdge h : mesh.halfedges()) {
        if (!mesh.is_border(h) || seen[h]) continue;
        const Loop loop = follow(mesh, h, seen);
        if (report.boundary_loops++ == 0 || loop.length > longest.length) longest = loop;
    }
    if (report.boundary_loops == 0) return;
    report.boundary = fmt::format(
        "{} of {} edges, {:.3g} long, through ({:.6g}, {:.6g}, {:.6g})",
        report.boundary_loops == 1
            ? "boundary loop"
            : fmt::format("{} boundary loops, the longest", report.boundary_loops),
        longest.edges, longest.length, longest.through.x, longest.through.y, longest.through.z);
}

/// Hostile soups lead CGAL into half-edges that never come around; nobody may follow those.
void check_sound(const HalfEdgeMesh& mesh, const std::string& name) {
    if (!CGAL::is_valid_polygon_mesh(mesh))
        throw InputError(name +
                         ": faces overlap or fold back so that no surface can be made of them");
}

}  // namespace

RepairedMesh repair_mesh(const PolygonSoup& file, Normals normals, const std::string& name) {
    RepairReport report;
    Soup soup = to_soup(file);
    clean(soup, report);
    HalfEdgeMesh half_edges = orient(soup, report);
    check_sound(half_edges, name);
    sew(half_edges);
    triangulate(half_edges, report);
    check_sound(half_edges, name);
    remove_degenerate_triangles(half_edges, report);
    check_sound(half_edges, name);
    describe_boundary(half_edges, report);

    Result result = to_triangles(half_edges);
    if (result.mesh.triangles.empty())
        throw InputError(name + ": no face of this mesh has an area");
    face_outward(result, report);
    report.components = result.shells.size();
    const bool smooth =
        normals == Normals::smooth || (normals == Normals::automatic && !file.normals.empty());
    if (smooth)
        result.mesh.corner_normals = smooth_corner_normals(result.mesh, result.origin, file);
    return {std::move(result.mesh), std::move(report)};
}

}  // namespace tallow
