// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "common/optics/transport_table.h"

namespace tallow {

/// The transport table of a half-space of index `eta` by `walks` random walks, a multiple of
/// kWalkBatches; the standard errors are those of the mean over the batches.
///
/// What was still inside after the last order goes into the tail bin. Diffusion says where it will
/// leave: light of order n >> 1 leaves at r with density e^(-3 r^2 / 4n), in an amount that goes as
/// n^(-3/2), so that the part beyond r is sqrt(pi / 4x) erf(sqrt(x)), x = 3 r^2 / (4 last order).
TransportTable walk_half_space(double eta, std::int64_t walks, std::uint64_t seed);

inline constexpr std::int64_t kWalkBatches = 64;

}  // namespace tallow
