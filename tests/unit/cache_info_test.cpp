// SPDX-License-Identifier: Apache-2.0
// What people are shown of a cache.
#include "common/cloud/cache_info.h"

#include <gtest/gtest.h>

#include "tests/support/test_cache.h"

namespace tallow {
namespace {

TEST(CacheInfo, DescribesEveryBody) {
    const TestCache test;
    write_cache(test_out("described.tallow"), test.view);
    const MappedCache cache(test_out("described.tallow"));
    EXPECT_EQ(describe_cache(cache),
              "file size     2900 bytes\n"
              "format        version 2\n"
              "fingerprint   " +
                  fingerprint_id(test.view.fingerprint) +
                  "\n"
                  "  objects = 3\n"
                  "  objects[1].eta = 1.5\n"
                  "  sampling.light_samples = 16\n"
                  "groups        2\n"
                  "  'key'\n"
                  "  'fill light'\n"
                  "body 0\n"
                  "  object      1\n"
                  "  samples     10\n"
                  "  nodes       3\n"
                  "  spacing     0.125 mm\n"
                  "  area        8.125 mm^2\n"
                  "  area sum    8.125 mm^2 (+0.0e+00 of the area)\n"
                  "  bounds      (0, 0, 0) to (9, 4.5, 9) mm\n"
                  "  mean E_t    1 2 4 W/mm^2 of group 'key'\n"
                  "  mean E_t    2 4 8 W/mm^2 of group 'fill light'\n"
                  "body 1\n"
                  "  object      2\n"
                  "  samples     7\n"
                  "  nodes       3\n"
                  "  spacing     0.125 mm\n"
                  "  area        4.375 mm^2\n"
                  "  area sum    4.375 mm^2 (+0.0e+00 of the area)\n"
                  "  bounds      (0, 0, 3) to (6, 3, 9) mm\n"
                  "  mean E_t    1 2 4 W/mm^2 of group 'key'\n"
                  "  mean E_t    2 4 8 W/mm^2 of group 'fill light'\n");
}

// The mean weighs samples by their area: 10 samples with areas 0.25, 0.375, ..., 1.375.
TEST(CacheInfo, MeanIsOverTheSurface) {
    TestCache test;
    for (Rgb& E : test.first.E_t[0]) E = Rgb(0);
    test.first.E_t[0][9] = Rgb(1);
    write_cache(test_out("mean.tallow"), test.view);
    // 1.375 / 8.125; the plain mean would be 0.1
    EXPECT_NE(describe_cache(MappedCache(test_out("mean.tallow")))
                  .find("mean E_t    0.169231 0.169231 0.169231 W/mm^2 of group 'key'"),
              std::string::npos);
}

constexpr std::size_t kVertexSize = 10 * 4 + 3 + 4;  // floats, colour, body

/// The value at a byte of a file, which need not be aligned.
template <class T>
T value_at(const std::string& bytes, std::size_t at) {
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

TEST(ExportPly, HoldsAllSamplesOfAllBodies) {
    const TestCache test;
    export_ply(test_out("points.ply"), test.view);
    const std::string bytes = read_bytes(test_out("points.ply"));
    const std::string end = "property int body\nend_header\n";
    const std::size_t start = bytes.find(end) + end.size();
    EXPECT_EQ(bytes.find("ply\nformat binary_little_endian 1.0\n"), 0u);
    EXPECT_NE(bytes.find("element vertex 17\n"), std::string::npos);
    ASSERT_EQ(bytes.size() - start, 17 * kVertexSize);
    for (std::size_t i = 0; i < 17; ++i) {
        const BodyArrays& body = i < 10 ? test.first : test.second;
        const std::size_t sample = i < 10 ? i : i - 10, at = start + i * kVertexSize;
        EXPECT_EQ(value_at<Vec3>(bytes, at), body.positions[sample]);
        EXPECT_EQ(value_at<Vec3>(bytes, at + 12), body.normals[sample]);
        EXPECT_EQ(value_at<float>(bytes, at + 24), body.areas[sample]);
        EXPECT_EQ(value_at<Rgb>(bytes, at + 28), Rgb(3, 6, 12));  // of both groups
        // White is the 99th percentile of the largest channel, 12: sRGB of 1/4, 1/2 and 1.
        EXPECT_EQ(bytes.substr(at + 40, 3), "\x89\xbc\xff");
        EXPECT_EQ(value_at<std::int32_t>(bytes, at + 43), i < 10 ? 0 : 1);
    }
}

TEST(ExportPly, NoLightIsBlack) {
    TestCache test;
    for (BodyArrays* body : {&test.first, &test.second})
        for (auto& group : body->E_t) std::fill(group.begin(), group.end(), Rgb(0));
    export_ply(test_out("dark.ply"), test.view);
    const std::string bytes = read_bytes(test_out("dark.ply"));
    EXPECT_EQ(bytes.substr(bytes.size() - 7, 3), std::string(3, '\0'));
}

}  // namespace
}  // namespace tallow
