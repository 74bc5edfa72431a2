// SPDX-License-Identifier: Apache-2.0
// The errors that KernelTable states against its function at random places: what it measured at a
// few places a segment, within the margin that certificates allow for.
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>

#include "tests/property/exact_table.h"
#include "tests/property/intensity.h"
#include "tests/property/random_sums.h"

namespace tallow {
namespace {

using test::Draw;

constexpr std::uint64_t kTables = 100;
constexpr int kPlaces = 2000;    // some ten a segment
constexpr double kMargin = 1.5;  // as in point_sum.cpp

// In the segments, where most of the light is, and up to ten times as far as the table reaches.
double draw_place(Draw& draw, const KernelTable::View& view, double range) {
    if (draw.one_in(4)) return range * draw.log_uniform(0.1, 100);
    const auto segment = double(view.first_index) + draw.uniform() * double(view.size);
    const auto start = std::uint32_t(segment);
    const double low = std::bit_cast<float>(start << view.shift),
                 high = std::bit_cast<float>((start + 1) << view.shift);
    return std::max(0.0, low + (segment - start) * (high - low) - double(view.offset));
}

TEST(KernelTable, ErrorsAreAtMostAsStated) {
    const auto tables = std::uint64_t(std::ceil(double(kTables) * test::intensity()));
    double worst = 0;
    for (std::uint64_t seed = 0; seed < tables && !HasFailure(); ++seed) {
        Draw draw(seed + 1000000);
        const test::RandomKernel kernel = test::draw_kernel(draw, 1);
        const KernelTable table = kernel.table(KernelTable::unit_near(kernel.scale));
        const test::ExactTable ours(table.view());
        const double area = table.unit() * table.unit();
        for (int i = 0; i < kPlaces; ++i) {
            const double u = draw_place(draw, table.view(), table.range() / area);
            const double exact = kernel.exact(u * area);
            const double error = std::abs(ours(u) / area - exact);
            const double stated =
                table.max_relative_error() * std::abs(exact) + table.max_error_beyond();
            ASSERT_LE(error, kMargin * stated)
                << "seed " << seed << ' ' << kernel.name << " u " << u;
            if (stated > 0) worst = std::max(worst, error / stated);
        }
    }
    std::cout << fmt::format("error / stated error at most {:.3f}\n", worst);
}

}  // namespace
}  // namespace tallow
