// SPDX-License-Identifier: Apache-2.0
// Walks from the lamps, each collision of which is linked to the camera.
#include <algorithm>
#include <cmath>

#include "common/base/errors.h"
#include "common/base/parallel.h"
#include "experiments/reference/estimators.h"
#include "experiments/reference/walk.h"

namespace tallow::reference {
namespace {

/// Links of the collisions of one channel's walks, and what they bring.
class Linker {
public:
    Linker(const World& world, int channel, Film& film, Effort& effort)
        : world_(world), channel_(channel), film_(film), effort_(effort) {}

    /// A new walk.
    void begin() { brought_.clear(); }

    /// Over pixels, of what the walk brought so far.
    double sum_of_squares() {
        std::sort(brought_.begin(), brought_.end());
        double sum = 0;
        for (std::size_t i = 0; i < brought_.size();) {
            double of_pixel = 0;
            const std::uint32_t pixel = brought_[i].first;
            for (; i < brought_.size() && brought_[i].first == pixel; ++i)
                of_pixel += double(brought_[i].second);
            sum += of_pixel * of_pixel;
        }
        return sum;
    }

    /// Links of a collision; whether one of them brought light to a pixel.
    template <class Shape>
    bool link(std::uint32_t index, const Shape& shape, const Walker& walker, WalkRandom& random) {
        const Body& body = world_.bodies[index];
        const float sigma_t = body.medium.sigma_t()[channel_];
        // The surface is at least this far: most collisions deep inside end here, by roulette.
        const float nearest = std::max(0.0f, shape.clearance(walker.position));
        if (nearest > body.reach[std::size_t(channel_)]) return false;
        const float first = std::min(1.0f, kKeep * std::exp(-sigma_t * nearest));
        if (first < 1 && random.next() >= first) return false;
        const std::size_t before = brought_.size();
        shape.links(walker.position, body.reach[std::size_t(channel_)],
                    [&](const CameraLink& link) {
                        use(index, body, link, walker, first, sigma_t, random);
                    });
        return brought_.size() > before;
    }

private:
    // A link is drawn by roulette if what it brings is below 1 / kKeep of what it would bring from
    // the surface. Chosen: noise^2 times time is least between 2 and 15, on the bunny and the
    // sphere in marble, and a third less than with 1.
    static constexpr float kKeep = 5;

    void use(std::uint32_t index, const Body& body, const CameraLink& link, const Walker& walker,
             float first, float sigma_t, WalkRandom& random) {
        ++effort_.links;
        const auto view = world_.pinhole.see(link.position);
        if (!view) return;
        const double eta = double(body.medium.eta);
        const double through = 1 - fresnel_reflectance(1 / eta, link.cos_in);
        const double away = std::exp(-double(sigma_t) * link.inside);
        const float cosine = glm::dot(walker.direction, Vec3(link.w));
        const double scattered = double(body.medium.albedo()[channel_]) *
                                 double(henyey_greenstein(body.medium.g, cosine));
        // What the link brings, over what one of a collision at the surface does.
        const double part = scattered * 4 * std::numbers::pi * through * away / double(first);
        const double keep = std::min(1.0, double(kKeep) * part);
        if (!(keep > 0) || (keep < 1 && double(random.next()) >= keep)) return;
        const double visible = visibility(index, walker, link, random);
        if (visible == 0) return;
        const double radiance = double(walker.power) * scattered * through * away * link.spread /
                                (eta * eta) * view->radiance / (double(first) * keep) * visible;
        film_.add(layer_of(walker.collisions, walker.arrivals), channel_, view->pixel,
                  float(radiance));
        brought_.emplace_back(view->pixel, float(radiance));
    }

    // 1 if a link is clear, 0 if not, on average: those that are expected to be clear are tested by
    // chance, and the few that are not, then count for those that were not tested.
    double visibility(std::uint32_t index, const Walker& walker, const CameraLink& link,
                      WalkRandom& random) {
        constexpr float kTested = 0.1f;
        const bool trusted = link.open && world_.bodies.count() == 1;
        if (trusted && random.next() >= kTested) return 1;
        if (world_.bodies.is_clear(index, walker.position, link)) return 1;
        return trusted ? 1 - 1 / double(kTested) : 0;
    }

    const World& world_;
    int channel_;
    Film& film_;
    Effort& effort_;
    std::vector<std::pair<std::uint32_t, float>> brought_;  // by the walk: pixel, radiance
};

/// Walks of one channel from the lamps.
class LightWalks {
public:
    LightWalks(const World& world, const StartMaps& starts, std::uint64_t seed, int channel,
               Film& film)
        : world_(world),
          starts_(starts),
          seed_(mix_bits(seed * kChannels + std::uint64_t(channel))),
          directions_(mix_bits(seed_)),
          channel_(channel),
          linker_(world, channel, film, effort_) {}

    /// What one walk did.
    struct Trace {
        std::size_t start;  // lamp * cells + cell of the direction
        double square;      // sum over pixels of the square of what it brought
        double cost;
    };

