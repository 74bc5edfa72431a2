// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/geometry/surface.h"
#include "common/scene/geometry_yaml.h"

namespace tallow {

/// Affine in double: where something stands, in the file's coordinates in mm.
struct Placement {
    glm::dmat3 linear{1.0};
    DVec3 translation{0.0};

    DVec3 point(DVec3 p) const { return linear * p + translation; }
    Affine relative_to(DVec3 origin) const {
        return {glm::mat3(linear), Vec3(translation - origin)};
    }
};

/// The placement that applies `inner` first, then `outer`.
Placement compose(const Placement& outer, const Placement& inner);

/// The key `transform`, a list of steps, or the identity where it is absent. The origin of
/// `lengths` is zero: translations are differences.
Placement read_transform(const YamlMap& map, const LengthReader& lengths);

}  // namespace tallow
