// SPDX-License-Identifier: Apache-2.0
// Embree over the triangles of one body: crossings, distances, visibility.
#include "experiments/reference/mesh_body.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/base/check.h"
#include "common/base/parallel.h"

namespace tallow::reference {
namespace {

/// Squared distance from p to a triangle.
/// Source   Ericson, "Real-Time Collision Detection", 2005, section 5.1.5: the regions of the
/// plane.
float squared_distance(Vec3 p, Vec3 a, Vec3 b, Vec3 c) {
    const Vec3 ab = b - a, ac = c - a, ap = p - a;
    const float d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return length2(ap);
    const Vec3 bp = p - b;
    const float d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return length2(bp);
    const float vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return length2(ap - d1 / (d1 - d3) * ab);
    const Vec3 cp = p - c;
    const float d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return length2(cp);
    const float vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return length2(ap - d2 / (d2 - d6) * ac);
    const float va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
        return length2(bp - (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b));
    const float whole = 1 / (va + vb + vc);
    return length2(ap - vb * whole * ab - vc * whole * ac);
}

RTCRayHit make_query(Vec3 origin, Vec3 direction, float near, float far) {
    RTCRayHit query{};
    query.ray.org_x = origin.x, query.ray.org_y = origin.y, query.ray.org_z = origin.z;
    query.ray.dir_x = direction.x, query.ray.dir_y = direction.y, query.ray.dir_z = direction.z;
    query.ray.tnear = near, query.ray.tfar = far, query.ray.mask = ~0u;
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    return query;
}

}  // namespace

struct MeshBody::Rays {
    TriangleMesh mesh;
    std::vector<Vec3> normals;  // [triangle]
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
    /// By which a ray goes on at least after a triangle that it ignores, mm: Embree meets a
    /// triangle at 0 again if the ray starts at a number too small for it.
    float least_step = 0;

    explicit Rays(const TriangleMesh& of) : mesh(of) {
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            normals.push_back(triangle_normal(mesh, t));
        const Box box = bounding_box(Surface(mesh));
        least_step = 1e-9f * glm::length(box.high - box.low);
        const ThreadLimit one_thread(1);  // the tree must not depend on the number of cores
        device = rtcNewDevice(nullptr);
        TALLOW_CHECK(device != nullptr, "Embree error {}", int(rtcGetDeviceError(nullptr)));
        scene = rtcNewScene(device);
        rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
        rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        void* vertices =
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                    sizeof(Vec3), mesh.vertices.size());
        TALLOW_CHECK(vertices != nullptr, "Embree error {}", int(rtcGetDeviceError(device)));
        std::memcpy(vertices, mesh.vertices.data(), mesh.vertices.size() * sizeof(Vec3));
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                   mesh.triangles.data(), 0, sizeof(Triangle),
                                   mesh.triangles.size());
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene);
    }

    ~Rays() {
        rtcReleaseScene(scene);
        rtcReleaseDevice(device);
    }

    Rays(const Rays&) = delete;
    Rays& operator=(const Rays&) = delete;

    Vec3 corner(std::uint32_t facet, std::size_t i) const {
        return mesh.vertices[mesh.triangles[facet][i]];
    }

    /// Nearest crossing of a triangle whose normal has the direction's side `sign`.
    std::optional<Crossing> cross(Vec3 origin, Vec3 direction, float length, float sign) const {
        float near = 0;
        for (;;) {
            RTCRayHit query = make_query(origin, direction, near, length);
            RTCIntersectContext context;
            rtcInitIntersectContext(&context);
            rtcIntersect1(scene, &context, &query);
            if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
            const std::uint32_t facet = query.hit.primID;
            if (sign * glm::dot(direction, normals[facet]) > 0) {
                const float u = query.hit.u, v = query.hit.v;
                const Vec3 p =
                    (1 - u - v) * corner(facet, 0) + u * corner(facet, 1) + v * corner(facet, 2);
                return Crossing{query.ray.tfar, p, normals[facet], facet};
            }
            near = std::max(std::nextafter(query.ray.tfar, kInfinity), least_step);
        }
    }

    /// The triangle that a ray meets first, whichever way it faces; -1 for none.
    std::int64_t first_facet(Vec3 origin, Vec3 direction, float length) const {
        RTCRayHit query = make_query(origin, direction, 0, length);
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcIntersect1(scene, &context, &query);
        if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return -1;
        return query.hit.primID;
    }

    struct Nearest {
        const Rays* rays;
        float squared;
    };
    static bool closer(RTCPointQueryFunctionArguments* args) {
        auto& nearest = *static_cast<Nearest*>(args->userPtr);
        const Rays& rays = *nearest.rays;
        const Vec3 p(args->query->x, args->query->y, args->query->z);
        const float d2 =
            squared_distance(p, rays.corner(args->primID, 0), rays.corner(args->primID, 1),
                             rays.corner(args->primID, 2));
        if (d2 >= nearest.squared) return false;
        nearest.squared = d2;
        args->query->radius = std::sqrt(d2);
        return true;
    }

    float distance(Vec3 x) const {
        RTCPointQuery query{x.x, x.y, x.z, 0, kInfinity};
        RTCPointQueryContext context;
        rtcInitPointQueryContext(&context);
        Nearest nearest{this, kInfinity};
        rtcPointQuery(scene, &query, &context, closer, &nearest);
        return std::sqrt(nearest.squared);
    }

    bool is_inside(Vec3 x) const {
        const Vec3 direction = glm::normalize(Vec3(0.37f, 0.81f, 0.45f));  // along no symmetry
        const std::int64_t facet = first_facet(x, direction, kInfinity);
        return facet >= 0 && glm::dot(direction, normals[std::size_t(facet)]) > 0;
    }
};

