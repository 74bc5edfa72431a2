// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/scene/camera.h"
#include "render/film.h"
#include "viewer/view_state.h"

namespace tallow {

/// A picture on its way to the window.
struct ViewFrame {
    Camera camera;           // its size is that of the picture
    float scale = 1;         // edge of a pixel in pixels of the window
    bool draft = false;      // without what a draft leaves out; see Quality
    int samples = 1;         // camera rays a pixel so far ...
    int wanted_samples = 1;  // ... of so many
    SceneWish wish{};        // what of the scene it shows
    float tolerance = 0;
    bool certified = false;
    float largest_bound = 0;  // relative, over pixels and channels; if certified
    std::int64_t shading_points = 0;
    double milliseconds = 0;                // that it took to compute
    std::map<std::string, double> seconds;  // of its phases, as --stats names them
    std::vector<TilePixels> tiles;          // cover the picture; means over the rays so far

    bool finished() const { return !draft && samples == wanted_samples; }
};

}  // namespace tallow
