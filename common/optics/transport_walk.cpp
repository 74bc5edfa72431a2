// SPDX-License-Identifier: Apache-2.0
// In: index, number of walks, seed. Out: the transport table. Each batch of walks fills a table of
// its own; mean and standard error come from the batches, whatever the number of threads.
#include "common/optics/transport_walk.h"

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "common/base/check.h"
#include "common/base/parallel.h"
#include "common/optics/random_walk.h"

namespace tallow {
namespace {

using Grid = TransportGrid;
using Tally = std::array<std::array<double, Grid::kOrderBins>, Grid::kRings>;

// Part of the tail bin that leaves beyond r.
double tail_beyond(double r) {
    if (std::isinf(r)) return 0;
    const double x = std::sqrt(0.75 * r * r / Grid::kLastOrder);
    return x < 1e-8 ? 1 : 0.5 * std::sqrt(std::numbers::pi) * std::erf(x) / x;
}

Tally walk_batch(double eta, std::int64_t walks, std::uint64_t seed, std::uint64_t first) {
    Tally tally{};
    const Slab half_space{.eta = eta};
    double inside = 0;
    for (std::int64_t i = 0; i < walks; ++i) {
        WalkRandom random(seed, first + std::uint64_t(i));
        inside += random_walk(half_space, Grid::kLastOrder, random, [&](const Escape& escape) {
            tally[std::size_t(Grid::ring_of(escape.r2))][std::size_t(Grid::bin_of(escape.order))] +=
                escape.weight;
        });
    }
    double beyond = 1;
    for (int ring = 0; ring < Grid::kRings; ++ring) {
        const double next = tail_beyond(Grid::outer_radius(ring));
        tally[std::size_t(ring)][Grid::kTailBin] = inside * (beyond - next);
        beyond = next;
    }
    return tally;
}

}  // namespace

TransportTable walk_half_space(double eta, std::int64_t walks, std::uint64_t seed) {
    TALLOW_CHECK(walks % kWalkBatches == 0, "{} walks", walks);
    const std::int64_t per_batch = walks / kWalkBatches;
    std::vector<Tally> batches(kWalkBatches);
    parallel_for(batches.size(), 1, [&](std::size_t batch) {
        batches[batch] =
            walk_batch(eta, per_batch, seed, std::uint64_t(per_batch) * std::uint64_t(batch));
    });

    TransportTable table{.eta = eta, .walks = walks};
    for (std::size_t ring = 0; ring < Grid::kRings; ++ring)
        for (std::size_t bin = 0; bin < Grid::kOrderBins; ++bin) {
            double sum = 0, sum2 = 0;
            for (const Tally& batch : batches) {
                const double mean = batch[ring][bin] / double(per_batch);
                sum += mean, sum2 += mean * mean;
            }
            const double n = kWalkBatches, mean = sum / n;
            const double variance = std::fmax(0.0, sum2 / n - mean * mean) / (n - 1);
            table.rings[ring][bin] = {float(mean), float(std::sqrt(variance))};
        }
    return table;
}

}  // namespace tallow
