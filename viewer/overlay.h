// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "viewer/view_frame.h"
#include "viewer/view_state.h"

namespace tallow {

/// Lines about the frame and what is chosen: time, points, tolerance and bound, samples.
std::vector<std::string> overlay_lines(const ViewFrame& frame, const ViewState& state);

/// What the keys do.
std::vector<std::string> help_lines();

}  // namespace tallow
