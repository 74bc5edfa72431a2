// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/optics/diffusion.h"
#include "common/optics/profile.h"
#include "common/optics/transport_table.h"

namespace tallow {

/// Moves the entries of a table, each in proportion to its variance, so that they sum to 1: without
/// absorption all light comes back. Of all corrections this is the most likely one, and it removes
/// most of the error of totals near alpha' = 1.
void conserve_energy(TransportTable& table);

/// The tables of data/transport/half_space.txt, sorted by eta, with energy conserved; the file is
/// compiled into the library.
const std::vector<TransportTable>& transport_tables();

/// A number by random walks with its standard error.
struct Estimate {
    double value = 0, error = 0;
};

/// Weights of the tables for an index between theirs; they sum to 1, so that energy is conserved. A
/// polynomial in 1 / eta through the four nearest on the same side of 1, where total internal
/// reflection begins and nothing is smooth.
std::vector<double> interpolation_weights(const std::vector<double>& etas, double eta);

/// Light of the orders >= 2 that leaves each ring of TransportGrid, as a part of what entered, for
/// the albedo and the index of `channel`: the sum over orders of alpha'^n times the table. Within
/// the wide bins orders are weighted as n^(-3/2), as light that diffuses out of a half-space is.
///
///
/// Error    standard errors are those before conserve_energy(). Sums take the entries for
///          independent; walks that survive roulette are not, so that without absorption the error
///          of a total is up to 1.4 times what is stated (measured). Interpolation over eta: see
///          TransportTable.InterpolatesBetweenIndices.
/// Throws   InputError if the index is outside of the table, [0.7, 3].
std::array<Estimate, TransportGrid::kRings> transport_rings(const ReducedChannel& channel);

/// Total reflectance of the half-space. The first order is exact: single_scattering_reflectance().
Estimate transport_reflectance(const ReducedChannel& channel, Orders orders);

}  // namespace tallow
