// SPDX-License-Identifier: Apache-2.0
// Files -> a world to look at, and its changes.
#include "viewer/viewed_scene.h"

#include "common/exitance/scene_plan.h"
#include "render/check_cache.h"
#include "viewer/cache_maker.h"

namespace tallow {

ExitanceAccuracy accuracy_of(const SceneWish& wish) {
    return {wish.tolerance, ExitanceAccuracy::Criterion::error, wish.certified};
}

ViewedScene::ViewedScene(const Scene& scene, const SceneWish& wish,
                         const std::filesystem::path& cache_file, Progress& progress, Stats& stats)
    : scene_(scene),
      cache_file_(cache_file),
      stats_(stats),
      geometry_(load_geometry(scene, stats)),
      shown_(wish) {
    const ScenePlan planned =
        plan_scene(changed_scene(scene, wish), geometry_, double(wish.tolerance));
    if (!bodies_to_sample(planned).empty())
        cache_.emplace(current_cache(scene, planned, geometry_, cache_file, progress, stats));
    world_.emplace(planned.scene, geometry_, cache_ ? cache_->view() : CacheView{},
                   accuracy_of(wish), planned.diffuse, stats);
}

void ViewedScene::show(const SceneWish& wish) {
    const ScenePlan planned =
        plan_scene(changed_scene(scene_, wish), geometry_, double(wish.tolerance));
    if (cache_) require_cache_of(planned, geometry_, cache_file_, cache_->view());
    world_->change(planned.scene, accuracy_of(wish), planned.diffuse, stats_);
    shown_ = wish;
}

std::string ViewedScene::cache_name() const {
    return cache_ ? fingerprint_id(cache_->view().fingerprint) : "none";
}

}  // namespace tallow
