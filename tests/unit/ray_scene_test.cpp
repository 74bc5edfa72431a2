// SPDX-License-Identifier: Apache-2.0
#include "common/geometry/ray_scene.h"

#include <gtest/gtest.h>

#include "tests/support/count_threads.h"

namespace tallow {
namespace {

// Embree shares the scheduler: a scene must neither take threads away nor bring some back.
TEST(RayScene, LeavesTheNumberOfThreadsAlone) {
    const std::vector<Surface> surfaces = {SphereSurface{}, cube_mesh({})};
    for (int threads : {1, 2}) {
        const auto expected = std::size_t(threads);
        const ThreadLimit limit(threads);
        {
            const RayScene rays(surfaces);
            EXPECT_EQ(allowed_threads(), threads);
            EXPECT_EQ(threads_in_a_loop(expected), expected);
        }
        EXPECT_EQ(allowed_threads(), threads);
        EXPECT_EQ(threads_in_a_loop(expected), expected);
    }
}

TEST(RayScene, LeavesTheThreadsOfAnUnlimitedProcess) {
    const std::vector<Surface> surfaces = {SphereSurface{}};
    const int before = allowed_threads();
    const RayScene rays(surfaces);
    EXPECT_EQ(allowed_threads(), before);
}

}  // namespace
}  // namespace tallow
