// SPDX-License-Identifier: Apache-2.0
//
// tallow-transport-table out.txt [walks]
//
// Walks half-spaces of every index in kEtas and writes the transport tables. `walks` (default
// 2^22 an index) is rounded up to whole batches. Totals and their errors go to stdout.

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>

#include "common/optics/transport_walk.h"

namespace tallow {
namespace {

constexpr double kEtas[] = {0.7,  0.85, 1.0, 1.1, 1.2, 1.3, 1.33, 1.4,
                            1.43, 1.5,  1.6, 1.8, 2.0, 2.5, 3.0};
constexpr std::uint64_t kSeed = 20260;

void report(const TransportTable& table) {
    double total = 0, variance = 0, tail = 0;
    for (const auto& ring : table.rings) {
        for (const auto& entry : ring) {
            total += entry.energy;
            variance += double(entry.error) * entry.error;
        }
        tail += ring[TransportGrid::kTailBin].energy;
    }
    std::cout << "eta " << table.eta << " total " << total << " +- " << std::sqrt(variance)
              << ", beyond the last order " << tail << std::endl;
}

void run(const std::string& file, std::int64_t walks) {
    const std::string temporary = file + ".tmp";
    std::ofstream out(temporary);
    out << "# Half-space transport tables, made by data/generate_transport; format and meaning in\n"
           "# common/optics/transport_table.h. Apache-2.0\n";
    std::uint64_t seed = kSeed;
    for (const double eta : kEtas) {
        const TransportTable table = walk_half_space(eta, walks, ++seed);
        report(table);
        out << write_transport_table(table, seed);
    }
    out.close();
    if (!out) throw std::runtime_error(temporary + ": cannot write");
    std::filesystem::rename(temporary, file);
}

}  // namespace
}  // namespace tallow

int main(int argc, char** argv) {
    if (argc < 2 || argc > 3) {
        std::cerr << "usage: tallow-transport-table out.txt [walks]\n";
        return 2;
    }
    try {
        const std::int64_t walks = argc > 2 ? std::stoll(argv[2]) : std::int64_t(1) << 22;
        const std::int64_t batch = tallow::kWalkBatches;
        tallow::run(argv[1], (walks + batch - 1) / batch * batch);
        return 0;
    } catch (const std::exception& e) {
        std::cerr << "tallow-transport-table: " << e.what() << "\n";
        return 1;
    }
}
