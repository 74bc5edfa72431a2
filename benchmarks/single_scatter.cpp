// SPDX-License-Identifier: Apache-2.0
// Light scattered once, along rays to the side of a body that faces +z: many eye rays at a time,
// and one by one.
#include "render/single_scatter.h"
#include "benchmarks/benchmarks.h"
#include "benchmarks/shell.h"
#include "common/base/rng.h"

namespace tallow {
namespace {

constexpr MarchSteps kSteps{8, 8};

/// What a camera far away on +z sees.
struct View {
    std::vector<Surface> surfaces = {shell_mesh()};
    RayScene rays{surfaces};
    std::vector<Hit> hits;
    std::vector<EyePoint> points;
    std::vector<Rgb> L;

    explicit View(std::size_t count) {
        for (const Vec3 p : seen_points(count)) {
            const auto hit = rays.intersect({p + Vec3(0, 0, 100), Vec3(0, 0, -1)});
            if (hit && hit->n_g.z > 0) hits.push_back(*hit);
        }
        for (std::size_t i = 0; i < hits.size(); ++i)
            points.push_back({hits[i], Vec3(0, 0, 1), mix_bits(i)});
        L.resize(points.size());
    }
};

const View& view() {
    static const View seen(20'000);
    return seen;
}

Scene lit_by(LightShape light) {
    Scene scene;
    scene.groups.push_back({"default", Rgb(1)});
    scene.lights.push_back({std::move(light), 0});
    return scene;
}

void scatter(benchmark::State& state, LightShape light, std::size_t at_a_time) {
    const View& seen = view();
    const Scene scene = lit_by(std::move(light));
    const ScatteringBody body{scene, seen.rays, seen.surfaces[0], 0, marble()};
    std::vector<Rgb> L(seen.points.size());
    for (auto _ : state)
        for (std::size_t i = 0; i < L.size(); i += at_a_time) {
            const std::size_t count = std::min(at_a_time, L.size() - i);
            single_scatter(body, std::span(seen.points).subspan(i, count), kSteps,
                           std::span(L).subspan(i, count));
        }
    state.counters["time/depth"] = time_each(L.size() * std::size_t(kSteps.of_point));
}

void add(const char* name, const LightShape& light, std::size_t at_a_time) {
    benchmark::RegisterBenchmark(name, [=](benchmark::State& state) {
        scatter(state, light, at_a_time);
    })->Unit(benchmark::kMillisecond);
}

}  // namespace

void register_single_scatter_benchmarks() {
    const QuadLight lamp{{0, 80, 60}, {36, 0, 0}, {0, 0, 36}, {0, -1, 0}, Rgb(1)};
    const EnvironmentLight sky{Rgb(1)};
    add("single scatter/lamp", lamp, 1024);
    add("single scatter/lamp, one by one", lamp, 1);
    add("single scatter/sky", sky, 1024);
    add("single scatter/sky, one by one", sky, 1);
}

}  // namespace tallow
