// SPDX-License-Identifier: Apache-2.0
// In: albedo and index. Out: energy per ring, by summing the stored table over scattering orders.
#include "common/optics/transport_data.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/base/check.h"
#include "common/base/errors.h"
#include "common/optics/single_scattering.h"

namespace tallow {

extern const std::string_view
    kTransportText;  // data/transport/half_space.txt, see embed_text.cmake

namespace {

using Grid = TransportGrid;
using Factors = std::array<double, Grid::kOrderBins>;

// Mean of alpha'^n over the orders of each bin, weighted as n^(-3/2).
Factors order_factors(const ReducedChannel& channel) {
    constexpr double kNothing = 1e-200;  // keeps the powers out of the denormals
    Factors factors{};
    double power = 1;
    int n = 1;
    for (int bin = 0; bin < Grid::kTailBin && power > kNothing; ++bin) {
        double sum = 0, weights = 0;
        for (; n < Grid::first_order(bin + 1); ++n) {
            power = power > kNothing ? power * channel.alpha_prime : 0;
            const double weight = 1 / (n * std::sqrt(double(n)));
            sum += weight * power, weights += weight;
        }
        factors[std::size_t(bin)] = sum / weights;
    }
    // The same for all orders > N as an integral: e^-x - sqrt(pi x) erfc(sqrt(x)), x = -N ln
    // alpha'.
    const double x = -Grid::kLastOrder * std::log1p(-std::min(channel.absorption, 0.999));
    const double root = std::sqrt(x);
    factors[Grid::kTailBin] =
        x < 30 ? std::exp(-x) - std::sqrt(std::numbers::pi) * root * std::erfc(root) : 0;
    return factors;
}

void check_index(const std::vector<double>& etas, double eta) {
    constexpr double kFloat = 1e-6;  // an index is a float: 0.7f is a little less than 0.7
    if (!(eta >= etas.front() - kFloat && eta <= etas.back() + kFloat))
        throw InputError(fmt::format("eta: expected an index in [{}, {}] for this model, got {}",
                                     etas.front(), etas.back(), eta));
}

}  // namespace

void conserve_energy(TransportTable& table) {
    double total = 0, variance = 0;
    for (const auto& ring : table.rings)
        for (const auto& entry : ring) {
            total += entry.energy;
            variance += double(entry.error) * entry.error;
        }
    const double share = (1 - total) / variance;
    for (auto& ring : table.rings)
        for (auto& entry : ring) {
            const double moved = entry.energy + share * double(entry.error) * entry.error;
            entry.energy = float(std::max(moved, 0.0));
        }
}

const std::vector<TransportTable>& transport_tables() {
    static const auto tables = [] {
        std::vector<TransportTable> read = read_transport_tables(kTransportText);
        for (TransportTable& table : read) conserve_energy(table);
        TALLOW_CHECK(read.size() >= 2 && std::ranges::is_sorted(read, {}, &TransportTable::eta),
                     "{} transport tables", read.size());
        return read;
    }();
    return tables;
}

std::vector<double> interpolation_weights(const std::vector<double>& etas, double eta) {
    constexpr std::ptrdiff_t kPoints = 4;
    const auto kink = std::ranges::lower_bound(etas, 1);
    const auto first = eta < 1 ? etas.begin() : kink;
    const auto last = eta < 1 ? std::min(kink + 1, etas.end()) : etas.end();
    const auto begin = std::clamp(std::lower_bound(first, last, eta) - kPoints / 2, first,
                                  std::max(first, last - kPoints));
    const auto end = std::min(begin + kPoints, last);
    std::vector<double> weights(etas.size());
    for (auto i = begin; i != end; ++i) {
        double& weight = weights[std::size_t(i - etas.begin())];
        weight = 1;
        for (auto j = begin; j != end; ++j)
            if (j != i) weight *= (1 / eta - 1 / *j) / (1 / *i - 1 / *j);
    }
    return weights;
}

std::array<Estimate, Grid::kRings> transport_rings(const ReducedChannel& channel) {
    const auto& tables = transport_tables();
    std::vector<double> etas;
    for (const TransportTable& table : tables) etas.push_back(table.eta);
    check_index(etas, channel.eta);
    const std::vector<double> weights = interpolation_weights(etas, channel.eta);
    const Factors factors = order_factors(channel);

    std::array<Estimate, Grid::kRings> rings;
    for (std::size_t ring = 0; ring < rings.size(); ++ring) {
        double energy = 0, variance = 0;
        for (std::size_t t = 0; t < tables.size(); ++t) {
            if (weights[t] == 0) continue;
            for (std::size_t bin = 1; bin < Grid::kOrderBins; ++bin) {
                const TransportTable::Entry& entry = tables[t].rings[ring][bin];
                energy += weights[t] * factors[bin] * entry.energy;
                variance += std::pow(weights[t] * factors[bin] * entry.error, 2);
            }
            // The tail bin has one factor for all rings, while the far ones hold the later orders:
            // right for the sum, but a ring may be wrong by as much as the factor tells orders
            // apart.
            const double factor = factors[Grid::kTailBin];
            const double tail = tables[t].rings[ring][Grid::kTailBin].energy;
            variance += std::pow(weights[t] * tail * factor * (1 - factor), 2);
        }
        rings[ring] = {std::max(energy, 0.0), std::sqrt(variance)};
    }
    return rings;
}

Estimate transport_reflectance(const ReducedChannel& channel, Orders orders) {
    Estimate total;
    double variance = 0;
    for (const Estimate& ring : transport_rings(channel)) {
        total.value += ring.value;
        variance += ring.error * ring.error;
    }
    total.error = std::sqrt(variance);
    if (orders == Orders::all)
        total.value += single_scattering_reflectance(channel.alpha_prime, channel.eta);
    return total;
}

}  // namespace tallow
