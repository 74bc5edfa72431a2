// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/rgb.h"
#include "common/optics/medium.h"

namespace tallow {

/// A measured medium of data/materials.yaml.
struct Preset {
    std::string name;                        // lower case: "marble", "lowfat-milk"
    Medium medium;                           // of a dilutable liquid: undiluted
    std::optional<Rgb> printed_reflectance;  // diffuse reflectance as the source prints it, linear
    std::string source;                      // key of docs/REFERENCES.md
    bool dilutable = false;                  // whether diluted() makes sense
};

/// All presets, sorted by name. The table is compiled into the library, so that programs need no
/// data folder.
const std::vector<Preset>& presets();

/// Null if there is none of this name.
const Preset* find_preset(const std::string& name);

/// Names of all presets, or of those that can be diluted, sorted.
std::vector<std::string> preset_names();
std::vector<std::string> dilutable_preset_names();

/// A liquid mixed with clear water.
///
///     sigma_a -> share sigma_a,   sigma_s' -> share sigma_s'
///
/// Domain   0 < share <= 1, the liquid's share of the mixture; 1 is the undiluted liquid. The
///          water's own absorption (below 1e-3 1/mm) and the change of eta are neglected.
/// Source   [NGD06]: coefficients are proportional to concentration.
Medium diluted(Medium medium, float share);

}  // namespace tallow
