// SPDX-License-Identifier: Apache-2.0
// Patches of a body -> what paths from them bring, block by block: what opaque surfaces send at
// once, and what bodies send when all the places are known where paths have met them.
#include "precompute/body_paths.h"

#include <algorithm>

#include "common/base/parallel.h"
#include "common/base/rng.h"
#include "common/lighting/cosine_direction.h"
#include "common/optics/fresnel.h"

namespace tallow {
namespace {

constexpr std::size_t kRaysOfTask = 1024;

}  // namespace

BodyPaths::BodyPaths(const Scene& scene, const RayScene& rays, const SampledBody& body,
                     const GatherPatches& patches, const PathOptions& options,
                     std::size_t most_kept)
    : rays_(rays),
      body_(body),
      patches_(patches),
      paths_(scene, rays, options.bounces, options.diffuse),
      rays_per_patch_(std::size_t(options.rays)),
      groups_(scene.groups.size()),
      re_entry_(subsurface(scene, body.object)->re_entry),
      eta_(subsurface(scene, body.object)->medium.eta),
      most_kept_(most_kept) {}

void BodyPaths::gather(std::size_t begin, std::size_t end, const std::vector<GroupFields>& fields,
                       std::vector<GroupIrradiance>* by_surfaces,
                       std::vector<GroupIrradiance>& by_bodies) {
    const auto kept = kept_.find(begin);
    Vertices followed;
    if (kept == kept_.end()) followed = follow(begin, end, by_surfaces);
    const Vertices& vertices = kept == kept_.end() ? followed : kept->second;
    for (std::uint32_t object = 0; object < fields.size(); ++object)
        if (!fields[object].empty() && (re_entry_ || object != body_.object))
            add_exitance(object, fields[object], begin, vertices, by_bodies);
    if (kept != kept_.end()) return;
    std::size_t count = 0;
    for (const auto& block : followed) count += block.size();
    if (count > most_kept_) return;
    most_kept_ -= count;
    kept_[begin] = std::move(followed);
}

BodyPaths::Start BodyPaths::start(std::size_t patch, std::size_t ray) const {
    const std::uint32_t sample = patches_.sample(patch, ray, rays_per_patch_);
    const auto index = std::uint32_t(patch * rays_per_patch_ + ray);
    const Vec3 n = body_.samples.normal[sample];
    const Vec3 w = cosine_direction(n, sobol_2d(index, body_.object + 1));
    const float cos_i = std::min(1.0f, glm::dot(w, n));
    const auto w_refracted = refract(w, n, eta_);
    if (!w_refracted || !(cos_i > 0)) return {sample, w, 0, {}};
    return {sample, w, kPi * fresnel_transmittance(eta_, cos_i) / float(rays_per_patch_),
            *w_refracted};
}

BodyPaths::Vertices BodyPaths::follow(std::size_t begin, std::size_t end,
                                      std::vector<GroupIrradiance>* by_surfaces) const {
    const std::size_t of_block = std::max<std::size_t>(1, kRaysOfTask / rays_per_patch_);
    Vertices vertices((end - begin + of_block - 1) / of_block);
    parallel_for(vertices.size(), 1, [&](std::size_t b) {
        std::vector<Rgb> L(groups_);
        const std::size_t first = begin + b * of_block, last = std::min(end, first + of_block);
        for (std::size_t i = first; i < last; ++i)
            for (std::size_t k = 0; k < rays_per_patch_; ++k) {
                const Start path = start(i, k);
                if (path.weight == 0) continue;
                std::fill(L.begin(), L.end(), Rgb(0));
                const Vec3 n = body_.samples.normal[path.sample];
                const std::uint64_t seed = i * rays_per_patch_ + k;
                paths_.follow(
                    {rays_.offset_origin(body_.samples.ray_origin[path.sample], n, n), path.w},
                    std::uint32_t((i - begin) * rays_per_patch_ + k),
                    mix_bits(seed + (std::uint64_t(body_.object) << 40)),
                    by_surfaces ? LightPaths::Collect::everything : LightPaths::Collect::bodies, L,
                    vertices[b]);
                if (!by_surfaces) continue;
                for (std::size_t g = 0; g < groups_; ++g) add((*by_surfaces)[g], i, path, L[g]);
            }
    });
    return vertices;
}

void BodyPaths::add_exitance(std::uint32_t object, const GroupFields& fields, std::size_t begin,
                             const Vertices& vertices,
                             std::vector<GroupIrradiance>& by_bodies) const {
    std::vector<ExitancePoint> points;
    std::vector<std::size_t> first;  // [block]
    for (const auto& block : vertices) {
        first.push_back(points.size());
        for (const BodyVertex& v : block)
            if (v.object == object) points.push_back({v.position, v.n, v.w_o});
    }
    if (points.empty()) return;
    for (std::size_t g = 0; g < groups_; ++g) {
        if (!fields[g]) continue;
        const Exitance exitance = fields[g]->gather(points);
        parallel_for(vertices.size(), 1, [&](std::size_t b) {
            std::size_t next = first[b];
            for (const BodyVertex& v : vertices[b]) {
                if (v.object != object) continue;
                const std::size_t patch = begin + v.receiver / rays_per_patch_;
                add(by_bodies[g], patch, start(patch, v.receiver % rays_per_patch_),
                    v.factor * exitance.M[next++]);
            }
        });
    }
}

void BodyPaths::add(GroupIrradiance& sums, std::size_t patch, const Start& start, Rgb L) {
    const Rgb E_t = start.weight * L;
    sums.E_t[patch] += E_t;
    sums.w_i[patch] += mean(E_t) * start.w_refracted;
}

}  // namespace tallow
