// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "common/optics/medium.h"

namespace tallow {

/// A parameter that a row of swatches varies.
enum class Knob {
    sigma_a,        ///< mean of the channels, 1/mm; the channels keep their ratios
    sigma_s_prime,  ///< the same
    eta,
    g,        ///< at fixed sigma_s', so that single scattering alone changes
    dilution  ///< share of an undiluted liquid, see diluted()
};

/// KEY=A..B of --vary: from A to B, in equal ratios for coefficients and dilution, in equal steps
/// for eta and g.
struct Variation {
    Knob knob;
    std::string key;
    double from, to;
};

/// Throws UsageError.
Variation parse_variation(const std::string& text);

/// `steps` values from one end to the other, both included; `from` alone for one step.
std::vector<double> variation_values(const Variation& variation, int steps);

/// The medium with the parameter set to `value`. A coefficient that is zero in every channel
/// becomes grey.
Medium vary_medium(const Medium& medium, Knob knob, double value);

}  // namespace tallow
