// SPDX-License-Identifier: Apache-2.0
// A place and a direction outside of a body -> the rays that leave it elsewhere. One loop over the
// meetings with the surface from inside.
#include "common/lighting/passage.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/optics/fresnel.h"

namespace tallow {
namespace {

/// A ray inside of a body.
struct InnerRay {
    Vec3 position;  // where it began on the surface, mm
    Vec3 n_g;       // there
    Vec3 direction;
    Rgb weight;
};

// The farthest place where a weight has not fallen below `least` in all channels, in mm.
float reach(Rgb weight, Rgb sigma_t, float least) {
    float longest = 0;
    for (int c = 0; c < 3; ++c)
        if (weight[c] > least)
            longest = std::max(longest, std::log(weight[c] / least) / sigma_t[c]);
    return longest;
}

Rgb transmittance(Rgb sigma_t, float length) {
    return map(sigma_t, [&](float s) { return std::exp(-s * length); });
}

// Interpolated normals refract and reflect, unless they would send light to the wrong side.
std::optional<InnerRay> enter(const Hit& hit, Vec3 w_o, float eta) {
    for (const Vec3 n : {hit.n, hit.n_g}) {
        const float cos_o = glm::dot(w_o, n);
        const auto w = refract(w_o, n, eta);
        if (!(cos_o > 0) || !w || glm::dot(*w, hit.n_g) >= 0) continue;
        return InnerRay{hit.position, hit.n_g, *w,
                        Rgb(fresnel_transmittance(eta, std::min(1.0f, cos_o)))};
    }
    return std::nullopt;
}

/// What becomes of a ray that meets the surface from inside.
class InnerMeeting {
public:
    InnerMeeting(const Hit& hit, Vec3 w, float eta)
        : hit_(hit), w_(w), eta_(eta), n_(glm::dot(w, hit.n) > 0 ? hit.n : hit.n_g) {
        reflectance_ = fresnel_reflectance(1 / eta, std::min(1.0f, glm::dot(w, n_)));
    }

    float reflectance() const { return reflectance_; }

    std::optional<Vec3> refracted() const {
        const auto w = refract(-w_, -n_, 1 / eta_);
        return w && glm::dot(*w, hit_.n_g) > 0 ? w : std::nullopt;
    }
    Vec3 reflected() const {
        const Vec3 w = -reflect(w_, n_);
        return glm::normalize(glm::dot(w, hit_.n_g) < 0 ? w : -reflect(w_, hit_.n_g));
    }

private:
    const Hit& hit_;
    Vec3 w_;
    float eta_;
    Vec3 n_;
    float reflectance_;
};

}  // namespace

void find_passages(const Scene& scene, const RayScene& rays, const Hit& hit, Vec3 w_o,
                   PassageLimits limits, std::vector<Passage>& result) {
    const SubsurfaceMaterial& body = *subsurface(scene, hit.object);
    const float eta = body.medium.eta;
    const Rgb sigma_t = body.medium.sigma_t();
    auto inside = enter(hit, w_o, eta);
    if (!inside) return;
    inside->weight *= surface_tint(scene, body.albedo, hit);
    for (int reflections = 0; reflections <= limits.most_reflections; ++reflections) {
        const float longest = reach(inside->weight, sigma_t, limits.least_weight);
        if (!(longest > 0)) return;
        const Vec3 origin = rays.offset_origin(inside->position, inside->n_g, inside->direction);
        const auto end = rays.intersect_object({origin, inside->direction}, hit.object, longest);
        // From outside: rounding put the ray there, at an edge.
        if (!end || glm::dot(inside->direction, end->n_g) <= 0) return;
        const float length = glm::length(end->position - inside->position);
        const Rgb arriving = inside->weight * transmittance(sigma_t, length);
        const InnerMeeting meeting(*end, inside->direction, eta);
        if (const auto w = meeting.refracted()) {
            const Rgb weight =
                (1 - meeting.reflectance()) * surface_tint(scene, body.albedo, *end) * arriving;
            if (max_channel(weight) > limits.least_weight)
                result.push_back({{rays.offset_origin(end->position, end->n_g, *w), *w}, weight});
        }
        inside = InnerRay{end->position, end->n_g, meeting.reflected(),
                          meeting.reflectance() * arriving};
    }
}

}  // namespace tallow
