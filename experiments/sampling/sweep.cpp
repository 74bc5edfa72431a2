// SPDX-License-Identifier: Apache-2.0
// A body, a medium and numbers of samples -> error of the exitance by the samples alone, as CSV on
// stdout. The body is lit by parallel light, so that E_t has no noise of its own; the reference are
// cells of a quarter of the finest spacing, summed with a tolerance of 1e-4.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>

#include "common/base/errors.h"
#include "common/base/tool_main.h"
#include "common/exitance/exitance_field.h"
#include "common/geometry/mesh_repair.h"
#include "common/scene/presets.h"
#include "common/scene/scene_yaml.h"
#include "experiments/sampling/point_sets.h"
#include "precompute/build_octree.h"
#include "precompute/choose_light_samples.h"
#include "precompute/gather_irradiance.h"

using namespace tallow;

namespace {

struct Arguments {
    std::filesystem::path body;
    std::string samples = "2000,8000,32000,128000", densities = "1,3,10,30", preset = "marble",
                models = "transport", methods = "cells,random,blue-noise,voronoi";
    std::optional<double> extent;
    std::string material;
    std::optional<int> points, seed;
};

void declare(CommandLine& line, Arguments& a) {
    line.positional("BODY", a.body, "Mesh file, or 'sphere'");
    line.number("--extent", a.extent, 1e-3, 1e6, "a number of mm > 0",
                "Largest side of the body's box [default: 40]");
    line.text("--samples", a.samples, "Numbers of samples", "N,...");
    line.text("--densities", a.densities, "Factors for the medium's coefficients", "X,...");
    line.text("--preset", a.preset, "Medium", "NAME");
    line.text("--material", a.material, "Medium, as a scene's material, in place of a preset",
              "YAML");
    line.text("--models", a.models, "Profiles", "MODEL,...");
    line.text("--methods", a.methods, "cells, random, blue-noise, voronoi, bands (sphere only)",
              "METHOD,...");
    line.integer("--points", a.points, 1, 1 << 24, "an integer > 0",
                 "Points where the exitance is compared [default: 3000]");
    line.integer("--seed", a.seed, 1, 1 << 30, "an integer > 0",
                 "Of random points and of blue noise [default: 1]");
}

std::vector<std::string> split(const std::string& text) {
    std::vector<std::string> words;
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        words.push_back(text.substr(begin, end - begin));
        begin = end + 1;
    }
    return words;
}

std::vector<double> numbers(const std::string& flag, const std::string& text) {
    std::vector<double> values;
    for (const std::string& word : split(text))
        values.push_back(parse_number(flag, word, 1e-6, 1e9, "numbers in [1e-6, 1e9]"));
    return values;
}

/// Half a million triangles, so that the mesh is nearer to the sphere than any cell's centroid.
TriangleMesh fine_sphere() {
    constexpr std::uint32_t kRows = 350, kColumns = 700;
    TriangleMesh mesh;
    mesh.vertices = {{0, 0, 1}, {0, 0, -1}};
    for (std::uint32_t i = 1; i < kRows; ++i)
        for (std::uint32_t j = 0; j < kColumns; ++j) {
            const double theta = std::numbers::pi * i / kRows;
            const double phi = 2 * std::numbers::pi * j / kColumns;
            mesh.vertices.push_back({float(std::sin(theta) * std::cos(phi)),
                                     float(std::sin(theta) * std::sin(phi)),
                                     float(std::cos(theta))});
        }
    for (std::uint32_t j = 0; j < kColumns; ++j) {
        const std::uint32_t k = (j + 1) % kColumns, last = 2 + (kRows - 2) * kColumns;
        mesh.triangles.push_back({0, 2 + j, 2 + k});
        mesh.triangles.push_back({1, last + k, last + j});
        for (std::uint32_t i = 0; i + 2 < kRows; ++i) {
            const std::uint32_t a = 2 + i * kColumns, b = a + kColumns;
            mesh.triangles.push_back({a + j, b + j, b + k});
            mesh.triangles.push_back({a + j, b + k, a + k});
        }
    }
    for (const Triangle& t : mesh.triangles)
        for (const std::uint32_t v : t) mesh.corner_normals.push_back(mesh.vertices[v]);
    return mesh;
}

