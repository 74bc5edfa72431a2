// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/scene/scene.h"
#include "viewer/input.h"

namespace tallow {

/// What of the frame is shown.
enum class Aov { beauty, multiple, single, specular, exitance, error, evaluations };
std::string_view aov_name(Aov aov);

/// Another medium or model for a translucent material; without them, the scene's own.
struct MaterialWish {
    std::optional<std::size_t> preset;  // of presets()
    std::optional<Model> model;
    bool operator==(const MaterialWish&) const = default;
};

/// What of the scene may be changed without a new pass one.
struct SceneWish {
    float tolerance = 0;
    bool certified = false;
    std::vector<float> group_stops;       // [group] brighter by so many stops
    std::vector<MaterialWish> materials;  // [material]
    bool operator==(const SceneWish&) const = default;
};

/// The scene with a wish applied.
///
/// A preset keeps the scene's refractive index, which belongs to the cache. Where media or models
/// are others than the cache's indirect light was made for, that light is left out (bounces: 0).
Scene changed_scene(const Scene& scene, const SceneWish& wish);

/// What is shown of a scene, and how; the part of the viewer's state that is no camera.
class ViewState {
public:
    /// The scene must outlive it.
    ViewState(const Scene& scene, float tolerance);

    void handle(const InputEvent& event);

    Aov aov() const { return aov_; }
    float exposure() const { return exposure_; }  // stops
    bool help() const { return help_; }
    bool closed() const { return closed_; }
    const SceneWish& wish() const { return wish_; }
    /// Whether F12 was pressed since the last call.
    bool take_screenshot_wish();

    /// "key +0.5 stops", "marble: preset wax, model dipole"; empty where there is none to choose.
    std::string selected_group() const;
    std::string selected_material() const;

private:
    void press(Key key);
    void show(Aov aov);
    void change_tolerance(bool finer);
    void change_material();

    const Scene& scene_;
    Aov aov_ = Aov::beauty;
    float exposure_ = 0;
    bool help_ = false, closed_ = false, screenshot_ = false;
    bool shift_ = false, control_ = false;
    SceneWish wish_;
    std::size_t group_ = 0;
    std::vector<std::size_t> translucent_;  // materials
    std::size_t material_ = 0;              // index into it
};

}  // namespace tallow
