// SPDX-License-Identifier: Apache-2.0
// Ray queries on all surfaces of a scene. Meshes are Embree triangles; spheres and discs are Embree
// user geometries (unit_shape.h); unbounded planes, which no bounding box
// can hold, are tested beside the tree. An object's index is its Embree geometry ID.
#include "common/geometry/ray_scene.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "common/base/check.h"
#include "common/base/parallel.h"
#include "common/geometry/unit_shape.h"

namespace tallow {
namespace {

void bounds(const RTCBoundsFunctionArguments* args) {
    const Box box = bounding_box(*static_cast<const UnitShape*>(args->geometryUserPtr));
    *args->bounds_o = {box.low.x, box.low.y, box.low.z, 0, box.high.x, box.high.y, box.high.z, 0};
}

double lane_crossing(const UnitShape& shape, RTCRayN* ray, unsigned n, unsigned lane) {
    const DVec3 o(RTCRayN_org_x(ray, n, lane), RTCRayN_org_y(ray, n, lane),
                  RTCRayN_org_z(ray, n, lane));
    const DVec3 d(RTCRayN_dir_x(ray, n, lane), RTCRayN_dir_y(ray, n, lane),
                  RTCRayN_dir_z(ray, n, lane));
    return first_crossing(cross(shape, o, d), RTCRayN_tnear(ray, n, lane),
                          RTCRayN_tfar(ray, n, lane));
}

void intersect_unit_shape(const RTCIntersectFunctionNArguments* args) {
    const auto& shape = *static_cast<const UnitShape*>(args->geometryUserPtr);
    RTCRayN* ray = RTCRayHitN_RayN(args->rayhit, args->N);
    RTCHitN* hit = RTCRayHitN_HitN(args->rayhit, args->N);
    for (unsigned lane = 0; lane < args->N; ++lane) {
        if (args->valid[lane] != -1) continue;
        const double t = lane_crossing(shape, ray, args->N, lane);
        if (t < 0) continue;
        RTCRayN_tfar(ray, args->N, lane) = static_cast<float>(t);
        RTCHitN_geomID(hit, args->N, lane) = args->geomID;
        RTCHitN_primID(hit, args->N, lane) = args->primID;
        RTCHitN_instID(hit, args->N, lane, 0) = args->context->instID[0];
    }
}

void occlude_unit_shape(const RTCOccludedFunctionNArguments* args) {
    const auto& shape = *static_cast<const UnitShape*>(args->geometryUserPtr);
    for (unsigned lane = 0; lane < args->N; ++lane)
        if (args->valid[lane] == -1 && lane_crossing(shape, args->ray, args->N, lane) >= 0)
            RTCRayN_tfar(args->ray, args->N, lane) = -kInfinity;
}

// Distance to the plane along the ray, or a negative number.
double cross_plane(const PlaneSurface& plane, const Ray& ray) {
    const double cosine = glm::dot(DVec3(ray.direction), DVec3(plane.normal));
    if (cosine == 0) return -1;
    return glm::dot(DVec3(plane.point) - DVec3(ray.origin), DVec3(plane.normal)) / cosine;
}

RTCRay embree_ray(const Ray& ray, float length) {
    RTCRay r{};
    r.org_x = ray.origin.x, r.org_y = ray.origin.y, r.org_z = ray.origin.z;
    r.dir_x = ray.direction.x, r.dir_y = ray.direction.y, r.dir_z = ray.direction.z;
    r.tnear = 0, r.tfar = length, r.mask = ~0u;
    return r;
}

constexpr std::size_t kPacket = 16;

// Which of a packet's rays are there.
struct Lanes {
    explicit Lanes(std::size_t count) { std::fill_n(valid, count, -1); }
    alignas(64) int valid[kPacket] = {};
};

void fill(RTCRay16& packet, std::span<const ShadowRay> rays) {
    for (std::size_t i = 0; i < kPacket; ++i) {
        const auto& [origin, direction, length] = rays[std::min(i, rays.size() - 1)];
        packet.org_x[i] = origin.x, packet.org_y[i] = origin.y, packet.org_z[i] = origin.z;
        packet.dir_x[i] = direction.x, packet.dir_y[i] = direction.y;
        packet.dir_z[i] = direction.z;
        packet.tnear[i] = 0, packet.tfar[i] = length;
        packet.time[i] = 0, packet.mask[i] = ~0u, packet.id[i] = 0, packet.flags[i] = 0;
    }
}

RTCGeometry mesh_geometry(RTCDevice device, const TriangleMesh& mesh) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                             sizeof(Vec3), mesh.vertices.size());
    if (vertices == nullptr) throw std::bad_alloc();
    // Copied only because Embree reads 16 bytes of the last one; the indices it may share.
    std::memcpy(vertices, mesh.vertices.data(), mesh.vertices.size() * sizeof(Vec3));
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               mesh.triangles.data(), 0, sizeof(Triangle), mesh.triangles.size());
    return geometry;
}

