// SPDX-License-Identifier: Apache-2.0
// Scene, coarse cache and fine cache -> sampling error of the exitance as the medium gets denser
// and the spacing of the samples stays, as CSV on stdout.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "common/base/errors.h"
#include "common/base/parallel.h"
#include "common/base/tool_main.h"
#include "common/cloud/cache_io.h"
#include "common/cloud/scene_fingerprint.h"
#include "common/exitance/exitance_field.h"
#include "common/scene/scene_geometry.h"
#include "common/scene/scene_yaml.h"
#include "render/primary_hits.h"
#include "render/shade.h"

using namespace tallow;

namespace {

constexpr float kTolerance = 0.001f;  // of all sums: well below the errors to be measured
constexpr int kShadowRays = 64;
constexpr double kDark = 0.01;  // of the mean: relative errors below are taken against this

struct Arguments {
    std::filesystem::path scene, coarse, fine;
    std::string densities = "1";
    std::vector<std::string> overrides;
};

void declare(CommandLine& line, Arguments& a) {
    line.positional("SCENE", a.scene, "Scene file with one translucent body");
    line.positional("COARSE", a.coarse, "Its cache, whose errors are measured");
    line.positional("FINE", a.fine, "Its cache with a smaller spacing, to compare with");
    line.text("--densities", a.densities, "Factors on the medium's coefficients", "X,...");
    line.text_list("--set", a.overrides, "Override a value of the scene", "KEY=VALUE");
}

std::vector<float> parse_list(const std::string& text) {
    std::vector<float> values;
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        values.push_back(float(parse_number("--densities", text.substr(begin, end - begin), 1e-6,
                                            1e6, "positive numbers, separated by commas")));
        begin = end + 1;
    }
    return values;
}

std::vector<ExitancePoint> find_points(const Scene& scene, const SceneGeometry& geometry,
                                       std::uint32_t object) {
    const RayScene rays(geometry.surfaces);
    const ReflectedLight light(scene, rays, 0);
    const Camera& camera = scene.cameras.front();
    require_camera_outside(scene, rays, camera);
    const PrimaryHits hits =
        find_primary_hits(scene, rays, camera, {0, 0, camera.width, camera.height}, {0, 1, 1});
    std::vector<ShadingPoint> seen;
    for (const ShadingPoint& point : hits.points)
        if (point.depth == 0 && point.hit.object == object) seen.push_back(point);
    std::vector<ExitancePoint> points(seen.size());
    parallel_for(seen.size(), 64, [&](std::size_t i) {
        points[i] = {seen[i].hit.position, seen[i].hit.n, seen[i].w_o,
                     light.entering(seen[i], *subsurface(scene, object), kShadowRays)};
    });
    return points;
}

struct Errors {
    double rel_rmse, p99;
};

Errors compare(const std::vector<Rgb>& M, const std::vector<Rgb>& reference) {
    double mean = 0, squares = 0;
    const double count = 3 * double(M.size());
    for (const Rgb& R : reference) mean += double(R.r + R.g + R.b) / count;
    std::vector<double> relative;
    for (std::size_t i = 0; i < M.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            const double error = std::abs(double(M[i][c]) - double(reference[i][c]));
            squares += error * error;
            relative.push_back(error / std::max(double(reference[i][c]), kDark * mean));
        }
    const auto place = relative.begin() + std::ptrdiff_t(0.99 * double(relative.size()));
    std::nth_element(relative.begin(), place, relative.end());
    return {std::sqrt(squares / count) / mean, *place};
}

class Sweep {
public:
    Sweep(const SubsurfaceMaterial& material, const BodyView& coarse, const BodyView& fine,
          std::span<const LightGroup> groups, std::vector<ExitancePoint> points, std::string name)
        : material_(material),
          coarse_(coarse),
          fine_(fine),
          coarse_lit_(light_samples(coarse, groups)),
          fine_lit_(light_samples(fine, groups)),
          points_(std::move(points)),
          name_(std::move(name)) {}

