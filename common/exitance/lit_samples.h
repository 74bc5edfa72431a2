// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/cloud/cache_io.h"
#include "common/scene/scene.h"

namespace tallow {

/// The samples of one body that any light reaches, light groups added up with their scales, and
/// the tree over them. A dark sample adds nothing to any sum, so it is dropped here once.
struct LitSamples {
    std::vector<Vec3> position;     // [sample] mm, in Morton order
    std::vector<Rgb> E_t;           // [sample] W/mm^2, some channel > 0
    std::vector<Vec3> w_i;          // [sample] mean direction of travel inside, see cache_format.h
    std::vector<float> area;        // [sample] mm^2
    std::vector<OctreeNode> nodes;  // depth first; every node owns at least one sample
    std::vector<Rgb> E_direct{};    // [sample] what of E_t comes straight from lights; empty: all

    std::vector<Vec3> normal{};          // [sample] unit, outward
    std::vector<std::uint32_t> index{};  // [sample] in the body

    /// The part of the irradiance that shading points can gather for themselves.
    std::span<const Rgb> direct() const { return E_direct.empty() ? E_t : E_direct; }
};

/// `groups` are the scene's, in the order of the cache's. Indirect light counts `indirect_gain`
/// times: 0 leaves it out, see also indirect_gain().
LitSamples light_samples(const BodyView& body, std::span<const LightGroup> groups,
                         Rgb indirect_gain = Rgb(1));

/// Factor on indirect light so that no energy is lost where only direct light scatters singly: the
/// profile's orders >= 2 then stand for all of them.
///
///     gain = (total reflectance of all orders) / (that of the orders that the exitance holds)
Rgb indirect_gain(const SubsurfaceMaterial& material);

}  // namespace tallow
