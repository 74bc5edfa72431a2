// SPDX-License-Identifier: Apache-2.0
#include "precompute/earlier_cache.h"

#include <algorithm>

#include "common/base/errors.h"

namespace tallow {
namespace {

// The pairs that direct light depends on; spacings are asked for body by body.
Fingerprint direct_part(const Fingerprint& fingerprint) {
    Fingerprint direct;
    for (const auto& pair : fingerprint)
        if (!pair.first.starts_with("indirect.") && !pair.first.starts_with("sampling.objects["))
            direct.push_back(pair);
    return direct;
}

Fingerprint indirect_part(const Fingerprint& fingerprint) {
    Fingerprint indirect;
    for (const auto& pair : fingerprint)
        if (pair.first.starts_with("indirect.")) indirect.push_back(pair);
    return indirect;
}

}  // namespace

EarlierCache::EarlierCache(const std::filesystem::path& file, const Fingerprint& scene) {
    if (!std::filesystem::is_regular_file(file)) return;
    try {
        cache_.emplace(file);
    } catch (const InputError&) {
        return;  // about to be replaced, whatever it is
    }
    const Fingerprint& earlier = cache_->view().fingerprint;
    if (direct_part(earlier) != direct_part(scene) ||
        indirect_part(earlier) == indirect_part(scene))
        cache_.reset();
}

const BodyView* EarlierCache::find(std::uint32_t object) const {
    if (!cache_) return nullptr;
    for (const BodyView& body : cache_->view().bodies)
        if (body.object == object) return &body;
    return nullptr;
}

std::optional<float> EarlierCache::spacing(std::uint32_t object, float wanted) const {
    const BodyView* body = find(object);
    if (!body || body->spacing_mm > wanted || body->spacing_mm < wanted / 2) return std::nullopt;
    return body->spacing_mm;
}

bool EarlierCache::copy_direct_light(SampledBody& body) const {
    const BodyView* earlier = find(body.object);
    if (!earlier || !std::ranges::equal(earlier->positions, body.samples.position) ||
        !std::ranges::equal(earlier->normals, body.samples.normal))
        return false;
    body.direct.clear();
    for (const GroupIrradianceView& group : earlier->groups)
        body.direct.push_back(
            {{group.E_t.begin(), group.E_t.end()}, {group.w_i.begin(), group.w_i.end()}});
    return true;
}

}  // namespace tallow
