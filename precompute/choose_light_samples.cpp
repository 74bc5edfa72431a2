// SPDX-License-Identifier: Apache-2.0
#include "precompute/choose_light_samples.h"

namespace tallow {

LightSampleCounts equal_light_samples(const Scene& scene, int rays) {
    LightSampleCounts counts;
    for (const Light& light : scene.lights) counts.push_back(is_delta(light) ? 1 : rays);
    return counts;
}

}  // namespace tallow