// Above this, Embree's compact tree: with 20M triangles 40 bytes each in place of 110, at a third
// of the building time more. Chosen: below, the fast tree takes less than half a GiB.
constexpr std::size_t kManyTriangles = 4'000'000;

std::size_t count_triangles(std::span<const Surface> surfaces) {
    std::size_t count = 0;
    for (const Surface& surface : surfaces)
        if (const auto* mesh = std::get_if<TriangleMesh>(&surface)) count += mesh->triangles.size();
    return count;
}

float largest_component(Vec3 v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

// Largest coordinate of a surface; of an unbounded plane that of its point.
float largest_coordinate(const Surface& surface) {
    if (const auto* mesh = std::get_if<TriangleMesh>(&surface)) {
        float largest = 0;
        for (Vec3 v : mesh->vertices) largest = std::max(largest, largest_component(v));
        return largest;
    }
    if (const auto* plane = std::get_if<PlaneSurface>(&surface))
        return largest_component(plane->point) + (std::isinf(plane->radius) ? 0 : plane->radius);
    const Affine& to_world = std::holds_alternative<SphereSurface>(surface)
                                 ? std::get<SphereSurface>(surface).to_world
                                 : std::get<DiscSurface>(surface).to_world;
    float reach = 0;
    for (int i = 0; i < 3; ++i) reach = std::max(reach, glm::length(to_world.linear[i]));
    return largest_component(to_world.translation) + reach;
}

RTCGeometry user_geometry(RTCDevice device, UnitShape& shape) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, 1);
    rtcSetGeometryUserData(geometry, &shape);
    rtcSetGeometryBoundsFunction(geometry, bounds, nullptr);
    rtcSetGeometryIntersectFunction(geometry, intersect_unit_shape);
    rtcSetGeometryOccludedFunction(geometry, occlude_unit_shape);
    return geometry;
}

}  // namespace

struct RayScene::Impl {
    std::span<const Surface> surfaces;
    std::vector<UnitShape> unit_shapes;      // [object]; unused for meshes and planes
    std::vector<std::vector<Vec3>> normals;  // [object][triangle] unit, outward; of meshes
    std::vector<std::uint32_t> planes;       // objects that are planes
    float extent = 0;                        // largest coordinate of any surface, mm
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;

    explicit Impl(std::span<const Surface> all)
        : surfaces(all), unit_shapes(all.size()), normals(all.size()) {
        // One build thread: the tree, and with it ties between triangles, must not depend on how
        // many cores there are. Not by the device's own "threads=1", which would hold for the whole
        // process as long as the device lives.
        const ThreadLimit one_thread(1);
        device = rtcNewDevice(nullptr);
        TALLOW_CHECK(device != nullptr, "Embree error {}", int(rtcGetDeviceError(nullptr)));
        scene = rtcNewScene(device);
        rtcSetSceneFlags(scene, count_triangles(surfaces) > kManyTriangles
                                    ? RTCSceneFlags(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_COMPACT)
                                    : RTC_SCENE_FLAG_ROBUST);
        for (std::uint32_t object = 0; object < surfaces.size(); ++object) add(object);
        rtcCommitScene(scene);
        const RTCError error = rtcGetDeviceError(device);
        if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
        TALLOW_CHECK(error == RTC_ERROR_NONE, "Embree error {}", int(error));
    }

