// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/cloud/cache_io.h"
#include "common/cloud/section_table.h"

namespace tallow {

/// Inner nodes on the way from the root to a leaf at most. Chosen: any tree over Morton codes of
/// kMortonBits bits an axis is less than half as deep.
inline constexpr int kMaxTreeDepth = 64;

/// Checks what the sections of body `index` hold, once their lengths are known to be right:
/// numbers finite and in their domain, normals unit, areas that sum to the body's, and a tree
/// whose every node owns the samples of its children. Throws InputError.
void check_body(const SectionTable& table, std::uint32_t index, const BodyView& body);

}  // namespace tallow
