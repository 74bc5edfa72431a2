// SPDX-License-Identifier: Apache-2.0
// The content of one body of a cache: every number and the structure of its tree, so that nobody
// who uses a mapped cache need ask again. Linear in the size of the body, whatever it holds; the
// numbers on all threads.
#include "common/cloud/check_body.h"

#include <fmt/format.h>

#include <array>
#include <atomic>
#include <cmath>
#include <numeric>

#include "common/base/parallel.h"

namespace tallow {
namespace {

constexpr std::size_t kChunk = 1 << 14;  // samples that one thread checks at a time

// Chosen: rounding of unit vectors in float is 1e-7, of a sum of a million areas 1e-5 at worst.
constexpr float kLengthTolerance = 1e-3f;
constexpr double kAreaTolerance = 1e-4;

constexpr float square(float x) { return x * x; }

// Predicates of first_bad(): function objects, because the compiler inlines and vectorizes those.
constexpr auto is_unit = [](Vec3 v) {
    const float l2 = length2(v);
    return l2 >= square(1 - kLengthTolerance) && l2 <= square(1 + kLengthTolerance);
};
constexpr auto is_at_most_unit = [](Vec3 v) { return length2(v) <= square(1 + kLengthTolerance); };
constexpr auto is_position = [](Vec3 v) { return is_finite(v); };
constexpr auto is_positive = [](float x) { return x > 0 && x < kInfinity; };
constexpr auto is_radiometric = [](Rgb c) { return min_channel(c) >= 0 && is_finite(c); };

/// Index of the first item that is not good, or their number. `good` is cheap and has no branch
/// worth a prediction: whole chunks are checked before one is searched.
template <class T, class Good>
std::size_t first_bad(std::span<const T> items, Good&& good) {
    std::atomic<std::size_t> first{items.size()};
    parallel_ranges(items.size(), kChunk, [&](std::size_t begin, std::size_t end) {
        bool all_good = true;
        for (std::size_t i = begin; i < end; ++i) all_good &= good(items[i]);
        if (all_good) return;
        while (good(items[begin])) ++begin;
        std::size_t known = first;
        while (begin < known && !first.compare_exchange_weak(known, begin)) {
        }
    });
    return first;
}

/// Sum in double, the same for any number of threads.
double sum(std::span<const float> values) {
    std::vector<double> chunks((values.size() + kChunk - 1) / kChunk);
    parallel_for(chunks.size(), 1, [&](std::size_t i) {
        const auto chunk = values.subspan(i * kChunk, std::min(kChunk, values.size() - i * kChunk));
        chunks[i] = std::accumulate(chunk.begin(), chunk.end(), 0.0);
    });
    return std::accumulate(chunks.begin(), chunks.end(), 0.0);
}

std::string describe(Vec3 v) { return fmt::format("({}, {}, {})", v.x, v.y, v.z); }

/// Refuses the first sample that is not good. `show(i)` tells what it is.
template <class T, class Good, class Show>
void require_all(const SectionTable& table, const SectionEntry& entry, std::span<const T> items,
                 Good&& good, const char* expected, Show&& show) {
    const std::size_t i = first_bad(items, good);
    if (i < items.size())
        table.fail(entry,
                   fmt::format("sample {}: expected {}, got {}", i, expected, show(items[i])));
}

void check_record(const SectionTable& table, const SectionEntry& entry, const BodyView& body) {
    if (!is_positive(body.spacing_mm))
        table.fail(entry, fmt::format("expected a spacing > 0, got {} mm", body.spacing_mm));
    if (!(body.area_mm2 >= 0 && std::isfinite(body.area_mm2)))
        table.fail(entry, fmt::format("expected an area >= 0, got {} mm^2", body.area_mm2));
    if (body.positions.empty() != body.nodes.empty())
        table.fail(entry, fmt::format("{} samples, but {} nodes", body.positions.size(),
                                      body.nodes.size()));
}

void check_samples(const SectionTable& table, std::uint32_t index, const BodyView& body) {
    require_all(
        table, table.find(SectionKind::positions, index), body.positions,
        [](Vec3 p) { return is_finite(p); }, "finite numbers", describe);
    require_all(table, table.find(SectionKind::normals, index), body.normals, is_unit,
                "a vector of length 1", describe);
    const SectionEntry& areas = table.find(SectionKind::areas, index);
    require_all(table, areas, body.areas, is_positive, "a number > 0",
                [](float a) { return fmt::format("{}", a); });
    const double total = sum(body.areas);
    if (!(std::abs(total - body.area_mm2) <= kAreaTolerance * body.area_mm2))
        table.fail(areas,
                   fmt::format("sum to {} mm^2, but the body has {} mm^2", total, body.area_mm2));
}

void check_irradiance(const SectionTable& table, std::uint32_t index, const BodyView& body) {
    const auto check = [&](const std::vector<GroupIrradianceView>& groups, SectionKind irradiance,
                           SectionKind directions) {
        for (std::uint32_t group = 0; group < groups.size(); ++group) {
            require_all(table, table.find(irradiance, index, group), groups[group].E_t,
                        is_radiometric, "finite numbers >= 0", [](Rgb c) {
                            return describe({c.r, c.g, c.b});
                        });
            require_all(table, table.find(directions, index, group), groups[group].w_i,
                        is_at_most_unit, "a vector of length <= 1", describe);
        }
    };
    check(body.groups, SectionKind::irradiance_direct, SectionKind::directions_direct);
    check(body.indirect, SectionKind::irradiance_indirect, SectionKind::directions_indirect);
}

/// Walks a tree in the order in which it is stored, with the chain of parents of the node at hand
/// on a stack of fixed size: no recursion, each node visited once.
class TreeChecker {
public:
    TreeChecker(const SectionTable& table, const SectionEntry& entry,
                std::span<const OctreeNode> nodes, std::size_t samples)
        : table_(table), entry_(entry), nodes_(nodes), samples_(samples) {}

