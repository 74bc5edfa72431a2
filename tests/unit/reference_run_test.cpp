// SPDX-License-Identifier: Apache-2.0
// Rounds, checkpoints and pictures.
#include <gtest/gtest.h>

#include "common/base/errors.h"
#include "common/base/parallel.h"
#include "experiments/reference/accumulator.h"
#include "experiments/reference/render_reference.h"
#include "tests/support/error_text.h"
#include "tests/support/scene_text.h"
#include "tests/support/test_files.h"

namespace tallow::reference {
namespace {

const std::string kBall =
    kCamera +
    "materials: {stone: {type: subsurface, sigma_s_prime: 1, sigma_a: 0.1, eta: 1.4}}\n"
    "objects:\n  - {shape: sphere, radius: 2, material: stone}\n"
    "lights:\n  - {type: quad, position: [9, 9, 9], look_at: [0, 0, 0], size: [4, 4], radiance: "
    "5}\n";

Options small_run(double batches) {
    Options options;
    options.walks = 256;
    options.paths = batches * 3 * 256;
    options.checkpoint = test_out("run.checkpoint");
    return options;
}

Image render(const Options& options, const std::string& text = kBall) {
    const Scene scene = scene_of(text);
    ToolRun run{1, Progress(true), make_stats("test", 1)};
    const SceneGeometry geometry = load_geometry(scene, run.stats);
    return render_reference(scene, geometry, scene.cameras[0], options, run);
}

void expect_same_values(const Image& a, const Image& b) {
    ASSERT_EQ(a.channels.size(), b.channels.size());
    for (std::size_t i = 0; i < a.channels.size(); ++i)
        EXPECT_EQ(a.channels[i].values, b.channels[i].values) << a.channels[i].name;
}

TEST(ReferenceRun, IsTheSameForAnyNumberOfThreads) {
    fresh_folder();
    Image one, three;
    {
        const ThreadLimit limit(1);
        one = render(small_run(24));
    }
    {
        const ThreadLimit limit(3);
        three = render(small_run(24));
    }
    expect_same_values(one, three);
}

TEST(ReferenceRun, GoesOnWhereItStopped) {
    const Image at_once = render(small_run(32));
    render(small_run(16));
    Options rest = small_run(32);
    rest.resume = true;
    expect_same_values(at_once, render(rest));
}

TEST(ReferenceRun, RefusesTheCheckpointOfSomethingElse) {
    render(small_run(16));
    Options rest = small_run(32);
    rest.resume = true;
    rest.seed = 2;
    EXPECT_EQ(error_text<InputError>([&] { render(rest); }),
              rest.checkpoint.string() +
                  ": checkpoint is of another run; remove it, or run without --resume");
    const std::string bytes = read_bytes(rest.checkpoint);
    rest.seed = 1;
    for (std::size_t size : {std::size_t(0), std::size_t(20), bytes.size() / 2, bytes.size() - 1}) {
        write_bytes(rest.checkpoint, bytes.substr(0, size));
        EXPECT_EQ(error_text<InputError>([&] { render(rest); }),
                  rest.checkpoint.string() +
                      ": checkpoint is cut short; remove it, or run without --resume");
    }
    write_bytes(rest.checkpoint, bytes + "x");
    EXPECT_EQ(error_text<InputError>([&] { render(rest); }),
              rest.checkpoint.string() +
                  ": checkpoint is longer than it should be; remove it, or run without --resume");
}

TEST(ReferenceRun, PictureIsTheSumOfItsLayers) {
    const Image image = render(small_run(16));
    const auto& coverage = *image.find_channel("A");
    for (const char* c : {"R", "G", "B"}) {
        const std::string channel = c;
        const auto& all = *image.find_channel(channel);
        for (std::size_t i = 0; i < all.size(); ++i) {
            double sum = 0;
            for (const char* layer : {"single.", "multi.", "ext."})
                sum += double((*image.find_channel(layer + channel))[i]);
            EXPECT_NEAR(double(all[i]), sum, 2e-3 * sum);  // mantissas have 11 bits
            const float variance = (*image.find_channel("variance." + channel))[i];
            EXPECT_TRUE(coverage[i] > 0 || all[i] == 0);
            EXPECT_TRUE(coverage[i] < 1 || variance > 0);
        }
    }
}

// The variance of the mean of 1, 2, 3, 4 is 5/3 / 4.
TEST(ReferenceAccumulator, HasTheVarianceOfTheMean) {
    Accumulator sums(1);
    for (float value : {1.0f, 2.0f, 3.0f, 4.0f}) {
        Film film(1);
        for (int c = 0; c < kChannels; ++c) {
            film.add(multi, c, 0, value);
            film.add(single, c, 0, 2 * value);
            film.add(mirror, c, 0, 100);
        }
        sums.add(film);
    }
    EXPECT_DOUBLE_EQ(sums.mean(multi, 1)[0], 2.5);
    EXPECT_DOUBLE_EQ(sums.variance(multi, 1)[0], 5.0 / 12);
    EXPECT_DOUBLE_EQ(sums.scattered(1)[0], 7.5);
    EXPECT_DOUBLE_EQ(sums.scattered_variance(1)[0], 9 * 5.0 / 12);
    EXPECT_DOUBLE_EQ(sums.variance(mirror, 1)[0], 0);
    EXPECT_DOUBLE_EQ(sums.noise({true}), std::sqrt(9 * 5.0 / 12) / 7.5);
}

TEST(ReferenceRun, StopsAtTheNoiseAskedFor) {
    Options options = small_run(1);
    options.paths.reset();
    options.noise = 0.2;
    const Image image = render(options);
    for (const auto& [key, value] : image.metadata)
        EXPECT_TRUE(key != "tallow/noise" || std::stod(value) <= 0.2);
}

}  // namespace
}  // namespace tallow::reference
