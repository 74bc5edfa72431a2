// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "material/describe_material.h"

namespace tallow {

/// The report as aligned tables for people, with units.
std::string material_text(const std::string& title, const MaterialReport& report);

}  // namespace tallow