    /// The walk of number i, whose power is divided by `walks`; nothing if it carries no light.
    std::optional<Trace> follow(std::uint32_t i, std::uint32_t walks) {
        WalkRandom random(seed_, i);
        const auto [lamp, probability] = world_.lamps.pick(channel_, random.next());
        const Vec2 point(random.next(), random.next());
        const StartMap& map = starts_[lamp * kChannels + std::uint32_t(channel_)];
        const auto [direction, density] = map.draw(directions_(i));
        const auto ray = world_.lamps.send(lamp, channel_, point, direction);
        if (!ray) return std::nullopt;
        const float worth = 1 / (probability * density);
        Walker walker{ray->origin, ray->direction, ray->power * worth / float(walks)};
        const double cost_before = effort_.cost();
        linker_.begin();
        may_split_ = true;
        go_through_air(walker, random);
        for (const auto& [body, at] : copies_) go_on_from(body, at, random);
        copies_.clear();
        ++effort_.walks;
        const std::size_t cells = std::size_t(StartMap::kSide) * StartMap::kSide;
        return Trace{lamp * cells + StartMap::cell(direction), linker_.sum_of_squares(),
                     effort_.cost() - cost_before};
    }

    const Effort& effort() const { return effort_; }

private:
    // Walks that a walk becomes when it first brings light to a pixel: few walks get there, and the
    // rest of their way is short. Chosen: noise^2 times time is least between 3 and 8, on the bunny
    // and the sphere in marble and skim milk, and 0.6 to 0.9 times that of one walk.
    static constexpr int kCopies = 4;

    auto on_collision(WalkRandom& random) {
        return [this, &random](std::uint32_t body, const auto& shape, Walker& at, Vec3) {
            if (linker_.link(body, shape, at, random) && may_split_) {
                may_split_ = false;
                at.power /= kCopies;
                copies_.assign(kCopies - 1, {body, at});
            }
            return Next::go_on;
        };
    }

    void go_through_air(Walker& walker, WalkRandom& random) {
        walk(
            world_.bodies, channel_, walker, random, [](const Walker&, float) {},
            on_collision(random));
        count(walker);
    }

    // A copy that starts at a collision.
    void go_on_from(std::uint32_t body, Walker walker, WalkRandom& random) {
        const Walker before = walker;
        const Medium& medium = world_.bodies[body].medium;
        if (survive_collision(medium, channel_, walker, random) &&
            walk_in_body(world_.bodies, body, channel_, walker, random, on_collision(random)))
            walk(
                world_.bodies, channel_, walker, random, [](const Walker&, float) {},
                on_collision(random));
        count(walker);
        effort_.collisions -= before.collisions, effort_.turns -= before.turns;
    }

    void count(const Walker& walker) {
        effort_ += {0, walker.collisions, walker.turns, 0, walker.leaks};
    }

    const World& world_;
    const StartMaps& starts_;
    std::uint64_t seed_;
    Sobol2d directions_;
    int channel_;
    Effort effort_;
    Linker linker_;
    bool may_split_ = false;
    std::vector<std::pair<std::uint32_t, Walker>> copies_;  // body, at a collision
};

}  // namespace

Effort& Effort::operator+=(const Effort& o) {
    walks += o.walks, collisions += o.collisions, turns += o.turns, links += o.links;
    leaks += o.leaks;
    return *this;
}

// Measured on the bunny: a ray costs about what three collisions do.
double Effort::cost() const {
    return 5.0 * double(walks) + double(collisions) + 3.0 * double(turns) + 1.0 * double(links);
}

Effort add_light_walks(const World& world, const StartMaps& starts, std::uint64_t seed,
                       std::uint32_t walks, Film& film) {
    Effort effort;
    for (int channel = 0; channel < kChannels && world.lamps.count() > 0; ++channel) {
        LightWalks all(world, starts, seed, channel, film);
        for (std::uint32_t i = 0; i < walks; ++i) {
            if (i % 4096 == 0 && interrupted()) throw Interrupted();
            all.follow(i, walks);
        }
        effort += all.effort();
    }
    return effort;
}

StartMaps learn_starts(const World& world, std::uint64_t seed, std::uint32_t walks) {
    constexpr std::size_t kCells = std::size_t(StartMap::kSide) * StartMap::kSide;
    const std::size_t lamps = world.lamps.count();
    const StartMaps even(lamps * kChannels);
    StartMaps learnt = even;
    parallel_for(kChannels, 1, [&](std::size_t channel) {
        std::vector<double> squares(lamps * kCells), costs(lamps * kCells), counts(lamps * kCells);
        Film film(world.pinhole.pixels());
        LightWalks all(world, even, seed, int(channel), film);
        for (std::uint32_t i = 0; i < walks && lamps > 0; ++i)
            if (const auto trace = all.follow(i, 1)) {
                squares[trace->start] += trace->square;
                costs[trace->start] += trace->cost;
                ++counts[trace->start];
            }
        for (std::size_t lamp = 0; lamp < lamps; ++lamp) {
            StartMap::Cells worth{};
            for (std::size_t cell = 0; cell < kCells; ++cell) {
                const std::size_t at = lamp * kCells + cell;
                if (costs[at] > 0) worth[cell] = std::sqrt(squares[at] / costs[at]);
            }
            learnt[lamp * kChannels + channel] = StartMap(worth);
        }
    });
    return learnt;
}

}  // namespace tallow::reference
