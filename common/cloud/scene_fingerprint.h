// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/cloud/cache_format.h"
#include "common/scene/scene_geometry.h"

namespace tallow {

/// What pass one depends on: geometry of every object, which of them are translucent and their
/// eta, the lights without their groups' scales, light samples. Not cameras, not image size. What
/// only indirect light depends on has keys that start with "indirect.": the number of bounces and,
/// unless it is 0, media, models and the reflectances of opaque surfaces.
Fingerprint scene_fingerprint(const Scene& scene, const SceneGeometry& geometry);

}  // namespace tallow
