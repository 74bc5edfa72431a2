// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace tallow {

/// Grid of the transport table: rings around the point of entry by scattering orders.
/// Ring 0 is the disc inside 1e-3 mean free paths, ring 61 all beyond 1e3, ten rings a decade
/// between. Orders 1 to 16 have bins of their own, then four bins an octave up to 65536; the last
/// bin holds what was still inside after that.
struct TransportGrid {
    static constexpr int kRings = 62;
    static constexpr int kOrderBins = 65;
    static constexpr int kLastOrder = 65536;
    static constexpr int kTailBin = kOrderBins - 1;

    /// Outer radius of a ring, in mean free paths; infinite for the last.
    static double outer_radius(int ring);
    static int ring_of(double r2);
    /// First order of a bin; first_order(kTailBin) is kLastOrder + 1.
    static int first_order(int bin);
    static int bin_of(int order);
};

/// What leaves a half-space without absorption, split by where and after how many collisions.
///
/// Light enters at right angles; the phase function is isotropic, which a medium of any g becomes
/// in reduced units. `energy` is the part of the entered light, so that all entries sum to 1, and
/// with a reduced albedo alpha' an entry carries energy * alpha'^order.
struct TransportTable {
    struct Entry {
        float energy = 0;
        float error = 0;  ///< standard error of `energy`
    };
    double eta = 1;
    long long walks = 0;
    std::array<std::array<Entry, TransportGrid::kOrderBins>, TransportGrid::kRings> rings{};
};

/// Text of tables, and back: a line "eta 1.5 walks 4194304 seed 7", then a line a ring of three
/// characters a bin. They are an 18-bit number in base 64 (A-Z, a-z, 0-9, +, -; high digit first):
/// 13 bits of L, energy = e^(-32 + 32 L / 8191) or nothing for L = 0, then 5 bits of k, relative
/// standard error 2^(-k/2).
///
/// Error    energy is rounded by at most 0.2 %, half the step of L, in either direction alike.
/// Throws   std::logic_error on text that write_transport_table did not write: it is our own file.
std::string write_transport_table(const TransportTable& table, unsigned long long seed);
std::vector<TransportTable> read_transport_tables(std::string_view text);

}  // namespace tallow