    void run(float density) const {
        Medium medium = material_.medium;
        medium.sigma_a = density * medium.sigma_a;
        medium.sigma_s_prime = density * medium.sigma_s_prime;
        const auto kernels = [&](const BodyView& body) {
            return make_exitance_kernels(material_.model, medium, orders(), body.spacing_mm);
        };
        const auto reference = field(fine_, fine_lit_, kernels(fine_)).gather(points_).M;
        const ExitanceKernels ours = kernels(coarse_);
        ExitanceKernels smoothed = ours, plain = ours;
        smoothed.beta = plain.beta = {};
        plain.profiles = tabulate_profiles(material_.model, medium, orders());
        const std::pair<const char*, const ExitanceKernels*> methods[] = {
            {"plain", &plain}, {"smoothed", &smoothed}, {"ours", &ours}};
        for (const auto& [method, of_method] : methods) {
            const auto start = std::chrono::steady_clock::now();
            const auto M = field(coarse_, coarse_lit_, *of_method).gather(points_).M;
            const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
            const Errors errors = compare(M, reference);
            fmt::print("{},{},{},{:.3g},{:.3g},{},{},{:.3g},{},{:.4g},{:.4g},{:.3g}\n", name_,
                       model_name(), density, coarse_.spacing_mm,
                       coarse_.spacing_mm / min_channel(medium.mean_free_path()),
                       coarse_.positions.size(), fine_.positions.size(), of_method->beta[2], method,
                       errors.rel_rmse, errors.p99, time.count());
        }
    }

private:
    Orders orders() const {
        return material_.single_scattering == Switch::off ? Orders::all : Orders::two_and_more;
    }
    std::string_view model_name() const {
        return std::find_if(kModels.begin(), kModels.end(),
                            [&](const auto& named) { return named.second == material_.model; })
            ->first;
    }
    static ExitanceField field(const BodyView& body, const LitSamples& lit,
                               const ExitanceKernels& kernels) {
        return {body, lit, kernels, ExitanceAccuracy{kTolerance}};
    }

    const SubsurfaceMaterial& material_;
    const BodyView &coarse_, &fine_;
    LitSamples coarse_lit_, fine_lit_;
    std::vector<ExitancePoint> points_;
    std::string name_;
};

void sweep(const Arguments& a, ToolRun& run) {
    const std::vector<float> densities = parse_list(a.densities);
    const Scene scene = load_scene(a.scene, a.overrides);
    const SceneGeometry geometry = load_geometry(scene, run.stats);
    const MappedCache coarse(a.coarse), fine(a.fine);
    const auto fingerprint = scene_fingerprint(scene, geometry);
    require_fingerprint(a.coarse, coarse.view().fingerprint, fingerprint);
    require_fingerprint(a.fine, fine.view().fingerprint, fingerprint);
    if (coarse.view().bodies.size() != 1)
        throw InputError(fmt::format("{}: expected one translucent body, got {}", a.coarse.string(),
                                     coarse.view().bodies.size()));
    const BodyView& body = coarse.view().bodies.front();
    const SubsurfaceMaterial& material = *subsurface(scene, body.object);
    fmt::print(
        "scene,model,density,spacing_mm,h_per_mfp,samples,reference_samples,beta_blue,method,"
        "relRMSE,p99,seconds\n");
    const Sweep sweep(material, body, fine.view().bodies.front(), scene.groups,
                      find_points(scene, geometry, body.object), a.scene.stem().string());
    for (const float density : densities) sweep.run(density);
}

}  // namespace

int main(int argc, char** argv) {
    Arguments arguments;
    return tool_main(
        "fine-media-sweep",
        "Measures the sampling error of the exitance in denser and denser media, and prints CSV.",
        argc, argv, [&](CommandLine& line) { declare(line, arguments); },
        [&](ToolRun& run) { sweep(arguments, run); });
}
