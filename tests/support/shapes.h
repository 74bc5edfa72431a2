// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/geometry/surface.h"

namespace tallow::test {

inline Surface ball(Vec3 center, float radius) {
    return SphereSurface{{glm::mat3(radius), center}};
}

}  // namespace tallow::test
