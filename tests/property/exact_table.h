// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>

#include "common/nbody/kernel_table.h"

namespace tallow::test {

/// The table without rounding; all in its units.
class ExactTable {
public:
    explicit ExactTable(const KernelTable::View& view) : view_(view) {}

    double operator()(double u) const {
        const double v = u + double(view_.offset);
        const double end = start_of(view_.size);
        if (v >= end) return 0;
        // Rounding to float may reach the next segment's start.
        std::uint32_t i = index_of(float(v));
        if (start_of(i) > v) --i;
        const double x = v - start_of(i);
        const KernelTable::Segment& s = view_.segments[i];
        return s.c0 + x * (s.c1 + x * (s.c2 + x * double(s.c3)));
    }

private:
    std::uint32_t index_of(float v) const {
        return std::min((std::bit_cast<std::uint32_t>(v) >> view_.shift) - view_.first_index,
                        view_.size);
    }
    double start_of(std::uint32_t segment) const {
        return std::bit_cast<float>((view_.first_index + segment) << view_.shift);
    }
    KernelTable::View view_;
};

}  // namespace tallow::test
