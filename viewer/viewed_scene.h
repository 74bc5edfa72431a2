// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "common/base/progress.h"
#include "common/cloud/cache_io.h"
#include "common/scene/scene_geometry.h"
#include "render/prepared_scene.h"
#include "viewer/view_state.h"

namespace tallow {

/// A scene with all that its pictures are made from.
class ViewedScene {
public:
    /// Reads meshes, and reads or makes the cache if there are bodies that need one. `scene` must
    /// outlive it. Throws InputError, OutputError, Interrupted.
    ViewedScene(const Scene& scene, const SceneWish& wish, const std::filesystem::path& cache_file,
                Progress& progress, Stats& stats);

    /// Changes the world to what is wished for. Throws InputError if that cannot be had without a
    /// new pass one, or Interrupted; then the world is of no use until this is called again.
    void show(const SceneWish& wish);

    const PreparedScene& world() const { return *world_; }
    const SceneWish& shown() const { return shown_; }
    std::string cache_name() const;  ///< fingerprint, for metadata

private:
    const Scene& scene_;
    std::filesystem::path cache_file_;
    Stats& stats_;
    SceneGeometry geometry_;
    std::optional<MappedCache> cache_;
    SceneWish shown_;
    std::optional<PreparedScene> world_;
};

/// The sums' accuracy that a wish asks for.
ExitanceAccuracy accuracy_of(const SceneWish& wish);

}  // namespace tallow
