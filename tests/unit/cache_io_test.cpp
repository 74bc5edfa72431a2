// SPDX-License-Identifier: Apache-2.0
// Cache files: what goes in comes out, files that are none or of another kind, fingerprints.
#include "common/cloud/cache_io.h"

#include <gtest/gtest.h>

#include "common/cloud/fingerprint_text.h"
#include "tests/support/test_cache.h"

namespace tallow {
namespace {

template <class T>
void expect_same(std::span<const T> a, std::span<const T> b) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i], b[i]) << i;
}

void expect_same_body(const BodyView& a, const BodyView& b) {
    EXPECT_EQ(a.object, b.object);
    EXPECT_EQ(a.spacing_mm, b.spacing_mm);
    EXPECT_EQ(a.area_mm2, b.area_mm2);
    expect_same(a.positions, b.positions);
    expect_same(a.normals, b.normals);
    expect_same(a.areas, b.areas);
    expect_same(a.nodes, b.nodes);
    ASSERT_EQ(a.groups.size(), b.groups.size());
    for (std::size_t group = 0; group < a.groups.size(); ++group) {
        expect_same(a.groups[group].E_t, b.groups[group].E_t);
        expect_same(a.groups[group].w_i, b.groups[group].w_i);
    }
    ASSERT_EQ(a.indirect.size(), b.indirect.size());
    for (std::size_t group = 0; group < a.indirect.size(); ++group) {
        expect_same(a.indirect[group].E_t, b.indirect[group].E_t);
        expect_same(a.indirect[group].w_i, b.indirect[group].w_i);
    }
}

TEST(Cache, RoundTrip) {
    const TestCache test;
    write_cache(test_out("round_trip.tallow"), test.view);
    const MappedCache mapped(test_out("round_trip.tallow"));
    EXPECT_EQ(mapped.file_size(), std::filesystem::file_size(test_out("round_trip.tallow")));
    EXPECT_EQ(mapped.view().fingerprint, test.view.fingerprint);
    EXPECT_EQ(mapped.view().groups, test.view.groups);
    ASSERT_EQ(mapped.view().bodies.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i)
        expect_same_body(mapped.view().bodies[i], test.view.bodies[i]);
    EXPECT_FALSE(std::filesystem::exists(test_out("round_trip.tallow.tmp")));
}

TEST(Cache, RoundTripWithIndirectLight) {
    TestCache test;
    const BodyArrays first(10, 3), second(7, 3);
    for (std::uint32_t group : {2u, 0u}) {  // other light than the direct one, which is of 0 and 1
        test.view.bodies[0].indirect.push_back({first.E_t[group], first.w_i[group]});
        test.view.bodies[1].indirect.push_back({second.E_t[group], second.w_i[group]});
    }
    write_cache(test_out("indirect.tallow"), test.view);
    const MappedCache mapped(test_out("indirect.tallow"));
    ASSERT_EQ(mapped.view().bodies.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i)
        expect_same_body(mapped.view().bodies[i], test.view.bodies[i]);
}

TEST(Cache, ViewOutlivesAMove) {
    const TestCache test;
    write_cache(test_out("moved.tallow"), test.view);
    MappedCache first(test_out("moved.tallow"));
    const MappedCache second(std::move(first));
    expect_same_body(second.view().bodies[1], test.view.bodies[1]);
}

TEST(Cache, NothingIsAValidCache) {
    write_cache(test_out("nothing.tallow"), CacheView{});
    EXPECT_TRUE(MappedCache(test_out("nothing.tallow")).view().bodies.empty());
}

TEST(Cache, BodyWithoutSamples) {
    CacheView view{{}, {"key"}, {BodyView{0, 1, 0, {}, {}, {}, {}, {{}}}}};
    write_cache(test_out("no_samples.tallow"), view);
    const MappedCache mapped(test_out("no_samples.tallow"));
    EXPECT_TRUE(mapped.view().bodies[0].positions.empty());
}

TEST(Cache, WritesTheSameBytesTwice) {
    const TestCache test;
    write_cache(test_out("once.tallow"), test.view);
    write_cache(test_out("twice.tallow"), test.view);
    EXPECT_EQ(read_bytes(test_out("once.tallow")), read_bytes(test_out("twice.tallow")));
}

TEST(Cache, FailedWriteKeepsTheOldFile) {
    write_bytes(test_out("kept.tallow"), "old");
    std::filesystem::create_directories(test_out("kept.tallow.tmp"));
    EXPECT_THROW(write_cache(test_out("kept.tallow"), TestCache().view), OutputError);
    EXPECT_EQ(read_bytes(test_out("kept.tallow")), "old");
}

TEST(Cache, ArraysOfDifferentLengthsAreOurBug) {
    TestCache test;
    test.view.bodies[0].normals = test.view.bodies[0].normals.first(3);
    EXPECT_THROW(write_cache(test_out("bug.tallow"), test.view), std::logic_error);
}

