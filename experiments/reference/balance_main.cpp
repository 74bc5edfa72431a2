// SPDX-License-Identifier: Apache-2.0
// Walks from the lamps, counted where they enter and leave bodies; no camera.
#include <fmt/format.h>

#include <array>
#include <vector>

#include "common/base/errors.h"
#include "common/base/parallel.h"
#include "common/base/rng.h"
#include "common/base/tool_main.h"
#include "common/scene/scene_yaml.h"
#include "experiments/reference/film.h"
#include "experiments/reference/lamps.h"
#include "experiments/reference/walk.h"

using namespace tallow;
using namespace tallow::reference;

namespace {

struct Arguments {
    std::filesystem::path scene;
    std::vector<std::string> overrides;
    std::optional<double> paths;
    std::optional<int> seed;
};

void declare(CommandLine& line, Arguments& a) {
    line.positional("SCENE", a.scene, "Scene file (YAML or JSON)");
    line.text_list("--set", a.overrides, "Override a value of the scene", "KEY=VALUE");
    line.number("--paths", a.paths, 1, 1e10, "a number in [1, 1e10]",
                "Walks from the lamps, of each channel [default: 1e6]");
    line.integer("--seed", a.seed, 0, 1 << 30, "an integer in [0, 2^30]",
                 "Of the random numbers [default: 1]");
}

/// What can be counted, in the order of a walk.
enum Event : int {
    entered_first,   ///< straight from a lamp
    entered_bare,    ///< not scattered so far: mirrored, or passed through a body
    left_once,       ///< left for the first time, scattered once so far
    left_more,       ///< left for the first time, scattered more often
    entered_second,  ///< left a body once, scattered
    left_second,     ///< for the second time
    entered_later,   ///< left bodies twice or more, scattered
    left_later,      ///< for the third time or more
};
constexpr std::array<const char*, 8> kEvents{"entered_first", "entered_bare",   "left_once",
                                             "left_more",     "entered_second", "left_second",
                                             "entered_later", "left_later"};
using Sums = std::array<double, kEvents.size()>;

Event entry(const Walker& walker, std::uint64_t left) {
    if (walker.collisions == 0) return walker.arrivals == 1 ? entered_first : entered_bare;
    return left == 1 ? entered_second : entered_later;
}

Event exit(const Walker& walker, std::uint64_t left) {
    if (left == 1) return walker.collisions == 1 ? left_once : left_more;
    return left == 2 ? left_second : left_later;
}

void follow(const Bodies& bodies, int channel, Walker walker, WalkRandom& random, Sums& sums) {
    std::uint64_t left = 0;  // times that it left a body, scattered
    walk(
        bodies, channel, walker, random, [](const Walker&, float) {},
        [](auto&&...) { return Next::go_on; },
        [&](const Walker& at, Crossed way) {
            if (way == Crossed::in)
                sums[entry(at, left)] += double(at.power);
            else if (at.collisions > 0)
                sums[exit(at, ++left)] += double(at.power);
        });
}

/// [channel] W
std::array<Sums, kChannels> count_walks(const Bodies& bodies, const Lamps& lamps,
                                        std::uint64_t seed, std::size_t paths) {
    constexpr std::size_t kBlock = 1 << 14;
    const std::size_t blocks = (paths + kBlock - 1) / kBlock;
    std::array<Sums, kChannels> result{};
    for (int channel = 0; channel < kChannels && lamps.count() > 0; ++channel) {
        std::vector<Sums> of_block(blocks);
        const std::uint64_t of_channel = mix_bits(seed * kChannels + std::uint64_t(channel));
        parallel_for(blocks, 1, [&](std::size_t block) {
            if (interrupted()) throw Interrupted();
            for (std::size_t i = 0; i < kBlock; ++i) {
                WalkRandom random(of_channel, block * kBlock + i);
                const auto [lamp, probability] = lamps.pick(channel, random.next());
                const Vec2 point(random.next(), random.next());
                const auto ray =
                    lamps.send(lamp, channel, point, Vec2(random.next(), random.next()));
                if (ray)
                    follow(bodies, channel,
                           {ray->origin, ray->direction,
                            ray->power / probability / float(blocks * kBlock)},
                           random, of_block[block]);
            }
        });
        for (const Sums& sums : of_block)
            for (std::size_t e = 0; e < sums.size(); ++e)
                result[std::size_t(channel)][e] += sums[e];
    }
    return result;
}

void run_tool(const Arguments& a, ToolRun& run) {
    const Scene scene = load_scene(a.scene, a.overrides);
    const SceneGeometry geometry = load_geometry(scene, run.stats);
    const Bodies bodies(scene, geometry, scene.cameras.front(), {});
    const Lamps lamps(scene, bodies.center(), bodies.radius());
    const auto sums = count_walks(bodies, lamps, std::uint64_t(a.seed.value_or(1)),
                                  std::size_t(a.paths.value_or(1e6)));
    fmt::print("event,r,g,b\n");
    for (std::size_t e = 0; e < kEvents.size(); ++e)
        fmt::print("{},{:.6g},{:.6g},{:.6g}\n", kEvents[e], sums[0][e], sums[1][e], sums[2][e]);
}

}  // namespace

int main(int argc, char** argv) {
    Arguments arguments;
    return tool_main(
        "tallow-reference-balance",
        "How much light enters and leaves bodies, and how often, in W by channel: counted along "
        "walks from the lamps.",
        argc, argv, [&](CommandLine& line) { declare(line, arguments); },
        [&](ToolRun& run) { run_tool(arguments, run); });
}
