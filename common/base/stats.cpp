// SPDX-License-Identifier: Apache-2.0
#include "common/base/stats.h"

#include <fmt/format.h>
#include <tbb/version.h>

#include <glm/glm.hpp>
#include <nlohmann/json.hpp>

#include "common/base/output_file.h"

namespace tallow {
namespace {

/// The widest vector instructions that this machine has, whether or not a kernel uses them.
std::string machine_isa() {
#if defined(__x86_64__) || defined(__i386__)
    if (__builtin_cpu_supports("avx512f")) return "avx512";
    if (__builtin_cpu_supports("avx2")) return "avx2";
    if (__builtin_cpu_supports("sse4.2")) return "sse4.2";
    return "sse2";
#elif defined(__aarch64__)
    return "neon";
#else
    return "scalar";
#endif
}

std::string compiler() {
#if defined(__clang__)
    return "clang++ " __clang_version__;
#else
    return "g++ " __VERSION__;
#endif
}

nlohmann::json to_json(const std::map<std::string, Stats::Value>& values) {
    nlohmann::json json = nlohmann::json::object();
    for (const auto& [key, value] : values)
        std::visit([&json, &name = key](const auto& x) { json[name] = x; }, value);
    return json;
}

nlohmann::json to_json(const Plan& plan) {
    nlohmann::json decisions = nlohmann::json::array();
    for (const Decision& d : plan.decisions) {
        decisions.push_back({{"subject", d.subject},
                             {"term", d.term},
                             {"computed", d.computed},
                             {"how", d.how},
                             {"because", d.because}});
        if (d.bound) decisions.back()["bound"] = *d.bound;
    }
    return {{"decisions", decisions}, {"numbers", nlohmann::json(plan.numbers)}};
}

}  // namespace

Stats make_stats(std::string tool, int threads) {
    Stats stats;
    stats.tool = std::move(tool);
    stats.versions = {
        {"tallow", TALLOW_VERSION},
        {"build_type", TALLOW_BUILD_TYPE},
        {"compiler", compiler()},
        {"isa", machine_isa()},
        {"threads", std::to_string(threads)},
        {"fmt",
         fmt::format("{}.{}.{}", FMT_VERSION / 10000, FMT_VERSION / 100 % 100, FMT_VERSION % 100)},
        {"glm", fmt::format("{}.{}.{}", GLM_VERSION_MAJOR, GLM_VERSION_MINOR, GLM_VERSION_PATCH)},
        {"tbb", TBB_runtime_version()},
    };
    return stats;
}

void add_count(Stats& stats, const std::string& name, std::int64_t count) {
    const auto [counted, is_new] = stats.counts.try_emplace(name, std::int64_t{0});
    std::get<std::int64_t>(counted->second) += count;
}

void write_stats(const std::filesystem::path& file, const Stats& stats) {
    nlohmann::json json = {{"tool", stats.tool},
                           {"seconds", nlohmann::json(stats.seconds)},
                           {"counts", to_json(stats.counts)},
                           {"errors", to_json(stats.errors)},
                           {"versions", nlohmann::json(stats.versions)},
                           {"plan", to_json(stats.plan)}};
    for (const Stats::FrameTime& frame : stats.frames)
        json["frames"].push_back({{"frame", frame.frame}, {"seconds", frame.seconds}});
    // File names may hold bytes that are not UTF-8: replaced, for a summary must not fail a render.
    const auto on_bad_utf8 = nlohmann::json::error_handler_t::replace;
    OutputFile output(file);
    output.write(json.dump(2, ' ', false, on_bad_utf8) + "\n");
    output.commit();
}

void PhaseTimer::stop() {
    if (stopped_) return;
    stopped_ = true;
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
    stats_.seconds[phase_] += elapsed.count();
}

}  // namespace tallow