TEST(CacheFile, RefusesWhatIsNoCache) {
    EXPECT_EQ(cache_error(test_out("missing.tallow")), "cannot open: No such file or directory");
    EXPECT_EQ(cache_error(test_out("")), "cannot read: Is a directory");
    write_bytes(test_out("empty.tallow"), "");
    EXPECT_EQ(cache_error(test_out("empty.tallow")), "is empty; re-run tallow-precompute");
    write_bytes(test_out("scene.tallow"), "unit: mm\n");
    EXPECT_EQ(cache_error(test_out("scene.tallow")),
              "not a tallow cache: does not begin with TALLOW");
    write_bytes(test_out("short.tallow"), std::string(kCacheMagic, 8) + "123");
    EXPECT_EQ(cache_error(test_out("short.tallow")),
              "cut short: 11 bytes, the header alone has 40; re-run tallow-precompute");
}

/// A valid file whose header `change` has tampered with.
std::string header_error(const std::function<void(FileHeader&)>& change) {
    const auto file = test_out("header.tallow");
    write_cache(file, TestCache().view);
    CacheBytes bytes(read_bytes(file));
    change(bytes.header());
    write_bytes(file, bytes.bytes());
    return cache_error(file);
}

TEST(CacheFile, RefusesOtherHeaders) {
    EXPECT_EQ(header_error([](FileHeader& h) { h.version = 3; }),
              "format version 3, but this program reads version 2; re-run tallow-precompute");
    EXPECT_EQ(header_error([](FileHeader& h) { h.byte_order_mark = 0x04030201; }),
              "written on a machine of the other byte order; re-run tallow-precompute");
    EXPECT_EQ(header_error([](FileHeader& h) { h.byte_order_mark = 7; }),
              "header: expected byte-order mark 0x01020304, got 0x00000007; "
              "re-run tallow-precompute");
    EXPECT_EQ(header_error([](FileHeader& h) { h.file_size = 99; }).substr(0, 35),
              "header: expected a file of 99 bytes");
    EXPECT_EQ(header_error([](FileHeader& h) { h.section_count = 0xffffffff; }).substr(0, 27),
              "header: 4294967295 sections");
    EXPECT_EQ(header_error([](FileHeader& h) { h.section_count -= 1; }).substr(0, 32),
              "section table: expected checksum");
    EXPECT_EQ(header_error([](FileHeader& h) { h.reserved = 1; }),
              "header: expected reserved field 0, got 1; re-run tallow-precompute");
}

std::string fingerprint_error(const Fingerprint& cache, const Fingerprint& scene) {
    try {
        require_fingerprint("x.tallow", cache, scene);
        return "ok";
    } catch (const InputError& e) {
        return e.what();
    }
}

TEST(FingerprintText, MismatchNamesBothValues) {
    const Fingerprint cache{{"objects", "1"}, {"objects[0].eta", "1.5"}};
    EXPECT_EQ(fingerprint_error(cache, cache), "ok");
    EXPECT_EQ(fingerprint_error(cache, {{"objects", "1"}, {"objects[0].eta", "1.3"}}),
              "x.tallow: made from objects[0].eta = 1.5, but the scene has 1.3; "
              "re-run tallow-precompute");
    EXPECT_EQ(fingerprint_error(cache, {{"objects", "1"}}),
              "x.tallow: made from objects[0].eta = 1.5, but the scene has nothing; "
              "re-run tallow-precompute");
    EXPECT_EQ(fingerprint_error({{"objects", "1"}}, cache),
              "x.tallow: made from objects[0].eta = nothing, but the scene has 1.5; "
              "re-run tallow-precompute");
}

TEST(FingerprintText, SamplingIsNotCompared) {
    EXPECT_EQ(fingerprint_error({{"sampling.light_samples", "16"}, {"a", "b"}},
                                {{"a", "b"}, {"sampling.light_samples", "64"}}),
              "ok");
}

TEST(FingerprintText, LongValuesAreShortenedAroundTheDifference) {
    const std::string same(200, 'a');
    EXPECT_EQ(fingerprint_error({{"k", same + "X"}}, {{"k", same + "Y"}}),
              "x.tallow: made from k = ..." + std::string(119, 'a') + "X, but the scene has ..." +
                  std::string(119, 'a') + "Y; re-run tallow-precompute");
    EXPECT_EQ(fingerprint_error({{"k", std::string(120, 'X')}}, {{"k", ""}}),
              "x.tallow: made from k = " + std::string(120, 'X') +
                  ", but the scene has ; re-run tallow-precompute");
}

TEST(FingerprintText, IsAFunctionOfAllPairs) {
    const Fingerprint base{{"a", "1"}, {"b", "2"}};
    EXPECT_EQ(encode_fingerprint(base), "a=1\nb=2\n");
    EXPECT_EQ(decode_fingerprint("a=1\nb=2\n"), base);
    EXPECT_EQ(decode_fingerprint("a=1\nb=2"), std::nullopt);
    EXPECT_EQ(decode_fingerprint("a\n"), std::nullopt);
    EXPECT_THROW(encode_fingerprint({{"a=", "1"}}), std::logic_error);
    EXPECT_THROW(encode_fingerprint({{"a", "1\n"}}), std::logic_error);

    EXPECT_EQ(fingerprint_id(base).size(), 16u);
    EXPECT_EQ(fingerprint_id(base), fingerprint_id(base));
    EXPECT_NE(fingerprint_id(base), fingerprint_id({{"a", "1"}, {"b", "3"}}));
    EXPECT_EQ(fingerprint_id({}), "2d06800538d394c2");  // XXH3 of nothing, from its specification
}

}  // namespace
}  // namespace tallow