MeshBody::MeshBody(const TriangleMesh& mesh, double eta, DVec3 camera, double reach,
                   double cell_count)
    : rays_(std::make_unique<Rays>(mesh)), camera_(camera) {
    const Cells cells(bounding_box(Surface(mesh)), cell_count);
    grid_ = std::make_unique<DistanceGrid>(cells, [this](Vec3 x) { return signed_distance(x); });
    beams_ = std::make_unique<CameraBeams>(
        mesh, eta, camera, cells, reach, [this](std::uint32_t facet, Vec3 p, Vec3 w) {
            if (!is_seen(facet, DVec3(p))) return 0.0f;
            const std::optional<Crossing> out = leave(p, w, kInfinity);
            return out ? out->t : 0.0f;
        });
}

MeshBody::~MeshBody() = default;
MeshBody::MeshBody(MeshBody&&) noexcept = default;
MeshBody& MeshBody::operator=(MeshBody&&) noexcept = default;

bool MeshBody::holds(Vec3 x) const { return rays_->is_inside(x); }

std::optional<Crossing> MeshBody::enter(Vec3 origin, Vec3 direction, float length) const {
    return rays_->cross(origin, direction, length, -1);
}

std::optional<Crossing> MeshBody::leave(Vec3 origin, Vec3 direction, float length) const {
    return rays_->cross(origin, direction, length, 1);
}

bool MeshBody::is_clear(Vec3 x, const CameraLink& link) const {
    // The first triangle on the way must be the link's own, seen from either side: no segment needs
    // to be shortened.
    constexpr double kBeyond = 1.001;
    if (rays_->first_facet(x, Vec3(link.w), float(kBeyond * link.inside)) != link.facet)
        return false;
    return is_seen(link.facet, link.position);
}

bool MeshBody::is_seen(std::uint32_t facet, DVec3 p) const {
    const Vec3 from_camera(glm::normalize(p - camera_));
    return rays_->first_facet(Vec3(camera_), from_camera, kInfinity) == facet;
}

float MeshBody::signed_distance(Vec3 x) const {
    const float distance = rays_->distance(x);
    return rays_->is_inside(x) ? distance : -distance;
}

}  // namespace tallow::reference
