// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "common/cloud/cache_io.h"
#include "precompute/gather_irradiance.h"
#include "precompute/sample_surface.h"

namespace tallow {

/// What pass one makes of one translucent body; owns what a BodyView points to.
struct SampledBody {
    std::uint32_t object;
    float spacing;  // mm
    double area;    // mm^2
    SurfaceSamples samples;
    std::vector<OctreeNode> nodes;
    std::vector<GroupIrradiance> direct;    // [group]
    std::vector<GroupIrradiance> indirect;  // [group] or empty

    BodyView view() const {
        BodyView view{object, spacing, area, samples.position, samples.normal, samples.area,
                      nodes,  {},      {}};
        for (const GroupIrradiance& group : direct) view.groups.push_back({group.E_t, group.w_i});
        for (const GroupIrradiance& group : indirect)
            view.indirect.push_back({group.E_t, group.w_i});
        return view;
    }
};

}  // namespace tallow
