// SPDX-License-Identifier: Apache-2.0
// Scene -> a cache that belongs to it.
#include "viewer/cache_maker.h"

#include <fmt/format.h>

#include <optional>

#include "common/base/errors.h"
#include "precompute/precompute.h"
#include "render/check_cache.h"

namespace tallow {
namespace {

/// Nothing if it was made from another scene.
std::optional<MappedCache> find_cache(const ScenePlan& planned, const SceneGeometry& geometry,
                                      const std::filesystem::path& file, Progress& progress) {
    if (!std::filesystem::exists(file)) return std::nullopt;
    MappedCache cache(file);
    try {
        require_cache_of(planned, geometry, file, cache.view());
    } catch (const InputError& stale) {
        progress.note(fmt::format("{}; making it again", stale.what()));
        return std::nullopt;
    }
    return cache;
}

}  // namespace

MappedCache current_cache(const Scene& scene, const ScenePlan& planned,
                          const SceneGeometry& geometry, const std::filesystem::path& file,
                          Progress& progress, Stats& stats) {
    if (auto cache = find_cache(planned, geometry, file, progress)) return std::move(*cache);
    precompute(scene, {}, file, progress, stats);
    MappedCache cache(file);
    require_cache_of(planned, geometry, file, cache.view());
    progress.note(fmt::format("wrote {}", file.string()));
    return cache;
}

}  // namespace tallow