    ~Impl() {
        rtcReleaseScene(scene);
        rtcReleaseDevice(device);
    }

    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    void add(std::uint32_t object) {
        const Surface& surface = surfaces[object];
        extent = std::max(extent, largest_coordinate(surface));
        RTCGeometry geometry = nullptr;
        if (const auto* mesh = std::get_if<TriangleMesh>(&surface)) {
            geometry = mesh_geometry(device, *mesh);
            normals[object].resize(mesh->triangles.size());
            for (std::size_t t = 0; t < mesh->triangles.size(); ++t)
                normals[object][t] = triangle_normal(*mesh, t);
        } else if (const auto* sphere = std::get_if<SphereSurface>(&surface)) {
            unit_shapes[object] = make_unit_shape(UnitShape::Kind::sphere, sphere->to_world);
            geometry = user_geometry(device, unit_shapes[object]);
        } else if (const auto* disc = std::get_if<DiscSurface>(&surface)) {
            unit_shapes[object] = make_unit_shape(UnitShape::Kind::disc, disc->to_world);
            geometry = user_geometry(device, unit_shapes[object]);
        } else {
            planes.push_back(object);
            return;
        }
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene, geometry, object);
        rtcReleaseGeometry(geometry);
    }

    Hit mesh_hit(const TriangleMesh& mesh, const RTCRayHit& found) const {
        const Triangle& t = mesh.triangles[found.hit.primID];
        const float u = found.hit.u, v = found.hit.v, w = 1 - u - v;
        Hit hit{
            found.ray.tfar, found.hit.geomID, {}, normals[found.hit.geomID][found.hit.primID], {}};
        hit.position = w * mesh.vertices[t[0]] + u * mesh.vertices[t[1]] + v * mesh.vertices[t[2]];
        hit.n = hit.n_g;
        if (!mesh.corner_uvs.empty()) {
            const Vec2* uv = &mesh.corner_uvs[3 * std::size_t(found.hit.primID)];
            hit.uv = w * uv[0] + u * uv[1] + v * uv[2];
        }
        if (!mesh.corner_normals.empty()) {
            const Vec3* n = &mesh.corner_normals[3 * std::size_t(found.hit.primID)];
            hit.n = glm::normalize(w * n[0] + u * n[1] + v * n[2]);
        }
        return hit;
    }

    Hit unit_shape_hit(const Ray& ray, const RTCRayHit& found) const {
        // Again in double: the tree keeps t as a float.
        const UnitShape& shape = unit_shapes[found.hit.geomID];
        const Crossings crossings = cross(shape, DVec3(ray.origin), DVec3(ray.direction));
        const double t =
            std::abs(crossings.t[0] - found.ray.tfar) <= std::abs(crossings.t[1] - found.ray.tfar)
                ? crossings.t[0]
                : crossings.t[1];
        const DVec3 p = surface_point(shape, DVec3(ray.origin), DVec3(ray.direction), t);
        const Vec3 x = to_world(shape, p);
        const Vec3 n = surface_normal(shape, x);
        const Vec2 uv = shape.kind == UnitShape::Kind::sphere ? sphere_uv(p) : disc_uv(p);
        return {found.ray.tfar, found.hit.geomID, x, n, n, uv};
    }

    Hit surface_hit(const Ray& ray, const RTCRayHit& found) const {
        if (const auto* mesh = std::get_if<TriangleMesh>(&surfaces[found.hit.geomID]))
            return mesh_hit(*mesh, found);
        return unit_shape_hit(ray, found);
    }

    Hit lane_hit(const RTCRayHit16& packet, std::size_t lane) const {
        RTCRayHit found{};
        found.ray.tfar = packet.ray.tfar[lane];
        found.hit.u = packet.hit.u[lane], found.hit.v = packet.hit.v[lane];
        found.hit.geomID = packet.hit.geomID[lane], found.hit.primID = packet.hit.primID[lane];
        const Ray ray{{packet.ray.org_x[lane], packet.ray.org_y[lane], packet.ray.org_z[lane]},
                      {packet.ray.dir_x[lane], packet.ray.dir_y[lane], packet.ray.dir_z[lane]}};
        return surface_hit(ray, found);
    }

    bool blocked_by_plane(const ShadowRay& ray) const {
        return !planes.empty() && intersect_planes({ray.origin, ray.direction}, ray.length);
    }

    std::optional<Hit> intersect_planes(const Ray& ray, float length) const {
        std::optional<Hit> nearest;
        for (std::uint32_t object : planes) {
            const auto& plane = std::get<PlaneSurface>(surfaces[object]);
            const double t = cross_plane(plane, ray);
            if (!(t > 0 && t <= (nearest ? nearest->t : length))) continue;
            DVec3 x = DVec3(ray.origin) + t * DVec3(ray.direction);
            x -= glm::dot(x - DVec3(plane.point), DVec3(plane.normal)) * DVec3(plane.normal);
            nearest =
                Hit{float(t), object, Vec3(x), plane.normal, plane.normal, plane_uv(plane, x)};
        }
        return nearest;
    }
};

RayScene::RayScene(std::span<const Surface> surfaces) : impl_(std::make_unique<Impl>(surfaces)) {}
RayScene::~RayScene() = default;
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;

