// SPDX-License-Identifier: Apache-2.0
// Rounds of independent batches until the picture is good enough, with checkpoints.
#include "experiments/reference/render_reference.h"

#include <fmt/format.h>

#include <bit>
#include <chrono>
#include <cmath>

#include "common/base/errors.h"
#include "common/base/parallel.h"
#include "common/base/rng.h"
#include "common/cloud/fingerprint_text.h"
#include "common/cloud/scene_fingerprint.h"
#include "experiments/reference/accumulator.h"
#include "experiments/reference/estimators.h"

namespace tallow::reference {
namespace {

constexpr std::uint32_t kLearningBatches = 4;  // walks of which trials tell where to start
constexpr std::uint64_t kBatchesPerRound = 8;
constexpr std::uint64_t kLeastBatches = 16;
constexpr int kCoverageRays = 256;  // a pixel, 16 x 16
constexpr double kCheckpointSeconds = 60;

/// How a batch divides its time.
struct Shares {
    std::uint32_t walks;        // from the lamps, each channel
    std::uint32_t camera_rays;  // each channel and pixel
};

class Clock {
public:
    explicit Clock(double before) : before_(before), start_(std::chrono::steady_clock::now()) {}
    double seconds() const {
        const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start_;
        return before_ + passed.count();
    }

private:
    double before_;
    std::chrono::steady_clock::time_point start_;
};

Effort add_batch(const World& world, const Options& options, const Shares& shares,
                 const StartMaps& starts, std::uint64_t seed, Film& film) {
    if (options.camera_only)
        return add_camera_walks(world, CameraCounts::everything, seed, shares.camera_rays, film);
    Effort effort = add_light_walks(world, starts, seed, shares.walks, film);
    effort += add_camera_walks(world, CameraCounts::unlinked, seed, shares.camera_rays, film);
    return effort;
}

/// Mean over pixels and channels of the variance of what scattered.
double mean_variance(const Accumulator& sums, std::size_t pixels) {
    double sum = 0;
    for (int channel = 0; channel < kChannels; ++channel)
        for (double v : sums.scattered_variance(channel)) sum += v;
    return sum / double(pixels * kChannels);
}

/// Variance times number, and cost over number, of one kind of walks.
struct Trial {
    double variance, cost;
};
template <class AddWalks>
Trial try_walks(std::size_t pixels, std::uint32_t walks, const AddWalks& add_walks) {
    constexpr std::size_t kTrials = 8;
    std::vector<Film> films(kTrials, Film(pixels));
    std::vector<Effort> efforts(kTrials);
    parallel_for(kTrials, 1, [&](std::size_t i) { efforts[i] = add_walks(i, films[i]); });
    Accumulator sums(pixels);
    double cost = 0;
    for (std::size_t i = 0; i < kTrials; ++i) sums.add(films[i]), cost += efforts[i].cost();
    const double all = double(kTrials) * double(walks);
    return {mean_variance(sums, pixels) * all, cost / all};
}

/// Both kinds of walks bring independent noise: variance V / n at the cost c n. For the least cost,
/// n goes with sqrt(V / c). Walks from the camera may take no more than half of the time, because
/// their variance is that of rare events, which few trials may overrate.
Shares choose_shares(const World& world, const Options& options, const StartMaps& starts) {
    constexpr std::uint32_t kTrialRays = 4;
    const std::uint32_t trial_walks = options.walks / 8;
    if (options.camera_only) return {0, 16};
    const std::size_t pixels = world.pinhole.pixels();
    const std::uint64_t seed = mix_bits(options.seed ^ 0x7069'6c6f'74ull);
    const Trial lamp = try_walks(pixels, trial_walks, [&](std::uint64_t i, Film& film) {
        return add_light_walks(world, starts, seed + i, trial_walks, film);
    });
    const Trial camera = try_walks(pixels, kTrialRays, [&](std::uint64_t i, Film& film) {
        return add_camera_walks(world, CameraCounts::unlinked, seed + i, kTrialRays, film);
    });
    const double ratio = std::sqrt(camera.variance / camera.cost / (lamp.variance / lamp.cost));
    const double most = options.walks * lamp.cost / camera.cost;
    const double rays = std::isfinite(ratio) ? std::min(most, options.walks * ratio) : 1;
    return {options.walks, std::uint32_t(std::max(1.0, std::round(rays)))};
}

/// What the sums of a run depend on.
std::string run_key(const Scene& scene, const SceneGeometry& geometry, const Camera& camera,
                    const Options& options) {
    std::string key = encode_fingerprint(scene_fingerprint(scene, geometry));
    const auto rgb = [](Rgb c) { return fmt::format("{} {} {}", c.r, c.g, c.b); };
    const auto vec = [](Vec3 v) { return fmt::format("{} {} {}", v.x, v.y, v.z); };
    for (const LightGroup& group : scene.groups)
        key += fmt::format("group {}={}\n", group.name, rgb(group.scale));
    for (std::size_t i = 0; i < scene.objects.size(); ++i)
        if (const SubsurfaceMaterial* body = subsurface(scene, i))
            key += fmt::format("medium {}={} {} {} {}\n", i, rgb(body->medium.sigma_s_prime),
                               rgb(body->medium.sigma_a), body->medium.g, body->medium.eta);
    key += fmt::format("camera={} {} {} {} {} {}\n", vec(camera.position), vec(camera.look_at),
                       vec(camera.up), camera.fov, camera.width, camera.height);
    return key + fmt::format("run={} {} {} {}\n", options.seed, options.camera_only, options.walks,
                             options.detail.reach);
}

/// Part of each pixel that bodies cover.
std::vector<float> find_coverage(const World& world) {
    std::vector<float> coverage(world.pinhole.pixels());
    const auto width = std::size_t(world.pinhole.width());
    parallel_for(coverage.size(), 64, [&](std::size_t pixel) {
        int hits = 0;
        for (int i = 0; i < kCoverageRays; ++i) {
            const Vec2 u((float(i % 16) + 0.5f) / 16, (float(i / 16) + 0.5f) / 16);
            const Ray ray =
                camera_ray(world.camera, float(pixel % width) + u.x, float(pixel / width) + u.y);
            hits += world.bodies.enter(ray.origin, ray.direction).has_value();
        }
        coverage[pixel] = float(hits) / kCoverageRays;
    });
    return coverage;
}

/// The nearest float of `bits` bits of mantissa: what is beyond the noise need not be stored.
float round_mantissa(double value, int bits) {
    const auto raw = std::bit_cast<std::uint32_t>(float(value));
    const int drop = 23 - bits;
    const std::uint32_t half = 1u << (drop - 1);
    return std::bit_cast<float>((raw + half) & ~((1u << drop) - 1));
}

void put(Image& image, const std::string& name, const std::vector<double>& values, int bits) {
    std::vector<float>& channel = image.add_channel(name);
    for (std::size_t i = 0; i < values.size(); ++i) channel[i] = round_mantissa(values[i], bits);
}

Image make_picture(const Accumulator& sums, const std::vector<float>& coverage,
                   const Camera& camera) {
    constexpr int kMeanBits = 11, kVarianceBits = 5;
    static constexpr const char* kNames[] = {"single", "multi", "ext", "mirror"};
    Image image = make_image(camera.width, camera.height);
    for (int c = 0; c < kChannels; ++c) {
        const std::string suffix(1, "RGB"[c]);
        put(image, suffix, sums.scattered(c), kMeanBits);
        put(image, "variance." + suffix, sums.scattered_variance(c), kVarianceBits);
        for (int layer = 0; layer < kLayers; ++layer) {
            const std::string name = kNames[layer];
            put(image, name + "." + suffix, sums.mean(layer, c), kMeanBits);
            put(image, name + "_variance." + suffix, sums.variance(layer, c), kVarianceBits);
        }
    }
    image.add_channel("A") = coverage;
    return image;
}

/// Whether a run may stop now.
bool is_done(const Options& options, const Accumulator& sums, const std::vector<bool>& seen,
             const Clock& clock) {
    if (sums.batches() < kLeastBatches) return false;
    const double paths = double(sums.batches()) * kChannels * options.walks;
    return (options.paths && paths >= *options.paths) ||
           (options.seconds && clock.seconds() >= *options.seconds) ||
           (options.noise && sums.noise(seen) <= *options.noise);
}

/// Batches [sums.batches(), ...) of one round, added in their order.
Effort run_round(const World& world, const Options& options, const Shares& shares,
                 const StartMaps& starts, Accumulator& sums) {
    std::vector<Film> films(kBatchesPerRound, Film(world.pinhole.pixels()));
    std::vector<Effort> efforts(kBatchesPerRound);
    parallel_for(kBatchesPerRound, 1, [&](std::size_t i) {
        const std::uint64_t seed = mix_bits(mix_bits(options.seed) + sums.batches() + i);
        efforts[i] = add_batch(world, options, shares, starts, seed, films[i]);
    });
    Effort effort;
    for (std::size_t i = 0; i < kBatchesPerRound; ++i) sums.add(films[i]), effort += efforts[i];
    return effort;
}

/// Rounds until the end; leaves a checkpoint even if interrupted.
class Rounds {
public:
    Rounds(const World& world, const Options& options, const Shares& shares,
           const StartMaps& starts, std::string key, const std::vector<float>& coverage)
        : world_(world),
          options_(options),
          shares_(shares),
          starts_(starts),
          key_(std::move(key)),
          sums_(world.pinhole.pixels()),
          clock_(resume()) {
        for (float a : coverage) seen_.push_back(a > 0.5f);
    }

