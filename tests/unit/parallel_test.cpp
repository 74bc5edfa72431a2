// SPDX-License-Identifier: Apache-2.0
#include "common/base/parallel.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

#include "tests/support/count_threads.h"

namespace tallow {
namespace {

TEST(Parallel, EachIndexIsVisitedOnce) {
    std::vector<int> visits(10007, 0);
    parallel_for(visits.size(), 16, [&](std::size_t i) { ++visits[i]; });
    for (int count : visits) ASSERT_EQ(count, 1);
    parallel_for(0, 1, [](std::size_t) { FAIL(); });
}

TEST(Parallel, ExceptionsReachTheCaller) {
    const auto fail_at_70 = [] {
        parallel_for(100, 1, [](std::size_t i) {
            if (i == 70) throw std::runtime_error("seventy");
        });
    };
    EXPECT_THROW(fail_at_70(), std::runtime_error);
    const ThreadLimit two(2);
    EXPECT_THROW(fail_at_70(), std::runtime_error);
}

TEST(ThreadLimit, IsTheNumberOfThreadsInALoop) {
    for (int threads : {1, 2, 5}) {  // five: more than some machines have cores
        const ThreadLimit limit(threads);
        EXPECT_EQ(limit.threads(), threads);
        EXPECT_EQ(allowed_threads(), threads);
        EXPECT_EQ(threads_in_a_loop(std::size_t(threads)), std::size_t(threads));
    }
}

TEST(ThreadLimit, EndsWithItsScope) {
    const int before = allowed_threads();
    {
        const ThreadLimit one(1);
        EXPECT_EQ(allowed_threads(), 1);
    }
    EXPECT_EQ(allowed_threads(), before);
}

TEST(ThreadLimit, TheSmallestOfNestedOnesHolds) {
    const ThreadLimit outer(2);
    {
        const ThreadLimit inner(1);
        const ThreadLimit innermost(3);
        EXPECT_EQ(allowed_threads(), 1);
        EXPECT_EQ(threads_in_a_loop(1), 1u);
    }
    EXPECT_EQ(threads_in_a_loop(2), 2u);
}

TEST(ThreadLimit, HoldsInALoopWithinALoop) {
    const ThreadLimit two(2);
    parallel_for(2, 1, [](std::size_t) { EXPECT_LE(threads_in_a_loop(1), 2u); });
}

}  // namespace
}  // namespace tallow
