// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/base/tool_main.h"
#include "viewer/view_options.h"

namespace tallow {

/// Does without a window what a user does at one: frame by frame, 1/30 s apart, it takes the events
/// of the script; a frame after a change is a draft at the full resolution, one after a pause gets
/// another pass. The same frames each time: only their times differ.
///
/// Throws   UsageError, InputError, OutputError, Interrupted.
void replay(const Scene& scene, const ViewOptions& options, ToolRun& run);

}  // namespace tallow
