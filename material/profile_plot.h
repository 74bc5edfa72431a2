// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "common/optics/medium.h"

namespace tallow {

/// SVG picture of the profiles R(r) of all models: a panel a channel, both axes logarithmic, the
/// legend with total reflectances. Distances span from 1/50 of the shortest mean free path of a
/// channel to 20 of the longest, rounded to decades; eight decades of R.
std::string profile_plot(const std::string& title, const Medium& medium);

}  // namespace tallow
