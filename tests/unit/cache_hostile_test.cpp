// SPDX-License-Identifier: Apache-2.0
// Caches that want to harm: damaged at random, and crafted with checksums that are right.
#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "tests/support/test_cache.h"

namespace tallow {
namespace {

using Kind = SectionKind;

std::string valid_cache() {
    const auto file = test_out("valid.tallow");
    write_cache(file, TestCache().view);
    return read_bytes(file);
}

std::string error_of_bytes(const std::string& bytes) {
    const auto file = test_out("hostile.tallow");
    write_bytes(file, bytes);
    return cache_error(file);
}

TEST(CacheFuzz, EveryByteOfHeaderAndTableCounts) {
    const std::string valid = valid_cache();
    ASSERT_EQ(error_of_bytes(valid), "ok");
    const std::size_t end = CacheBytes(valid).table().size() * sizeof(SectionEntry) + 40;
    for (std::size_t i = 0; i < end; ++i) {
        std::string bytes = valid;
        bytes[i] ^= static_cast<char>(1u << (i % 8));
        EXPECT_NE(error_of_bytes(bytes), "ok") << "byte " << i;
    }
}

TEST(CacheFuzz, FlipsInSectionsAreDetected) {
    const std::string valid = valid_cache();
    CacheBytes layout(valid);
    std::mt19937 random(1);
    for (int i = 0; i < 2000; ++i) {
        const SectionEntry& entry = layout.table()[random() % layout.table().size()];
        const std::size_t at = entry.offset + random() % entry.length;
        std::string bytes = valid;
        bytes[at] ^= static_cast<char>(1u << random() % 8);
        EXPECT_NE(error_of_bytes(bytes).find(section_name(entry) + ": expected checksum"),
                  std::string::npos)
            << "byte " << at << ": " << error_of_bytes(bytes);
    }
}

TEST(CacheFuzz, TruncationsAreDetected) {
    const std::string valid = valid_cache();
    for (std::size_t size = 0; size < valid.size(); size += 7)
        EXPECT_NE(error_of_bytes(valid.substr(0, size)), "ok") << size;
    EXPECT_NE(error_of_bytes(valid + '\0'), "ok");
}

// With right checksums the mutations reach the code behind them. Allowed: success or InputError.
TEST(CacheFuzz, ResealedMutationsDoNoHarm) {
    const std::string valid = valid_cache();
    std::mt19937 random(2);
    int refused = 0;
    for (int i = 0; i < 2000; ++i) {
        std::string bytes = valid;
        const std::size_t from = 40 + random() % (bytes.size() - 40);
        const std::size_t to = 40 + random() % (bytes.size() - 40);
        if (i % 2 == 0)
            bytes[to] ^= static_cast<char>(1u << random() % 8);
        else  // a splice: some bytes copied to another place
            bytes.replace(to, std::min<std::size_t>(16, bytes.size() - to), valid, from,
                          std::min<std::size_t>(16, bytes.size() - to));
        bytes.resize(valid.size());
        CacheBytes cache(bytes);
        cache.reseal();
        refused += error_of_bytes(cache.bytes()) != "ok";
    }
    EXPECT_GT(refused, 500);  // measured 855: the mutations do reach the checks
}

/// What is said of a valid cache after `change`, with all checksums made right again.
std::string crafted_error(const std::function<void(CacheBytes&)>& change) {
    CacheBytes cache(valid_cache());
    change(cache);
    cache.reseal();
    std::string message = error_of_bytes(cache.bytes());
    const std::string hint = "; re-run tallow-precompute";
    EXPECT_TRUE(message.ends_with(hint)) << message;
    return message.substr(0, message.size() - std::min(message.size(), hint.size()));
}

TEST(CraftedTable, Placement) {
    EXPECT_EQ(crafted_error([](CacheBytes& c) { c.entry(Kind::areas).offset += 4; }),
              "section 'areas' of body 0: offset 1348 is no multiple of 64");
    EXPECT_EQ(crafted_error([](CacheBytes& c) { c.entry(Kind::areas).offset = 0; }),
              "section 'areas' of body 0: begins at byte 0, but what lies before it ends at 840");
    EXPECT_EQ(crafted_error([](CacheBytes& c) {
                  c.entry(Kind::areas).offset = c.entry(Kind::normals).offset;
              }),
              "section 'normals' of body 0: begins at byte 1216, but what lies before it ends at "
              "1256");
    // offset + length wraps around to a small number
    EXPECT_EQ(crafted_error([](CacheBytes& c) {
                  c.entry(Kind::areas).offset = 64;
                  c.entry(Kind::areas).length = 0xffffffffffffffff;
              }),
              "section 'areas' of body 0: 18446744073709551615 bytes at offset 64 reach beyond the "
              "end of the file, 2900 bytes");
    EXPECT_EQ(crafted_error([](CacheBytes& c) {
                  c.entry(Kind::areas).offset = 0xffffffffffffffc0;
                  c.entry(Kind::areas).length = 128;
              }),
              "section 'areas' of body 0: 128 bytes at offset 18446744073709551552 reach beyond "
              "the end of the file, 2900 bytes");
}

TEST(CraftedTable, Identity) {
    EXPECT_EQ(crafted_error([](CacheBytes& c) { c.entry(Kind::areas).kind = Kind(77); }),
              "section of unknown kind 77 of body 0");
    EXPECT_EQ(crafted_error([](CacheBytes& c) { c.entry(Kind::areas).kind = Kind::nodes; }),
              "section 'nodes' of body 0: is there twice");
    EXPECT_EQ(crafted_error([](CacheBytes& c) { c.entry(Kind::areas).body = 9; }),
              "section 'areas' of body 9: expected a body below 2");
    EXPECT_EQ(crafted_error([](CacheBytes& c) { c.entry(Kind::areas).group = 1; }),
              "section 'areas' of body 0: expected group 0, got 1");
    EXPECT_EQ(crafted_error([](CacheBytes& c) { c.entry(Kind::groups).body = 1; }),
              "section 'groups': expected body 0, got 1");
    EXPECT_EQ(crafted_error([](CacheBytes& c) { c.entry(Kind::areas).reserved = 1; }),
              "section 'areas' of body 0: expected reserved field 0, got 1");
    EXPECT_EQ(crafted_error([](CacheBytes& c) { c.entry(Kind::body, 1).body = 2; }),
              "section 'body' of body 2: expected a body below 2");
    EXPECT_EQ(
        crafted_error([](CacheBytes& c) { c.entry(Kind::directions_direct, 1, 1).group = 2; }),
        "section 'directions_direct' of body 1, group 2: expected a group below 2");
}

// The last entry of the table is taken away; its bytes stay as a gap.
TEST(CraftedTable, MissingSection) {
    EXPECT_EQ(crafted_error([](CacheBytes& c) { c.header().section_count -= 1; }),
              "section 'directions_direct' of body 1, group 1: is missing");
}

TEST(CraftedTable, LengthsAgainstCounts) {
    EXPECT_EQ(crafted_error([](CacheBytes& c) { c.entry(Kind::areas).length -= 4; }),
              "section 'areas' of body 0: expected 10 items of 4 bytes, got 36 bytes");
    EXPECT_EQ(crafted_error([](CacheBytes& c) { c.entry(Kind::areas).length -= 1; }),
              "section 'areas' of body 0: expected 10 items of 4 bytes, got 39 bytes");
    EXPECT_EQ(crafted_error([](CacheBytes& c) { c.entry(Kind::body).length = 0; }),
              "section 'body' of body 0: expected 1 items of 24 bytes, got 0 bytes");
    EXPECT_EQ(
        crafted_error([](CacheBytes& c) { c.item<BodyRecord>(Kind::body, 0).sample_count = ~0u; }),
        "section 'positions' of body 0: expected 4294967295 items of 12 bytes, got 120 "
        "bytes");
    EXPECT_EQ(
        crafted_error([](CacheBytes& c) { c.item<BodyRecord>(Kind::body, 0).node_count = ~0u; }),
        "section 'nodes' of body 0: expected 4294967295 items of 12 bytes, got 36 bytes");
}

TEST(CraftedText, Lines) {
    EXPECT_EQ(crafted_error([](CacheBytes& c) { c.item<char>(Kind::fingerprint, 7) = '-'; }),
              "section 'fingerprint': expected lines of the form key=value");
    EXPECT_EQ(crafted_error([](CacheBytes& c) { c.entry(Kind::groups).length -= 1; }),
              "section 'groups': the last line has no end");
    // One group more than there are sections for.
    EXPECT_EQ(crafted_error([](CacheBytes& c) { c.item<char>(Kind::groups, 1) = '\n'; }),
              "section 'irradiance_direct' of body 0, group 2: is missing");
}

TEST(CraftedBody, Record) {
    const auto record_error = [](const std::function<void(BodyRecord&)>& change) {
        return crafted_error([&](CacheBytes& c) { change(c.item<BodyRecord>(Kind::body, 0)); });
    };
    EXPECT_EQ(record_error([](BodyRecord& r) { r.spacing_mm = 0; }),
              "section 'body' of body 0: expected a spacing > 0, got 0 mm");
    EXPECT_EQ(record_error([](BodyRecord& r) { r.area_mm2 = INFINITY; }),
              "section 'body' of body 0: expected an area >= 0, got inf mm^2");
    EXPECT_EQ(record_error([](BodyRecord& r) { r.area_mm2 *= 1.001; }),
              "section 'areas' of body 0: sum to 8.125 mm^2, but the body has 8.133125 mm^2");
    EXPECT_EQ(record_error([](BodyRecord& r) { r.object = 2; }),
              "section 'body' of body 1: object 2 has a body already");
}

TEST(CraftedBody, Samples) {
    EXPECT_EQ(crafted_error([](CacheBytes& c) { c.item<Vec3>(Kind::positions, 3).y = NAN; }),
              "section 'positions' of body 0: sample 3: expected finite numbers, got (3, nan, 6)");
    EXPECT_EQ(crafted_error([](CacheBytes& c) { c.item<Vec3>(Kind::normals, 9).x = 0.61f; }),
              "section 'normals' of body 0: sample 9: expected a vector of length 1, got (0.61, 0, "
              "0.8)");
    EXPECT_EQ(crafted_error([](CacheBytes& c) { c.item<float>(Kind::areas, 0) = 0; }),
              "section 'areas' of body 0: sample 0: expected a number > 0, got 0");
    EXPECT_EQ(crafted_error([](CacheBytes& c) { c.item<float>(Kind::areas, 4, 1) = INFINITY; }),
              "section 'areas' of body 1: sample 4: expected a number > 0, got inf");
}

TEST(CraftedBody, Irradiance) {
    EXPECT_EQ(
        crafted_error([](CacheBytes& c) { c.item<Rgb>(Kind::irradiance_direct, 2, 1, 1).g = -1; }),
        "section 'irradiance_direct' of body 1, group 1: sample 2: expected finite numbers >= 0, "
        "got (2, -1, 8)");
    EXPECT_EQ(
        crafted_error([](CacheBytes& c) { c.item<Rgb>(Kind::irradiance_direct, 0).b = NAN; }),
        "section 'irradiance_direct' of body 0, group 0: sample 0: expected finite numbers >= 0, "
        "got (1, 2, nan)");
    EXPECT_EQ(
        crafted_error([](CacheBytes& c) { c.item<Vec3>(Kind::directions_direct, 1).x = 1; }),
        "section 'directions_direct' of body 0, group 0: sample 1: expected a vector of length <= "
        "1, got (1, 0.5, 0)");
}

/// What is said of a body of 10 samples with these nodes; without the section's name and the hint.
std::string tree_error(const std::vector<OctreeNode>& nodes) {
    BodyArrays body(10, 0);
    body.nodes = nodes;
    const auto file = test_out("tree.tallow");
    write_cache(file, CacheView{{}, {}, {body.view(0)}});
    std::string message = cache_error(file);
    for (const std::string& part :
         {std::string("section 'nodes' of body 0: "), std::string("; re-run tallow-precompute")})
        if (const auto at = message.find(part); at != std::string::npos)
            message.erase(at, part.size());
    return message;
}

TEST(CraftedTree, ValidShapes) {
    EXPECT_EQ(tree_error({{0, 10, 1}}), "ok");
    EXPECT_EQ(tree_error({{0, 10, 5}, {0, 6, 3}, {0, 5, 1}, {5, 1, 1}, {6, 4, 1}}), "ok");
}

TEST(CraftedTree, Root) {
    EXPECT_EQ(tree_error({}), "section 'body' of body 0: 10 samples, but 0 nodes");
    EXPECT_EQ(tree_error({{0, 9, 1}}),
              "node 0: expected a root over 10 samples and 1 nodes, got samples [0, +9) and 1 "
              "nodes");
    EXPECT_EQ(tree_error({{0, 10, 1}, {0, 10, 1}}),
              "node 0: expected a root over 10 samples and 2 nodes, got samples [0, +10) and 1 "
              "nodes");
}

TEST(CraftedTree, Skips) {
    EXPECT_EQ(tree_error({{0, 10, 3}, {0, 5, 0}, {5, 5, 1}}),
              "node 1: skips 0 nodes, but its parent's subtree has 2 left");
    EXPECT_EQ(tree_error({{0, 10, 3}, {0, 5, 1}, {5, 5, 0xffffffff}}),
              "node 2: skips 4294967295 nodes, but its parent's subtree has 1 left");
    // Node 3 reaches beyond the end of node 1, its parent.
    EXPECT_EQ(tree_error({{0, 10, 5}, {0, 5, 3}, {0, 2, 1}, {2, 3, 2}, {5, 5, 1}}),
              "node 3: skips 2 nodes, but its parent's subtree has 1 left");
}

TEST(CraftedTree, SampleRanges) {
    EXPECT_EQ(tree_error({{0, 10, 3}, {0, 5, 1}, {4, 6, 1}}),
              "node 2: begins at sample 4, expected 5");
    EXPECT_EQ(tree_error({{0, 10, 3}, {0, 5, 1}, {5, 6, 1}}),
              "node 2: owns 6 samples, but its parent has 5 left");
    EXPECT_EQ(tree_error({{0, 10, 3}, {0, 5, 1}, {5, 0, 1}}),
              "node 2: owns 0 samples, but its parent has 5 left");
    EXPECT_EQ(tree_error({{0, 10, 3}, {0, 5, 1}, {5, 4, 1}}),
              "node 0: 1 of its samples belong to none of its children");
    EXPECT_EQ(tree_error({{0, 10, 3}, {0, 5, 1}, {5, 0xffffffff, 1}}),
              "node 2: owns 4294967295 samples, but its parent has 5 left");
}

// A chain of only children: each level costs 12 bytes, so depth must not cost stack.
TEST(CraftedTree, Depth) {
    const auto chain = [](std::uint32_t levels) {
        std::vector<OctreeNode> nodes;
        for (std::uint32_t i = 0; i < levels; ++i) nodes.push_back({0, 10, levels - i});
        return nodes;
    };
    EXPECT_EQ(tree_error(chain(65)), "ok");
    EXPECT_EQ(tree_error(chain(100000)), "node 64: an inner node below 64 others");
}

}  // namespace
}  // namespace tallow
