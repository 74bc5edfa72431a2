// SPDX-License-Identifier: Apache-2.0
// Keys -> what is shown; what is wished for -> scene.
#include "viewer/view_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/scene/presets.h"

namespace tallow {
namespace {

constexpr float kExposureStep = 0.5f, kIntensityStep = 0.5f;  // stops
constexpr float kMostStops = 16;

// Tolerances that , and . go through.
constexpr std::array<float, 12> kTolerances = {0.0001f, 0.0002f, 0.0005f, 0.001f, 0.002f, 0.005f,
                                               0.01f,   0.02f,   0.05f,   0.1f,   0.2f,   0.5f};

constexpr std::array<std::string_view, 7> kAovNames = {
    "beauty", "multiple", "single", "specular", "exitance", "error", "evaluations"};

/// The next of none, 0, 1, ..., count - 1, and around.
std::optional<std::size_t> next_of(std::optional<std::size_t> choice, std::size_t count) {
    if (!choice) return 0;
    return *choice + 1 < count ? std::optional(*choice + 1) : std::nullopt;
}

std::optional<Model> next_model(std::optional<Model> model) {
    const auto found = model ? std::ranges::find(kModels, *model, [](auto& m) { return m.second; })
                             : kModels.end();
    if (!model) return kModels.front().second;
    return found + 1 != kModels.end() ? std::optional((found + 1)->second) : std::nullopt;
}

std::string_view model_name(Model model) {
    return std::ranges::find(kModels, model, [](auto& m) { return m.second; })->first;
}

}  // namespace

std::string_view aov_name(Aov aov) { return kAovNames[std::size_t(aov)]; }

Scene changed_scene(const Scene& scene, const SceneWish& wish) {
    Scene changed = scene;
    for (std::size_t g = 0; g < changed.groups.size(); ++g)
        if (wish.group_stops[g] != 0) changed.groups[g].scale *= std::exp2(wish.group_stops[g]);
    for (std::size_t m = 0; m < changed.materials.size(); ++m) {
        auto* body = std::get_if<SubsurfaceMaterial>(&changed.materials[m].kind);
        const MaterialWish& wanted = wish.materials[m];
        if (body == nullptr || wanted == MaterialWish{}) continue;
        if (wanted.preset) {
            const float eta = body->medium.eta;
            body->medium = presets()[*wanted.preset].medium;
            body->medium.eta = eta;
        }
        if (wanted.model) use_model(*body, *wanted.model);
        changed.settings.bounces = 0;
    }
    return changed;
}

ViewState::ViewState(const Scene& scene, float tolerance) : scene_(scene) {
    wish_.tolerance = tolerance;
    wish_.group_stops.assign(scene.groups.size(), 0.0f);
    wish_.materials.resize(scene.materials.size());
    for (std::size_t m = 0; m < scene.materials.size(); ++m)
        if (std::holds_alternative<SubsurfaceMaterial>(scene.materials[m].kind))
            translucent_.push_back(m);
}

void ViewState::handle(const InputEvent& event) {
    if (std::holds_alternative<CloseEvent>(event)) closed_ = true;
    const auto* key = std::get_if<KeyEvent>(&event);
    if (key == nullptr) return;
    if (key->key == Key::shift) shift_ = key->down;
    if (key->key == Key::control) control_ = key->down;
    if (key->down) press(key->key);
}

void ViewState::press(Key key) {
    const auto change_group = [&](float stops) {
        if (wish_.group_stops.empty()) return;
        float& chosen = wish_.group_stops[group_];
        chosen = std::clamp(chosen + stops, -kMostStops, kMostStops);
    };
    if (key >= Key::one && key <= Key::seven) show(Aov(int(key) - int(Key::one)));
    switch (key) {
        case Key::left_bracket:
            exposure_ = std::max(exposure_ - kExposureStep, -kMostStops);
            break;
        case Key::right_bracket:
            exposure_ = std::min(exposure_ + kExposureStep, kMostStops);
            break;
        case Key::comma:
            change_tolerance(true);
            break;
        case Key::period:
            change_tolerance(false);
            break;
        case Key::plus:
            change_group(kIntensityStep);
            break;
        case Key::minus:
            change_group(-kIntensityStep);
            break;
        case Key::l:
            if (!scene_.groups.empty()) group_ = (group_ + 1) % scene_.groups.size();
            break;
        case Key::m:
            change_material();
            break;
        case Key::h:
            help_ = !help_;
            break;
        case Key::f12:
            screenshot_ = true;
            break;
        case Key::escape:
            closed_ = true;
            break;
        default:
            break;
    }
}

// Only certified sums have a bound to show.
void ViewState::show(Aov aov) {
    aov_ = aov;
    wish_.certified = aov == Aov::error;
}

void ViewState::change_tolerance(bool finer) {
    float& tolerance = wish_.tolerance;
    if (finer) {
        const auto next = std::ranges::lower_bound(kTolerances, tolerance);
        if (next != kTolerances.begin()) tolerance = *(next - 1);
    } else {
        const auto next = std::ranges::upper_bound(kTolerances, tolerance);
        if (next != kTolerances.end()) tolerance = *next;
    }
}

void ViewState::change_material() {
    if (translucent_.empty()) return;
    MaterialWish& wish = wish_.materials[translucent_[material_]];
    if (control_)
        material_ = (material_ + 1) % translucent_.size();
    else if (shift_)
        wish.model = next_model(wish.model);
    else
        wish.preset = next_of(wish.preset, presets().size());
}

bool ViewState::take_screenshot_wish() { return std::exchange(screenshot_, false); }

std::string ViewState::selected_group() const {
    if (scene_.groups.empty()) return "";
    return fmt::format("{} {:+.1f} stops", scene_.groups[group_].name, wish_.group_stops[group_]);
}

std::string ViewState::selected_material() const {
    if (translucent_.empty()) return "";
    const std::size_t index = translucent_[material_];
    const Material& material = scene_.materials[index];
    const MaterialWish& wish = wish_.materials[index];
    return fmt::format(
        "{}: {}, model {}", material.name,
        wish.preset ? "preset " + presets()[*wish.preset].name : "its own medium",
        model_name(wish.model.value_or(std::get<SubsurfaceMaterial>(material.kind).model)));
}

}  // namespace tallow