std::optional<Hit> RayScene::intersect(const Ray& ray, float length) const {
    const std::optional<Hit> on_plane = impl_->intersect_planes(ray, length);
    RTCRayHit query{embree_ray(ray, on_plane ? on_plane->t : length), {}};
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(impl_->scene, &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return on_plane;
    return impl_->surface_hit(ray, query);
}

void RayScene::intersect(std::span<const Ray> rays, std::span<std::optional<Hit>> result) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    for (std::size_t start = 0; start < rays.size(); start += kPacket) {
        const std::size_t count = std::min(kPacket, rays.size() - start);
        const Lanes lanes(count);
        std::array<ShadowRay, kPacket> segments;
        for (std::size_t i = 0; i < count; ++i) {
            const Ray& ray = rays[start + i];
            result[start + i] = impl_->intersect_planes(ray, kInfinity);
            segments[i] = {ray.origin, ray.direction,
                           result[start + i] ? result[start + i]->t : kInfinity};
        }
        RTCRayHit16 packet;
        fill(packet.ray, std::span(segments).first(count));
        std::fill_n(packet.hit.geomID, kPacket, RTC_INVALID_GEOMETRY_ID);
        rtcIntersect16(lanes.valid, impl_->scene, &context, &packet);
        for (std::size_t i = 0; i < count; ++i)
            if (packet.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID)
                result[start + i] = impl_->lane_hit(packet, i);
    }
}

std::optional<Hit> RayScene::intersect_object(const Ray& ray, std::uint32_t object,
                                              float length) const {
    // Other objects are met only where bodies overlap or contain each other: step over them.
    Ray rest = ray;
    float travelled = 0;
    for (;;) {
        std::optional<Hit> hit = intersect(rest, length - travelled);
        if (!hit) return std::nullopt;
        if (hit->object == object) {
            hit->t += travelled;
            return hit;
        }
        travelled += hit->t;
        rest.origin = offset_origin(hit->position, hit->n_g, ray.direction);
    }
}

Vec3 RayScene::offset_origin(Vec3 position, Vec3 n_g, Vec3 direction) const {
    constexpr float kOffset = 0x1p-15f, kNearOrigin = 0x1p-6f;
    // A scene of nothing but planes through the origin has no scale: then 1 mm stands for it.
    const float extent = impl_->extent > 0 ? impl_->extent : 1;
    const float reach = std::max(largest_component(position), kNearOrigin * extent);
    const Vec3 n = glm::dot(n_g, direction) >= 0 ? n_g : -n_g;
    return position + kOffset * reach * n;
}

bool RayScene::occluded(const ShadowRay& ray) const {
    RTCRay query = embree_ray({ray.origin, ray.direction}, ray.length);
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(impl_->scene, &context, &query);
    return query.tfar < 0 || impl_->blocked_by_plane(ray);
}

void RayScene::occluded(std::span<const ShadowRay> rays, std::span<bool> result) const {
    RTCIntersectContext context;  // incoherent: the other kind is slower even for one light's rays
    rtcInitIntersectContext(&context);
    for (std::size_t start = 0; start < rays.size(); start += kPacket) {
        const std::size_t count = std::min(kPacket, rays.size() - start);
        const Lanes lanes(count);
        RTCRay16 packet;
        fill(packet, rays.subspan(start, count));
        rtcOccluded16(lanes.valid, impl_->scene, &context, &packet);
        for (std::size_t i = 0; i < count; ++i)
            result[start + i] = packet.tfar[i] < 0 || impl_->blocked_by_plane(rays[start + i]);
    }
}

void RayScene::intersect_object(std::span<const ShadowRay> rays, std::uint32_t object,
                                std::span<std::optional<Hit>> result) const {
    if (std::holds_alternative<PlaneSurface>(impl_->surfaces[object])) {
        for (std::size_t i = 0; i < rays.size(); ++i)
            result[i] =
                intersect_object({rays[i].origin, rays[i].direction}, object, rays[i].length);
        return;
    }
    RTCIntersectContext context;  // incoherent: the other kind is slower even for one light's rays
    rtcInitIntersectContext(&context);
    for (std::size_t start = 0; start < rays.size(); start += kPacket) {
        const std::size_t count = std::min(kPacket, rays.size() - start);
        const Lanes lanes(count);
        RTCRayHit16 packet;
        fill(packet.ray, rays.subspan(start, count));
        std::fill_n(packet.hit.geomID, kPacket, RTC_INVALID_GEOMETRY_ID);
        rtcIntersect16(lanes.valid, impl_->scene, &context, &packet);
        for (std::size_t i = 0; i < count; ++i) {
            const ShadowRay& ray = rays[start + i];
            const std::uint32_t found = packet.hit.geomID[i];
            if (found == RTC_INVALID_GEOMETRY_ID)
                result[start + i] = std::nullopt;
            else if (found == object)
                result[start + i] = impl_->lane_hit(packet, i);
            else
                result[start + i] =
                    intersect_object({ray.origin, ray.direction}, object, ray.length);
        }
    }
}

}  // namespace tallow
