// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/support/mesh_soups.h"

namespace tallow {
namespace {

TEST(MeshNormals, SmoothNormalsWithoutAFileAreAngleWeighted) {
    const RepairedMesh result = repair(unit_cube(), Normals::smooth);
    ASSERT_EQ(result.mesh.corner_normals.size(), 36u);
    for (std::size_t i = 0; i < 36; ++i) {
        // Three right angles meet in each corner, however its faces are cut.
        const Vec3 p = result.mesh.vertices[result.mesh.triangles[i / 3][i % 3]];
        const Vec3 expected = glm::normalize(p - Vec3(0.5f));
        EXPECT_LT(glm::distance(result.mesh.corner_normals[i], expected), 1e-6f);
    }
}

/// The cube with a vertex and a normal for each corner of each face: creases at all edges.
PolygonSoup creased_cube() {
    PolygonSoup soup = exploded(unit_cube());
    for (const Vec3 n : {Vec3(0, 0, -1), Vec3(0, 0, 1), Vec3(0, -1, 0), Vec3(0, 1, 0),
                         Vec3(-1, 0, 0), Vec3(1, 0, 0)})
        for (int corner = 0; corner < 4; ++corner) soup.normals.push_back(7.0f * n);
    return soup;
}

void expect_corner_normals_are_flat(const TriangleMesh& mesh) {
    ASSERT_EQ(mesh.corner_normals.size(), 3 * mesh.triangles.size());
    for (std::size_t i = 0; i < mesh.corner_normals.size(); ++i)
        EXPECT_EQ(mesh.corner_normals[i], triangle_normal(mesh, i / 3));
}

TEST(MeshNormals, KeepsSplitNormalsOfTheFile) {
    const RepairedMesh result = repair(creased_cube());
    expect_body(result, 1);
    expect_corner_normals_are_flat(result.mesh);
    EXPECT_TRUE(repair(creased_cube(), Normals::flat).mesh.corner_normals.empty());
}

TEST(MeshNormals, NormalsTurnWithTheirComponent) {
    PolygonSoup soup = inside_out(creased_cube());
    expect_corner_normals_are_flat(repair(soup).mesh);  // the normals were right, the faces wrong
    for (Vec3& n : soup.normals) n = -n;
    expect_corner_normals_are_flat(repair(soup).mesh);  // both were wrong
}

TEST(MeshNormals, ReplacesNormalsThatFaceAwayOrAreMissing) {
    PolygonSoup soup = sphere(1, 2);
    soup.normals = soup.vertices;
    soup.normals[3] = -soup.normals[3];
    soup.normals[4] = Vec3(0);
    const TriangleMesh mesh = repair(soup).mesh;
    for (std::size_t i = 0; i < mesh.corner_normals.size(); ++i) {
        EXPECT_NEAR(glm::length(mesh.corner_normals[i]), 1, 1e-6f);
        const Vec3 p = mesh.vertices[mesh.triangles[i / 3][i % 3]];
        EXPECT_LT(glm::distance(mesh.corner_normals[i], p), 1e-6f);  // by symmetry also the means
    }
}

}  // namespace
}  // namespace tallow
