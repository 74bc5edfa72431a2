// SPDX-License-Identifier: Apache-2.0
// Time to sample a surface: large triangles, small ones, bands.
#include <benchmark/benchmark.h>

#include <cmath>

#include "common/base/parallel.h"
#include "precompute/sample_surface.h"

namespace tallow {
namespace {

/// A sphere of radius 10 of about `triangles` triangles.
TriangleMesh ball(double triangles) {
    const auto rows = std::uint32_t(std::sqrt(triangles / 4)), columns = 2 * rows;
    TriangleMesh mesh;
    for (std::uint32_t i = 0; i <= rows; ++i)
        for (std::uint32_t j = 0; j < columns; ++j) {
            const double theta = std::numbers::pi * (i + 0.5) / (rows + 1);
            const double phi = 2 * std::numbers::pi * j / columns;
            mesh.vertices.push_back({float(10 * std::sin(theta) * std::cos(phi)),
                                     float(10 * std::sin(theta) * std::sin(phi)),
                                     float(10 * std::cos(theta))});
        }
    for (std::uint32_t i = 0; i < rows; ++i)
        for (std::uint32_t j = 0; j < columns; ++j) {
            const std::uint32_t a = i * columns, b = a + columns, k = (j + 1) % columns;
            mesh.triangles.push_back({a + j, b + j, b + k});
            mesh.triangles.push_back({a + j, b + k, a + k});
        }
    return mesh;
}

void sample(benchmark::State& state, const Surface& surface) {
    const ThreadLimit limit(int(state.range(1)));
    const auto spacing = float(std::sqrt(surface_area(surface) / double(state.range(0))));
    std::size_t samples = 0;
    for (auto _ : state) samples = sample_surface(surface, spacing).size();
    state.counters["samples"] = double(samples);
}

void count(benchmark::State& state, const Surface& surface) {
    const auto spacing = float(std::sqrt(surface_area(surface) / double(state.range(0))));
    double samples = 0;
    for (auto _ : state) samples = count_samples(surface, spacing);
    state.counters["samples"] = samples;
}

void sample_mesh_of_70k(benchmark::State& state) { sample(state, ball(7e4)); }
void sample_mesh_of_2m(benchmark::State& state) { sample(state, ball(2e6)); }
void sample_sphere(benchmark::State& state) {
    sample(state, SphereSurface{{glm::mat3(10.0f), Vec3(0)}});
}
void count_mesh_of_2m(benchmark::State& state) { count(state, ball(2e6)); }

BENCHMARK(sample_mesh_of_70k)->ArgsProduct({{100'000, 1'000'000}, {1, 2}})->UseRealTime();
BENCHMARK(sample_mesh_of_2m)->ArgsProduct({{100'000, 1'000'000}, {1, 2}})->UseRealTime();
BENCHMARK(sample_sphere)->ArgsProduct({{1'000'000}, {1, 2}})->UseRealTime();
BENCHMARK(count_mesh_of_2m)->Arg(100'000)->Arg(1'000'000)->UseRealTime();

}  // namespace
}  // namespace tallow
