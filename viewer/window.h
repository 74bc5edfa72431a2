// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/base/tool_main.h"
#include "viewer/view_options.h"

namespace tallow {

/// Opens a window on the scene and lets the user walk around until it is closed.
///
/// Throws   OutputError without a display; InputError, OutputError for what the scene and its cache
///          are wrong with; Interrupted.
void show_window(const Scene& scene, const ViewOptions& options, ToolRun& run);

}  // namespace tallow
