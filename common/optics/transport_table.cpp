// SPDX-License-Identifier: Apache-2.0
// The grid of the transport table and its text: see transport_table.h for both.
#include "common/optics/transport_table.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "common/base/check.h"

namespace tallow {
namespace {

constexpr int kRingsPerDecade = 10;
constexpr int kExactOrders = 16;
constexpr int kBinsPerOctave = 4;
constexpr double kLogRange = 32;  // entries below e^-32 of the light are taken for nothing
constexpr int kLogLevels = 8191, kErrorLevels = 32;
constexpr std::string_view kDigits =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+-";

int encode(const TransportTable::Entry& entry) {
    if (entry.energy <= 0) return 0;
    const double level = (std::log(double(entry.energy)) / kLogRange + 1) * kLogLevels;
    const double relative = std::max(double(entry.error) / entry.energy, 1e-30);
    const int k = std::clamp(int(std::floor(-2 * std::log2(relative))), 0, kErrorLevels - 1);
    return std::clamp(int(std::lround(level)), 0, kLogLevels) * kErrorLevels + k;
}

TransportTable::Entry decode(int code) {
    const int level = code / kErrorLevels, k = code % kErrorLevels;
    if (level == 0) return {};
    const double energy = std::exp(kLogRange * (double(level) / kLogLevels - 1));
    return {float(energy), float(energy * std::exp2(-0.5 * k))};
}

TransportTable read_one(std::istream& in) {
    TransportTable table;
    std::string word[2], row;
    unsigned long long seed = 0;
    in >> table.eta >> word[0] >> table.walks >> word[1] >> seed;
    TALLOW_CHECK(in && word[0] == "walks" && word[1] == "seed", "transport table, header");
    for (auto& ring : table.rings) {
        in >> row;
        TALLOW_CHECK(row.size() == 3 * ring.size(), "transport table, eta {}", table.eta);
        for (std::size_t bin = 0; bin < ring.size(); ++bin) {
            std::size_t code = 0;
            for (std::size_t i = 0; i < 3; ++i) code = code * 64 + kDigits.find(row[3 * bin + i]);
            ring[bin] = decode(int(code));
        }
    }
    return table;
}

}  // namespace

double TransportGrid::outer_radius(int ring) {
    if (ring == kRings - 1) return std::numeric_limits<double>::infinity();
    return 1e-3 * std::pow(10.0, double(ring) / kRingsPerDecade);
}

int TransportGrid::ring_of(double r2) {
    const double decades = 0.5 * std::log10(std::max(r2, 1e-12)) + 3;
    return std::clamp(int(std::ceil(kRingsPerDecade * decades)), 0, kRings - 1);
}

int TransportGrid::first_order(int bin) {
    if (bin < kExactOrders) return bin + 1;
    const double octaves = double(bin - kExactOrders) / kBinsPerOctave;
    return 1 + int(std::lround(kExactOrders * std::exp2(octaves)));
}

int TransportGrid::bin_of(int order) {
    static const auto bins = [] {
        std::vector<std::uint8_t> table(kLastOrder + 2);
        for (int bin = 0; bin < kOrderBins; ++bin)
            std::fill(table.begin() + first_order(bin), table.end(), std::uint8_t(bin));
        return table;
    }();
    return bins[std::size_t(std::min(order, kLastOrder + 1))];
}

std::string write_transport_table(const TransportTable& table, unsigned long long seed) {
    std::string text = fmt::format("eta {} walks {} seed {}\n", table.eta, table.walks, seed);
    for (const auto& ring : table.rings) {
        for (const TransportTable::Entry& entry : ring) {
            const auto code = std::size_t(encode(entry));
            text += {kDigits[code >> 12], kDigits[(code >> 6) & 63], kDigits[code & 63]};
        }
        text += '\n';
    }
    return text;
}

std::vector<TransportTable> read_transport_tables(std::string_view text) {
    std::vector<TransportTable> tables;
    std::istringstream in{std::string(text)};
    for (std::string word; in >> word;) {
        if (word == "eta")
            tables.push_back(read_one(in));
        else
            std::getline(in, word);  // a comment
    }
    return tables;
}

}  // namespace tallow
