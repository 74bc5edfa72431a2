// SPDX-License-Identifier: Apache-2.0
//
// tallow-sculpt out.ply [scale]
//
// Meshes the seated elephant calf and writes it as binary PLY with normals taken from the implicit
// function. The report on the mesh goes to stdout. `scale` (default 1) coarsens the mesh, for quick
// looks. Exit code 1 if the mesh is not fit for use; then nothing is written.

#include "elephant.h"
#include "surface_mesh.h"

#include <bit>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace tallow::sculpt {
namespace {

static_assert(std::endian::native == std::endian::little, "write_ply copies bytes as they are");

/// Puts the lowest point on y = 0 and the middle of the box on x = z = 0, and rounds to float, so
/// that what is inspected afterwards is what will be in the file.
void place_on_ground(TriangleSoup& soup) {
    const MeshReport box = inspect(soup);
    const Vec offset{-0.5 * (box.low.x + box.high.x), -box.low.y, -0.5 * (box.low.z + box.high.z)};
    for (Vec& p : soup.vertices) {
        p = p + offset;
        p = {float(p.x), float(p.y), float(p.z)};
    }
}

/// Binary little-endian PLY: x y z nx ny nz as float, faces as uchar count and int indices.
/// Throws std::runtime_error.
void write_ply(const std::string& file, const TriangleSoup& soup, const std::vector<Vec>& normals) {
    const std::string temporary = file + ".tmp";
    std::ofstream out(temporary, std::ios::binary);
    out << "ply\nformat binary_little_endian 1.0\n"
        << "comment seated elephant calf, made by data/generate, Apache-2.0; unit: mm\n"
        << "element vertex " << soup.vertices.size() << "\n"
        << "property float x\nproperty float y\nproperty float z\n"
        << "property float nx\nproperty float ny\nproperty float nz\n"
        << "element face " << soup.triangles.size() << "\n"
        << "property list uchar int vertex_indices\nend_header\n";
    for (std::size_t v = 0; v < soup.vertices.size(); ++v) {
        const Vec n = normals[v], q = soup.vertices[v];
        const float row[] = {float(q.x), float(q.y), float(q.z),
                             float(n.x), float(n.y), float(n.z)};
        out.write(reinterpret_cast<const char*>(row), sizeof row);
    }
    for (const auto& t : soup.triangles) {
        const std::int32_t row[] = {t[0], t[1], t[2]};
        out.put(3);
        out.write(reinterpret_cast<const char*>(row), sizeof row);
    }
    out.close();
    if (!out) throw std::runtime_error(temporary + ": cannot write");
    std::filesystem::rename(temporary, file);
}

int run(const std::string& file, double scale) {
    const Elephant shape;
    const Distance distance = [&shape](Vec p) { return shape.distance(p); };
    const MeshCriteria criteria{.radius_mm = 30,
                                .center = {0, 20, 0},
                                .seed_grid_mm = 0.6,
                                .max_size_mm = 0.33 * scale,
                                .max_error_mm = 0.013 * scale,
                                .min_angle_deg = 28};
    TriangleSoup soup = mesh_surface(distance, criteria);
    const std::vector<Vec> normals = vertex_normals(distance, soup);
    place_on_ground(soup);
    const MeshReport report = inspect(soup);
    std::cout << report.text();
    if (!report.good()) throw std::runtime_error("the mesh is not fit for use, see the report");
    write_ply(file, soup, normals);
    return 0;
}

}  // namespace
}  // namespace tallow::sculpt

int main(int argc, char** argv) {
    if (argc < 2 || argc > 3) {
        std::cerr << "usage: tallow-sculpt out.ply [scale]\n";
        return 2;
    }
    try {
        return tallow::sculpt::run(argv[1], argc > 2 ? std::stod(argv[2]) : 1.0);
    } catch (const std::exception& e) {
        std::cerr << "tallow-sculpt: " << e.what() << "\n";
        return 1;
    }
}
