// SPDX-License-Identifier: Apache-2.0
#include "common/scene/scene.h"

namespace tallow {
namespace {

// Chosen: further reflections bring 1 % to the bunny on its table (docs/INDIRECT.md).
constexpr int kAutomaticBounces = 2;

bool is_convex(const Shape& shape) { return !std::holds_alternative<MeshShape>(shape); }

}  // namespace

void use_model(SubsurfaceMaterial& material, Model model) {
    const bool knows_the_body = model == Model::body_aware;
    material.model = model;
    material.exit = knows_the_body ? Exit::directional : Exit::normalized;
    material.shifts = material.boundary_elements = knows_the_body;
}

int indirect_bounces(const Scene& scene) {
    if (scene.settings.bounces) return *scene.settings.bounces;
    if (scene.objects.empty()) return 0;
    const bool alone = scene.objects.size() == 1 && is_convex(scene.objects.front().shape);
    return alone ? 0 : kAutomaticBounces;
}

}  // namespace tallow
