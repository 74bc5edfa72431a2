// SPDX-License-Identifier: Apache-2.0
#include "viewer/frame_log.h"

#include <fmt/format.h>
#include <unistd.h>

#include "common/base/errors.h"

namespace tallow {

std::uint64_t resident_memory() {
    std::ifstream statm("/proc/self/statm");
    std::uint64_t total = 0, resident = 0;  // pages
    if (!(statm >> total >> resident)) return 0;
    return resident * std::uint64_t(::sysconf(_SC_PAGESIZE));
}

FrameLog::FrameLog(const std::filesystem::path& file) : file_(file), stream_(file) {
    stream_ << "frame,time_s,kind,milliseconds,latency_ms,width,height,scale,samples,"
               "shading_points,tolerance,largest_bound,rss_mb,aov,x_mm,y_mm,z_mm,primary_ms,"
               "exitance_ms,single_ms,surface_ms,indirect_ms\n"
            << std::flush;
    if (!stream_) throw OutputError(fmt::format("{}: cannot be written", file.string()));
}

void FrameLog::add(const ViewFrame& frame, Aov aov, double latency_ms) {
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start_;
    const Camera& camera = frame.camera;
    std::string phases;
    for (const char* phase : {"primary", "exitance", "single", "surface", "indirect"}) {
        const auto found = frame.seconds.find(phase);
        phases += found == frame.seconds.end() ? "," : fmt::format(",{:.2f}", 1e3 * found->second);
    }
    stream_ << fmt::format("{},{:.3f},{},{:.2f},{:.2f},{},{},{},{},{},{},{},{:.1f},{},{},{},{}",
                           next_++, time.count(), frame.draft ? "draft" : "pass",
                           frame.milliseconds, latency_ms, camera.width, camera.height, frame.scale,
                           frame.samples, frame.shading_points, frame.tolerance,
                           frame.certified ? fmt::format("{:.3g}", frame.largest_bound) : "",
                           double(resident_memory()) / 1e6, aov_name(aov), camera.position.x,
                           camera.position.y, camera.position.z);
    stream_ << phases << std::endl;
    if (!stream_) throw OutputError(fmt::format("{}: cannot be written", file_.string()));
}

}  // namespace tallow
