// SPDX-License-Identifier: Apache-2.0
// Runs the hard cases; with --table=FILE also writes what they measured as Markdown.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <vector>

#include "tests/hard_cases/hard_cases.h"

namespace tallow::test {
namespace {

struct Row {
    std::string name, reference;
    double error, bound;
};
std::vector<Row> rows;

void write_table(const std::string& file) {
    std::ofstream out(file);
    out << "# Numerics\n\n"
           "What happens at the edges of what a user can ask for: relative errors (absolute where "
           "the\n"
           "expected value is 0), measured and stated. `./run numerics` makes this page; `./run "
           "test`\n"
           "holds every row to its bound.\n\n"
           "| case | expected, from | measured | bound |\n|---|---|---|---|\n";
    for (const Row& row : rows)
        out << fmt::format("| {} | {} | {:.1e} | {:.0e} |\n", row.name, row.reference, row.error,
                           row.bound);
}

}  // namespace

void expect_within(const std::string& name, const std::string& reference, double error,
                   double bound) {
    rows.push_back({name, reference, error, bound});
    EXPECT_LE(error, bound) << name;
}

}  // namespace tallow::test

int main(int argc, char** argv) {
    testing::InitGoogleTest(&argc, argv);
    const int failed = RUN_ALL_TESTS();
    const std::string flag = "--table=";
    for (int i = 1; i < argc; ++i)
        if (std::string(argv[i]).starts_with(flag))
            tallow::test::write_table(std::string(argv[i]).substr(flag.size()));
    return failed;
}
