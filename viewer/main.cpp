// SPDX-License-Identifier: Apache-2.0
#include "common/base/tool_main.h"
#include "common/scene/scene_yaml.h"
#include "viewer/replay.h"
#include "viewer/view_options.h"
#include "viewer/window.h"

using namespace tallow;

namespace {

void view(const ViewOptions& options, ToolRun& run) {
    require_consistent(options);
    PhaseTimer load_timer(run.stats, "load");
    const Scene scene = load_scene(options.scene, options.overrides);
    load_timer.stop();
    if (options.frames)
        replay(scene, options, run);
    else
        show_window(scene, options, run);
}

}  // namespace

int main(int argc, char** argv) {
    ViewOptions options;
    return tool_main(
        "tallow-view",
        "Opens a window to walk around a scene; H shows its keys. Makes the cache if there is none "
        "that fits. With --frames it does without a window what a script says.",
        argc, argv, [&](CommandLine& line) { declare(line, options); },
        [&](ToolRun& run) { view(options, run); });
}
