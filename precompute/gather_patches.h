// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "common/diffusion/patch_tree.h"
#include "common/geometry/ray_scene.h"
#include "precompute/gather_irradiance.h"
#include "precompute/sample_surface.h"

namespace tallow {

/// How large the patches may be over which indirect light is gathered together. The light of what
/// is far away changes slowly from place to place, that of what is near does not.
struct PatchSize {
    float largest_radius;  ///< spacings, of a disc that spreads as far as the patch
    float of_distance;     ///< that radius over the harmonic mean distance of what the patch sees
};

/// Places of one body from which paths of indirect light set out together, and whose irradiance is
/// spread over the samples around: either each sample by itself, or patches of them.
///
/// Patches are parts of the surface that face alike, as large as PatchSize allows, which a ray from
/// every second sample decides. The rays of a patch set out from all over it. Between patches, at
/// sample i,
///
///     E_i = sum of w_ij E_j / sum of w_ij
///     w_ij = b_j (1 - d^2 / reach^2)^3 max(0, n_i . n_j)^2
///
/// where the reach is that of the smaller of j and the sample's own patch, and the way along the
/// normal counts twice in d: so the sides of a sheet, and sheets behind each other, do not mix. b_j
/// is about the area of j, but such that the flux of all samples is that of the patches.
///
/// Error    docs/INDIRECT.md.
/// Source   [WRC88] for the harmonic mean distance.
class GatherPatches {
public:
    /// Every sample by itself. `samples` must outlive the patches.
    explicit GatherPatches(const SurfaceSamples& samples);
    /// `tree` is over the same samples. The same for any number of threads.
    GatherPatches(const SurfaceSamples& samples, const RayScene& rays, const PatchTree& tree,
                  float spacing, PatchSize size);

    std::size_t count() const { return first_.size() - 1; }
    /// Patches are single samples, and nothing is spread.
    bool single() const { return single_; }

    /// The sample from which ray `ray` of `rays` of a patch sets out.
    std::uint32_t sample(std::size_t patch, std::size_t ray, std::size_t rays) const;

    /// E_t and the sum of mean(E_t) * direction on patches -> E_t and the mean direction on
    /// samples. Both [group].
    std::vector<GroupIrradiance> spread(std::vector<GroupIrradiance> sums) const;

private:
    /// Of a range of patches, by halves: what holds all samples that they reach.
    struct Box {
        Vec3 low{kInfinity}, high{-kInfinity};
    };
    struct Weight {
        std::uint32_t patch;
        float w;
    };
    void cut(const PatchTree& tree, const std::vector<double>& inverse_distances,
             const PatchSize& size, std::uint32_t patch, float inherited);
    void describe();
    Box build_boxes(std::size_t node, std::size_t begin, std::size_t end);
    void find(const Box& box, std::size_t node, std::size_t begin, std::size_t end,
              std::vector<std::uint32_t>& result) const;
    Box samples_of(std::size_t patch) const;
    void weigh(std::size_t patch, std::uint32_t sample, const std::vector<std::uint32_t>& near,
               std::vector<Weight>& weights) const;
    template <class F>
    void for_samples(const F& f) const;
    void balance();

    const SurfaceSamples& samples_;
    bool single_;
    std::vector<std::uint32_t> order_;     // samples, those of a patch side by side
    std::vector<std::uint32_t> first_{0};  // [patch + 1] into order_
    std::vector<Vec3> position_, normal_;  // [patch] means
    std::vector<float> area_, reach_;      // [patch] mm^2, mm
    std::vector<float> strength_;          // [patch] mm^2, what it counts at samples around
    std::vector<Box> boxes_;               // a binary heap over ranges of patches
};

}  // namespace tallow
