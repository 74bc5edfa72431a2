// SPDX-License-Identifier: Apache-2.0
// Scene and cache -> error, time and memory of the boundary-element solve against the number of
// clusters, and how far its exitance is from the half-space's, as CSV on stdout.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>

#include "common/base/errors.h"
#include "common/base/tool_main.h"
#include "common/cloud/cache_io.h"
#include "common/cloud/scene_fingerprint.h"
#include "common/exitance/body_exitance.h"
#include "common/geometry/ray_scene.h"
#include "common/lighting/flights.h"
#include "common/scene/scene_geometry.h"
#include "common/scene/scene_yaml.h"

using namespace tallow;

namespace {

constexpr std::size_t kPoints = 20000;  // of the surface, where exitance is compared

struct Arguments {
    std::filesystem::path scene, cache;
    std::string clusters = "125,500,2000,8000";
    std::vector<std::string> overrides;
};

void declare(CommandLine& line, Arguments& a) {
    line.positional("SCENE", a.scene, "Scene file with translucent bodies");
    line.positional("CACHE", a.cache, "Its cache");
    line.text("--clusters", a.clusters, "Numbers of clusters; errors are against the last",
              "N,...");
    line.text_list("--set", a.overrides, "Override a value of the scene", "KEY=VALUE");
}

std::vector<std::size_t> parse_list(const std::string& text) {
    std::vector<std::size_t> values;
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        values.push_back(std::size_t(parse_number("--clusters", text.substr(begin, end - begin), 0,
                                                  1e6, "numbers, separated by commas")));
        begin = end + 1;
    }
    return values;
}

/// What one number of clusters gives.
struct Row {
    std::size_t clusters;
    double build_seconds, solve_seconds;
    double megabytes, estimate;
    int iterations;
    std::string solved;              // channels, "-" if none
    std::vector<Rgb> M, half_space;  // [point]
};

/// Processor time of all threads, which other programs disturb less than the clock on the wall.
class CpuSeconds {
public:
    double operator()() const { return double(std::clock() - start_) / CLOCKS_PER_SEC; }

private:
    std::clock_t start_ = std::clock();
};

std::vector<ExitancePoint> points_of(const BodyView& body) {
    std::vector<ExitancePoint> points;
    const std::size_t n = body.positions.size(), step = std::max<std::size_t>(1, n / kPoints);
    for (std::size_t i = step / 2; i < n; i += step)
        points.push_back({body.positions[i], body.normals[i], body.normals[i]});
    return points;
}

std::string solved_channels(const DiffusionReport& report) {
    std::string names;
    for (std::size_t c = 0; c < 3; ++c)
        if (report.solved[c]) names += "RGB"[c];
    return names.empty() ? "-" : names;
}

Row solve(const BodyExitance& exitance, const LitSamples& lit,
          std::span<const ExitancePoint> points, double build_seconds) {
    const CpuSeconds seconds;
    BodyDiffusion::Solution solution;
    if (exitance.clusters() > 0) solution = exitance.solve(lit);
    const DiffusionReport report = exitance.report(solution);
    Row row{exitance.clusters(),
            build_seconds,
            seconds(),
            double(exitance.memory_bytes()) * 1e-6,
            report.error,
            solution.iterations,
            solved_channels(report),
            {},
            {}};
    row.M = exitance.field(lit, solution, ExitanceAccuracy{0.002f}).gather(points).M;
    row.half_space = exitance.field(lit, {}, ExitanceAccuracy{0.002f}).gather(points).M;
    return row;
}

double error(const std::vector<Rgb>& M, const std::vector<Rgb>& reference) {
    double sum = 0, squares = 0;
    for (std::size_t i = 0; i < M.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            const double d = double(M[i][c]) - double(reference[i][c]);
            squares += d * d, sum += double(reference[i][c]);
        }
    return sum > 0 ? std::sqrt(squares * 3 * double(M.size())) / sum : 0;
}

/// The exitance of the same light under `model: transport`.
std::vector<Rgb> transport_exitance(const BodyView& body, Scene scene, const LitSamples& lit,
                                    std::span<const ExitancePoint> points) {
    for (Material& material : scene.materials)
        if (auto* medium = std::get_if<SubsurfaceMaterial>(&material.kind))
            use_model(*medium, Model::transport);
    const BodyExitance exitance(body, scene, Orders::all, ExitanceUse::paths, FollowFlights());
    return exitance.field(lit, {}, ExitanceAccuracy{0.002f}).gather(points).M;
}

/// The ratio M / half_space that a part `quantile` of the points and channels stays below, where
/// half_space is at least a hundredth of its mean: in the dark the ratio tells nothing.
double ratio_quantile(const Row& row, double quantile) {
    Rgb sum(0);
    for (const Rgb& M : row.half_space) sum += M;
    const Rgb least = sum * (0.01f / float(row.half_space.size()));
    std::vector<double> ratios;
    for (std::size_t i = 0; i < row.M.size(); ++i)
        for (int c = 0; c < 3; ++c)
            if (row.half_space[i][c] > least[c])
                ratios.push_back(double(row.M[i][c]) / double(row.half_space[i][c]));
    if (ratios.empty()) return 1;
    const auto at = ratios.begin() + std::ptrdiff_t(quantile * double(ratios.size() - 1));
    std::ranges::nth_element(ratios, at);
    return *at;
}

void measure(const Arguments& a, ToolRun& run) {
    const std::vector<std::size_t> numbers = parse_list(a.clusters);
    const Scene scene = load_scene(a.scene, a.overrides);
    const SceneGeometry geometry = load_geometry(scene, run.stats);
    const MappedCache cache(a.cache);
    require_fingerprint(a.cache, cache.view().fingerprint, scene_fingerprint(scene, geometry));
    const RayScene rays(geometry.surfaces);
    fmt::print(
        "object,clusters,build_cpu_s,solve_cpu_s,megabytes,iterations,estimate,relRMSE,half_space,"
        "solved,ratio_1,ratio_99,transport\n");
    for (const BodyView& body : cache.view().bodies) {
        const LitSamples lit = light_samples(body, scene.groups);
        const auto points = points_of(body);
        const std::vector<Rgb> transport = transport_exitance(body, scene, lit, points);
        std::vector<Row> rows;
        for (const std::size_t n : numbers) {
            const CpuSeconds seconds;
            const BodyExitance exitance(
                body, scene, Orders::all, ExitanceUse::paths,
                flights_in(rays, body.object, subsurface(scene, body.object)->medium.eta),
                DiffusionWish{0.01, n});
            const double build_seconds = seconds();
            rows.push_back(solve(exitance, lit, points, build_seconds));
            if (exitance.clusters() == 0) break;
        }
        for (const Row& row : rows)
            fmt::print(
                "{},{},{:.3f},{:.3f},{:.2f},{},{:.5f},{:.5f},{:.5f},{},{:.4f},{:.4f},{:.5f}\n",
                body.object, row.clusters, row.build_seconds, row.solve_seconds, row.megabytes,
                row.iterations, row.estimate, error(row.M, rows.back().M),
                error(row.half_space, rows.back().M), row.solved, ratio_quantile(row, 0.01),
                ratio_quantile(row, 0.99), error(transport, row.M));
    }
}

}  // namespace

int main(int argc, char** argv) {
    Arguments arguments;
    return tool_main(
        "diffusion-convergence",
        "Measures how the boundary-element solve converges with the number of clusters: CSV.", argc,
        argv, [&](CommandLine& line) { declare(line, arguments); },
        [&](ToolRun& run) { measure(arguments, run); });
}