    void check() {
        const OctreeNode& root = nodes_[0];
        if (root.first != 0 || root.count != samples_ || root.skip != nodes_.size())
            fail(0, fmt::format("expected a root over {} samples and {} nodes, got samples "
                                "[{}, +{}) and {} nodes",
                                samples_, nodes_.size(), root.first, root.count, root.skip));
        open(0, root);
        for (std::size_t i = 1; i < nodes_.size(); ++i) {
            close_until(i);
            enter(i);
        }
        close_until(nodes_.size());
    }

private:
    /// A node whose children are being visited.
    struct Parent {
        std::size_t node, end;                  // its subtree is nodes [node, end)
        std::uint64_t next_sample, end_sample;  // samples that its further children must own
    };

    void enter(std::size_t i) {
        const OctreeNode& node = nodes_[i];
        Parent& parent = parents_[depth_ - 1];
        if (node.skip == 0 || node.skip > parent.end - i)
            fail(i, fmt::format("skips {} nodes, but its parent's subtree has {} left", node.skip,
                                parent.end - i));
        if (node.first != parent.next_sample)
            fail(i,
                 fmt::format("begins at sample {}, expected {}", node.first, parent.next_sample));
        if (node.count == 0 || node.count > parent.end_sample - parent.next_sample)
            fail(i, fmt::format("owns {} samples, but its parent has {} left", node.count,
                                parent.end_sample - parent.next_sample));
        parent.next_sample += node.count;
        open(i, node);
    }

    void open(std::size_t i, const OctreeNode& node) {
        if (node.skip == 1) return;  // a leaf
        if (depth_ == kMaxTreeDepth)
            fail(i, fmt::format("an inner node below {} others", kMaxTreeDepth));
        parents_[depth_++] = {i, i + node.skip, node.first, std::uint64_t{node.first} + node.count};
    }

    void close_until(std::size_t i) {
        for (; depth_ > 0 && parents_[depth_ - 1].end == i; --depth_) {
            const Parent& parent = parents_[depth_ - 1];
            if (parent.next_sample != parent.end_sample)
                fail(parent.node, fmt::format("{} of its samples belong to none of its children",
                                              parent.end_sample - parent.next_sample));
        }
    }

    [[noreturn]] void fail(std::size_t node, const std::string& what) const {
        table_.fail(entry_, fmt::format("node {}: {}", node, what));
    }

    const SectionTable& table_;
    const SectionEntry& entry_;
    std::span<const OctreeNode> nodes_;
    std::size_t samples_;
    std::array<Parent, kMaxTreeDepth> parents_;
    int depth_ = 0;
};

}  // namespace

void check_body(const SectionTable& table, std::uint32_t index, const BodyView& body) {
    check_record(table, table.find(SectionKind::body, index), body);
    check_samples(table, index, body);
    check_irradiance(table, index, body);
    if (!body.nodes.empty())
        TreeChecker(table, table.find(SectionKind::nodes, index), body.nodes, body.positions.size())
            .check();
}

}  // namespace tallow
