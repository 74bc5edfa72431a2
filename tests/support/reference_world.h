// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>

#include "experiments/reference/estimators.h"
#include "tests/support/scenes.h"

// Small worlds for tests of the reference, and means with their errors.
namespace tallow::test {

/// A scene of bodies made in code, under lights, seen by one camera.
struct ReferenceWorld {
    Scene scene;
    SceneGeometry geometry;
    std::unique_ptr<reference::Bodies> bodies;
    std::unique_ptr<reference::Lamps> lamps;

    ReferenceWorld(std::vector<Surface> surfaces, const Medium& medium,
                   std::vector<LightShape> lights, const Camera& camera)
        : scene(lit_scene(std::move(lights))) {
        scene.cameras.push_back(camera);
        scene.materials.push_back({"body", SubsurfaceMaterial{.medium = medium}});
        for (std::size_t i = 0; i < surfaces.size(); ++i)
            scene.objects.push_back({SphereShape{1}, 0, {}, "scene"});
        geometry.surfaces = std::move(surfaces);
        bodies = std::make_unique<reference::Bodies>(scene, geometry, camera,
                                                     reference::Detail{.cells = 8000});
        lamps = std::make_unique<reference::Lamps>(scene, bodies->center(), bodies->radius());
    }

    reference::World world() const {
        return {*bodies, *lamps, scene.cameras[0], reference::Pinhole(scene.cameras[0])};
    }
};

/// Mean over the pixels and channels of each layer, in W/(mm^2 sr), with its standard error from
/// independent batches: pixels of one batch are not independent.
struct LayerMeans {
    std::array<double, reference::kLayers> mean{}, error{};
};

template <class AddBatch>
LayerMeans layer_means(std::size_t pixels, int batches, const AddBatch& add_batch) {
    LayerMeans result;
    std::array<double, reference::kLayers> squares{};
    for (int batch = 0; batch < batches; ++batch) {
        reference::Film film(pixels);
        add_batch(std::uint64_t(batch), film);
        for (std::size_t layer = 0; layer < reference::kLayers; ++layer) {
            double sum = 0;
            for (int c = 0; c < 3; ++c)
                for (float v : film.of(int(layer), c)) sum += double(v);
            sum /= double(3 * pixels);
            result.mean[layer] += sum / batches;
            squares[layer] += sum * sum / batches;
        }
    }
    for (std::size_t i = 0; i < reference::kLayers; ++i)
        result.error[i] =
            std::sqrt(std::max(0.0, squares[i] - result.mean[i] * result.mean[i]) / (batches - 1));
    return result;
}

inline LayerMeans combined_means(const reference::World& world, int batches, std::uint32_t walks,
                                 std::uint32_t rays) {
    const reference::StartMaps starts = reference::learn_starts(world, 99, walks);
    return layer_means(world.pinhole.pixels(), batches, [&](std::uint64_t seed, auto& film) {
        add_light_walks(world, starts, seed, walks, film);
        add_camera_walks(world, reference::CameraCounts::unlinked, seed, rays, film);
    });
}

inline LayerMeans camera_means(const reference::World& world, int batches, std::uint32_t rays) {
    return layer_means(world.pinhole.pixels(), batches, [&](std::uint64_t seed, auto& film) {
        add_camera_walks(world, reference::CameraCounts::everything, seed + 1000, rays, film);
    });
}

}  // namespace tallow::test
