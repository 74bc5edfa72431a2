// SPDX-License-Identifier: Apache-2.0
#include "common/lighting/beams.h"

#include <algorithm>
#include <optional>

#include "common/base/parallel.h"
#include "common/optics/fresnel.h"

namespace tallow {
namespace {

constexpr std::size_t kBlock = 256;  // samples whose rays are traced together

Vec3 direction_at(const LitSamples& lit, std::size_t i) {
    const float length = glm::length(lit.w_i[i]);
    return length > 0 ? lit.w_i[i] / length : -lit.normal[i];
}

Beam beam_to(const Hit& hit, Vec3 w, float eta) {
    const float cosine = std::min(1.0f, std::abs(glm::dot(w, hit.n_g)));
    return {hit.t, fresnel_reflectance(1 / eta, cosine), -reflect(w, hit.n_g)};
}

// Samples of a mesh are centroids of cells, and lie beside the surface where it is curved: a way
// that begins outside of the body enters it first, and goes on there.
bool enters(const std::optional<Hit>& hit, Vec3 w) { return hit && glm::dot(w, hit->n_g) < 0; }

/// A block of ways through one body, traced together.
class Ways {
public:
    Ways(const RayScene& rays, std::uint32_t object) : rays_(rays), object_(object) {}

    void add(Vec3 position, Vec3 n, Vec3 w, float longest) {
        ways_.push_back({rays_.offset_origin(position, n, w), w, longest});
    }
    void trace() {
        hits_.resize(ways_.size());
        rays_.intersect_object(ways_, object_, hits_);
        pass_entries();
    }
    Vec3 direction(std::size_t i) const { return ways_[i].direction; }
    const std::optional<Hit>& hit(std::size_t i) const { return hits_[i]; }

private:
    void pass_entries() {
        std::vector<std::size_t> outside;
        std::vector<ShadowRay> rest;
        for (std::size_t i = 0; i < ways_.size(); ++i) {
            const ShadowRay& way = ways_[i];
            if (!enters(hits_[i], way.direction)) continue;
            outside.push_back(i);
            rest.push_back({rays_.offset_origin(hits_[i]->position, hits_[i]->n_g, way.direction),
                            way.direction, way.length - hits_[i]->t});
        }
        if (rest.empty()) return;
        std::vector<std::optional<Hit>> next(rest.size());
        rays_.intersect_object(rest, object_, next);
        for (std::size_t k = 0; k < rest.size(); ++k) {
            if (next[k]) next[k]->t += hits_[outside[k]]->t;
            hits_[outside[k]] = next[k];
        }
    }

    const RayScene& rays_;
    std::uint32_t object_;
    std::vector<ShadowRay> ways_;
    std::vector<std::optional<Hit>> hits_;
};

}  // namespace

std::vector<Beam> follow_beams(const RayScene& rays, std::uint32_t object, const LitSamples& lit,
                               float eta, float longest) {
    if (longest == 0) return {};
    std::vector<Beam> result(lit.position.size());
    parallel_ranges(result.size(), kBlock, [&](std::size_t begin, std::size_t end) {
        Ways ways(rays, object);
        for (std::size_t i = begin; i < end; ++i)
            ways.add(lit.position[i], lit.normal[i], direction_at(lit, i), longest);
        ways.trace();
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3 w = ways.direction(i - begin);
            const std::optional<Hit>& hit = ways.hit(i - begin);
            result[i] = hit ? beam_to(*hit, w, eta) : Beam{longest, 0, w};
        }
    });
    return result;
}

}  // namespace tallow