    void run(ToolRun& tool) {
        double saved = clock_.seconds();
        while (!is_done(options_, sums_, seen_, clock_)) {
            try {
                effort_ += run_round(world_, options_, shares_, starts_, sums_);
            } catch (const Interrupted&) {
                save();
                throw;
            }
            if (clock_.seconds() - saved < kCheckpointSeconds) continue;
            save(), saved = clock_.seconds();
            tool.progress.note(fmt::format("{:.0f} s: {} batches, noise {:.4f}", saved,
                                           sums_.batches(), sums_.noise(seen_)));
        }
        save();
    }

    const Accumulator& sums() const { return sums_; }
    const Effort& effort() const { return effort_; }
    double seconds() const { return clock_.seconds(); }
    double noise() const { return sums_.noise(seen_); }

private:
    double resume() {
        if (!options_.resume || !std::filesystem::exists(options_.checkpoint)) return 0;
        return sums_.load(options_.checkpoint, key_);
    }
    void save() const { sums_.save(options_.checkpoint, key_, clock_.seconds()); }

    const World& world_;
    const Options& options_;
    Shares shares_;
    const StartMaps& starts_;
    std::string key_;
    Accumulator sums_;
    Clock clock_;
    std::vector<bool> seen_;  // [pixel] mostly covered by bodies
    Effort effort_;
};

void add_counts(Stats& stats, const Rounds& rounds, const Shares& shares) {
    const Effort& effort = rounds.effort();
    stats.counts["batches"] = std::int64_t(rounds.sums().batches());
    stats.counts["camera_rays_per_batch"] = std::int64_t(shares.camera_rays);
    stats.counts["walks"] = std::int64_t(effort.walks);
    stats.counts["collisions"] = std::int64_t(effort.collisions);
    stats.counts["turns"] = std::int64_t(effort.turns);
    stats.counts["links"] = std::int64_t(effort.links);
    stats.counts["leaks"] = std::int64_t(effort.leaks);
    stats.errors["noise"] = rounds.noise();
}

}  // namespace

Image render_reference(const Scene& scene, const SceneGeometry& geometry, const Camera& camera,
                       const Options& options, ToolRun& run) {
    PhaseTimer prepare_timer(run.stats, "prepare");
    const Bodies bodies(scene, geometry, camera, options.detail);
    const Lamps lamps(scene, bodies.center(), bodies.radius());
    const World world{bodies, lamps, camera, Pinhole(camera)};
    const std::vector<float> coverage = find_coverage(world);
    const StartMaps starts =
        learn_starts(world, mix_bits(options.seed), kLearningBatches * options.walks);
    const Shares shares = choose_shares(world, options, starts);
    prepare_timer.stop();

    PhaseTimer walk_timer(run.stats, "walk");
    Rounds rounds(world, options, shares, starts, run_key(scene, geometry, camera, options),
                  coverage);
    rounds.run(run);
    walk_timer.stop();
    add_counts(run.stats, rounds, shares);

    const std::uint64_t batches = rounds.sums().batches();
    Image image = make_picture(rounds.sums(), coverage, camera);
    image.metadata = {
        {"tallow/estimator", options.camera_only ? "camera" : "combined"},
        {"tallow/paths",
         fmt::format("{}", options.camera_only ? 0 : batches * kChannels * options.walks)},
        {"tallow/camera_rays", fmt::format("{}", batches * shares.camera_rays * kChannels)},
        {"tallow/batches", fmt::format("{}", batches)},
        {"tallow/seed", fmt::format("{}", options.seed)},
        {"tallow/seconds", fmt::format("{:.0f}", rounds.seconds())},
        {"tallow/noise", fmt::format("{:.5f}", rounds.noise())},
    };
    run.progress.note(fmt::format("{} batches in {:.0f} s, noise {:.4f}", batches, rounds.seconds(),
                                  rounds.noise()));
    return image;
}

}  // namespace tallow::reference
