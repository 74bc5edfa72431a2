// SPDX-License-Identifier: Apache-2.0
#include "common/exitance/lit_samples.h"

#include <cstdint>

#include "common/exitance/exitance_kernels.h"

namespace tallow {
namespace {

// Topology over the samples that were kept; kept_before[i] counts those before sample i.
class TreeCompaction {
public:
    TreeCompaction(std::span<const OctreeNode> nodes, std::span<const std::uint32_t> kept_before,
                   std::vector<OctreeNode>& result)
        : nodes_(nodes), kept_before_(kept_before), result_(result) {}

    void add(std::size_t node) {
        const OctreeNode& old = nodes_[node];
        const std::uint32_t first = kept_before_[old.first];
        const std::uint32_t count = kept_before_[old.first + old.count] - first;
        if (count == 0) return;
        const std::size_t self = result_.size();
        result_.push_back({first, count, 1});
        if (count > kLeafSize)  // else a leaf now, whatever was below it
            for (std::size_t child = node + 1; child < node + old.skip; child += nodes_[child].skip)
                add(child);
        drop_only_child(self);
        result_[self].skip = std::uint32_t(result_.size() - self);
    }

private:
    // A node whose samples all came from one child would be a step without a choice.
    void drop_only_child(std::size_t self) {
        if (result_.size() > self + 1 && result_[self + 1].count == result_[self].count)
            result_.erase(result_.begin() + std::ptrdiff_t(self));
    }

    std::span<const OctreeNode> nodes_;
    std::span<const std::uint32_t> kept_before_;
    std::vector<OctreeNode>& result_;
};

}  // namespace

Rgb indirect_gain(const SubsurfaceMaterial& material) {
    if (material.single_scattering == Switch::off) return Rgb(1);
    Rgb gain;
    for (int c = 0; c < 3; ++c) {
        const auto total = [&](Orders orders) {
            return make_exitance_profile(material.model, material.medium, c, orders)
                ->total_reflectance();
        };
        const double held = total(Orders::two_and_more);
        gain[c] = held > 0 ? float(total(Orders::all) / held) : 1.0f;
    }
    return gain;
}

LitSamples light_samples(const BodyView& body, std::span<const LightGroup> groups,
                         Rgb indirect_gain) {
    const std::size_t n = body.positions.size();
    const bool has_indirect = !body.indirect.empty() && max_channel(indirect_gain) > 0;
    LitSamples lit;
    std::vector<std::uint32_t> kept_before(n + 1);
    for (std::size_t i = 0; i < n; ++i) {
        kept_before[i] = std::uint32_t(lit.position.size());
        Rgb E_t;
        Vec3 weighted_direction(0);
        const auto add = [&](Rgb share, Vec3 w_i) {
            E_t += share;
            weighted_direction += mean(share) * w_i;
        };
        Rgb E_direct;
        for (std::size_t g = 0; g < groups.size(); ++g) {
            const Rgb scale = groups[g].scale;
            add(scale * body.groups[g].E_t[i], body.groups[g].w_i[i]);
            E_direct += scale * body.groups[g].E_t[i];
            if (has_indirect)
                add(indirect_gain * scale * body.indirect[g].E_t[i], body.indirect[g].w_i[i]);
        }
        if (max_channel(E_t) <= 0) continue;
        lit.position.push_back(body.positions[i]);
        lit.index.push_back(std::uint32_t(i));
        lit.normal.push_back(body.normals[i]);
        lit.E_t.push_back(E_t);
        if (has_indirect) lit.E_direct.push_back(E_direct);
        lit.w_i.push_back(weighted_direction / mean(E_t));
        lit.area.push_back(body.areas[i]);
    }
    kept_before[n] = std::uint32_t(lit.position.size());
    if (!body.nodes.empty()) TreeCompaction(body.nodes, kept_before, lit.nodes).add(0);
    return lit;
}

}  // namespace tallow
