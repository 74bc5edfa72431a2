// SPDX-License-Identifier: Apache-2.0
// Direct light on the samples of a body: a square lamp as in scenes/bunny.yaml, and a sky.
#include <cmath>

#include "benchmarks/benchmarks.h"
#include "benchmarks/shell.h"
#include "precompute/gather_irradiance.h"

namespace tallow {
namespace {

constexpr int kLightRays = 16;

Scene lit_by(LightShape light) {
    Scene scene;
    scene.groups.push_back({"default", Rgb(1)});
    scene.lights.push_back({std::move(light), 0});
    return scene;
}

Scene lamp() {
    const Vec3 normal = glm::normalize(Vec3(-42, -62, 52));
    const Frame frame = make_frame(normal);
    return lit_by(QuadLight{{42, 62, -52}, 36.0f * frame.s, 36.0f * frame.t, normal, Rgb(1)});
}

Scene sky() { return lit_by(EnvironmentLight{Rgb(1)}); }

void gather(benchmark::State& state, const Scene& scene) {
    static const std::vector<Surface> surfaces = {shell_mesh()};
    static const RayScene rays(surfaces);
    const double area = surface_area(surfaces[0]);
    const SurfaceSamples samples =
        sample_surface(surfaces[0], float(std::sqrt(area / double(state.range(0)))));
    Progress quiet(true);
    for (auto _ : state)
        benchmark::DoNotOptimize(
            gather_irradiance(scene, rays, samples, marble().eta, {kLightRays}, quiet));
    state.counters["samples"] = double(samples.size());
    state.counters["time/ray"] = time_each(samples.size() * kLightRays);
}

void add(const char* name, Scene (*scene)()) {
    benchmark::RegisterBenchmark(name, [scene](benchmark::State& state) { gather(state, scene()); })
        ->Arg(200'000)
        ->Arg(1'000'000)
        ->Unit(benchmark::kMillisecond);
}

}  // namespace

void register_irradiance_benchmarks() {
    add("irradiance/lamp", lamp);
    add("irradiance/sky", sky);
}

}  // namespace tallow
