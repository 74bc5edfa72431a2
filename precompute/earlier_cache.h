// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "common/cloud/cache_io.h"
#include "precompute/sampled_body.h"

namespace tallow {

/// The cache that a run is about to replace. Direct light depends on geometry and lights, but not
/// on media: where only what reflects light has changed, it is kept.
class EarlierCache {
public:
    /// Holds nothing if the file cannot be read, if it was made from other geometry, lights or ways
    /// of sampling than `scene` says, or if nothing has changed at all: who runs the same again
    /// wants it done again.
    EarlierCache(const std::filesystem::path& file, const Fingerprint& scene);

    /// Spacing of the body's samples, if it is from half of `wanted` to `wanted`: as good, and not
    /// much more work.
    std::optional<float> spacing(std::uint32_t object, float wanted) const;

    /// Copies the direct light, if the samples are the same to the bit.
    bool copy_direct_light(SampledBody& body) const;

private:
    const BodyView* find(std::uint32_t object) const;

    std::optional<MappedCache> cache_;
};

}  // namespace tallow