TriangleMesh load_body(const std::filesystem::path& file, double extent) {
    TriangleMesh mesh = file == "sphere"
                            ? fine_sphere()
                            : repair_mesh(read_polygon_soup(file), Normals::smooth, file).mesh;
    Vec3 low(kInfinity), high(-kInfinity);
    for (Vec3 v : mesh.vertices) low = glm::min(low, v), high = glm::max(high, v);
    const Vec3 size = high - low;
    const float scale = float(extent) / std::max({size.x, size.y, size.z});
    for (Vec3& v : mesh.vertices) v = scale * (v - 0.5f * (low + high));
    return mesh;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Samples with their light.
struct Cloud {
    std::string method;
    double wished = 0, spacing = 0, seconds_sample = 0, seconds_light = 0;
    std::size_t samples = 0;
    LitSamples lit;
};

class Sampler {
public:
    Sampler(const Arguments& a, float eta)
        : mesh_(load_body(a.body, a.extent.value_or(40))),
          surfaces_{mesh_},
          rays_(surfaces_),
          eta_(eta),
          seed_(2 * std::uint64_t(a.seed.value_or(1)) - 1) {
        if (a.body == "sphere")
            sphere_.to_world.linear = glm::mat3(float(a.extent.value_or(40)) / 2);
        scene_.groups.push_back({"default", Rgb(1)});
        scene_.lights.push_back({DirectionalLight{glm::normalize(Vec3(-1, -1, -0.5f)), Rgb(1)}, 0});
        scene_.settings.bounces = 0;
    }

    const TriangleMesh& mesh() const { return mesh_; }

    Cloud make(const std::string& method, double wished) const {
        Cloud cloud{method, wished, std::sqrt(surface_area(mesh_) / wished), 0, 0, 0, {}};
        const auto start = std::chrono::steady_clock::now();
        const SurfaceSamples samples = sample(method, wished, float(cloud.spacing));
        cloud.seconds_sample = seconds_since(start);
        cloud.samples = samples.size();

        const auto light_start = std::chrono::steady_clock::now();
        Progress quiet(true);
        const auto groups =
            gather_irradiance(scene_, rays_, samples, eta_, equal_light_samples(scene_, 1), quiet);
        const std::vector<OctreeNode> nodes = build_octree(samples.position);
        cloud.seconds_light = seconds_since(light_start);
        BodyView view{
            0, float(cloud.spacing), 1, samples.position, samples.normal, samples.area, nodes, {},
            {}};
        view.groups.push_back({groups[0].E_t, groups[0].w_i});
        cloud.lit = light_samples(view, scene_.groups);
        return cloud;
    }

private:
    SurfaceSamples sample(const std::string& method, double wished, float spacing) const {
        const auto count = std::size_t(wished);
        if (method == "cells") return sample_surface(mesh_, spacing);
        if (method == "bands") return sample_surface(sphere_, spacing);
        if (method == "random") return random_points(mesh_, count, seed_);
        if (method == "blue-noise") return blue_noise(mesh_, count, seed_);
        if (method == "voronoi")
            return with_voronoi_areas(blue_noise(mesh_, count, seed_),
                                      sample_surface(mesh_, spacing / 4));
        throw UsageError("--methods: unknown method '" + method + "'");
    }

    TriangleMesh mesh_;
    SphereSurface sphere_;
    std::vector<Surface> surfaces_;
    RayScene rays_;
    float eta_;
    std::uint64_t seed_;  // odd: that of the points where exitance is compared is not
    Scene scene_;
};

struct Error {
    double rel_rmse, p99;
};

/// docs/EVALUATOR.md: relRMSE, and the 99th percentile of |M - R| / max(R, 0.01 mean R).
Error compare(std::span<const Rgb> M, std::span<const Rgb> reference) {
    double sum2 = 0, sum = 0;
    for (std::size_t i = 0; i < M.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            const double difference = double(M[i][c]) - double(reference[i][c]);
            sum2 += difference * difference;
            sum += double(reference[i][c]);
        }
    const double count = 3.0 * double(M.size()), mean = sum / count;
    std::vector<double> relative;
    for (std::size_t i = 0; i < M.size(); ++i)
        for (int c = 0; c < 3; ++c)
            relative.push_back(std::abs(double(M[i][c]) - double(reference[i][c])) /
                               std::max(double(reference[i][c]), 0.01 * mean));
    const auto p99 = relative.begin() + std::ptrdiff_t(0.99 * double(relative.size()));
    std::nth_element(relative.begin(), p99, relative.end());
    return {std::sqrt(sum2 / count) / mean, *p99};
}

Model model_named(const std::string& name) {
    for (const auto& [known, model] : kModels)
        if (known == name) return model;
    throw UsageError("--models: unknown model '" + name + "'");
}

Medium medium_of(const Arguments& a) {
    if (a.material.empty()) {
        const Preset* preset = find_preset(a.preset);
        if (preset == nullptr) throw UsageError("--preset: unknown preset '" + a.preset + "'");
        return preset->medium;
    }
    const Scene scene = parse_scene(
        "cameras: {c: {type: perspective, position: [0, 0, 1], look_at: [0, 0, 0], fov_deg: 40, "
        "resolution: [1, 1]}}\nobjects: [{shape: sphere, radius: 1, material: m}]\n"
        "materials: {m: " +
            a.material + "}\n",
        "--material");
    const SubsurfaceMaterial* material = subsurface(scene, 0);
    if (material == nullptr) throw UsageError("--material: expected type subsurface");
    return material->medium;
}

Medium dense(Medium medium, double factor) {
    medium.sigma_a = medium.sigma_a * float(factor);
    medium.sigma_s_prime = medium.sigma_s_prime * float(factor);
    return medium;
}

void sweep(const Arguments& a) {
    const Medium medium_of_body = medium_of(a);
    const Sampler sampler(a, medium_of_body.eta);
    const std::vector<double> wished = numbers("--samples", a.samples);
    const Cloud fine = sampler.make("cells", 16 * std::ranges::max(wished));
    std::vector<Cloud> clouds;
    for (const std::string& method : split(a.methods))
        for (const double n : wished) clouds.push_back(sampler.make(method, n));

    std::vector<ExitancePoint> points;
    const SurfaceSamples at =
        random_points(sampler.mesh(), std::size_t(a.points.value_or(3000)), 2);
    for (std::size_t i = 0; i < at.size(); ++i)
        points.push_back({at.position[i], at.normal[i], at.normal[i]});

    fmt::print(
        "body,preset,density,model,method,wished,samples,spacing_mm,mfp_mm,seconds_sample,"
        "seconds_light,rel_rmse,p99\n");
    for (const double density : numbers("--densities", a.densities))
        for (const std::string& model : split(a.models)) {
            const Medium medium = dense(medium_of_body, density);
            const auto profiles =
                tabulate_profiles(model_named(model), medium, Orders::two_and_more);
            const auto gather = [&](const LitSamples& lit) {
                ExitanceAccuracy accuracy;
                accuracy.tolerance = 1e-4f;
                return ExitanceField(lit, profiles, accuracy).gather(points).M;
            };
            const std::vector<Rgb> reference = gather(fine.lit);
            for (const Cloud& cloud : clouds) {
                const Error error = compare(gather(cloud.lit), reference);
                fmt::print("{},{},{:g},{},{},{:g},{},{:.6g},{:.6g},{:.4f},{:.4f},{:.5g},{:.5g}\n",
                           a.body.stem().string(), a.material.empty() ? a.preset : "material",
                           density, model, cloud.method, cloud.wished, cloud.samples, cloud.spacing,
                           min_channel(medium.mean_free_path()), cloud.seconds_sample,
                           cloud.seconds_light, error.rel_rmse, error.p99);
            }
        }
}

}  // namespace

int main(int argc, char** argv) {
    Arguments arguments;
    return tool_main(
        "sampling-sweep", "Error of the exitance by samples of different kinds.", argc, argv,
        [&](CommandLine& line) { declare(line, arguments); }, [&](ToolRun&) { sweep(arguments); });
}
