// SPDX-License-Identifier: Apache-2.0
// Fragments of a mesh -> clusters. Fragments are sorted by cube and direction; each such group is
// small enough for one task's cache.
#include "precompute/cluster_fragments.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "common/base/parallel.h"
#include "common/base/rng.h"
#include "common/cloud/morton.h"

namespace tallow {
namespace {

// Side of the cubes in spacings. Chosen: patches end at the cubes' sides, so that half of it makes
// more ragged clusters; twice of it makes halving slower.
constexpr double kCubeSide = 8;

// Longest extent of a cluster's centres in spacings; with fragments of up to 1.5 around them.
constexpr float kLongestCluster = 1.5f;

// Patches below this fraction of spacing^2 are joined.
constexpr double kScrap = 0.125;

// A fragment faces the same way as its cluster within 40 degrees; this share of a cluster's area
// may not. Chosen: the faces of a right-angled edge are 45 degrees from their mean.
constexpr float kSameWay = 0.7660444f;
constexpr double kTolerated = 0.01;

// The side of a cube that a normal points through.
std::uint64_t dominant_side(Vec3 n) {
    const Vec3 a = glm::abs(n);
    const int axis = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
    return std::uint64_t(2 * axis + (n[axis] < 0));
}

/// Cube in which a cell lies. 20 bits an axis: cubes a million apart share a number, which costs
/// nothing, for their fragments are not connected. The cubes' corners keep away from the origin,
/// where bodies often have their middle.
std::uint64_t cube_of(const Cell& cell, float spacing) {
    constexpr double kShift = 0.381966;
    std::uint64_t cube = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double x = double(cell.center[axis]) / (kCubeSide * double(spacing)) + kShift;
        cube = cube << 20 | (std::uint64_t(std::int64_t(std::floor(x))) & 0xfffff);
    }
    return cube;
}

/// Patches of the fragments of one group: sets of those that share vertices.
class Connections {
public:
    /// Patch of each fragment, numbered from 0 in the order of their first fragments.
    std::vector<std::uint32_t> find(const TriangleMesh& mesh, std::span<const Fragment> fragments) {
        parent_.resize(fragments.size());
        std::iota(parent_.begin(), parent_.end(), 0u);
        slots_.assign(std::bit_ceil(4 * fragments.size()), {kNone, 0});
        for (std::uint32_t i = 0; i < fragments.size(); ++i)
            for (const std::uint32_t vertex : mesh.triangles[fragments[i].triangle]) {
                Slot& slot = slot_of(vertex);
                if (slot.vertex == kNone)
                    slot = {vertex, i};
                else
                    unite(slot.fragment, i);
            }
        std::vector<std::uint32_t> patch(fragments.size());
        std::uint32_t count = 0;  // a root comes before all others of its set
        for (std::uint32_t i = 0; i < patch.size(); ++i)
            patch[i] = parent_[i] == i ? count++ : patch[root(i)];
        return patch;
    }

private:
    static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

    struct Slot {
        std::uint32_t vertex;
        std::uint32_t fragment;  // one at the vertex
    };

    Slot& slot_of(std::uint32_t vertex) {
        std::size_t s = mix_bits(vertex) & (slots_.size() - 1);
        while (slots_[s].vertex != kNone && slots_[s].vertex != vertex)
            s = (s + 1) & (slots_.size() - 1);
        return slots_[s];
    }

    std::uint32_t root(std::uint32_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }

    void unite(std::uint32_t a, std::uint32_t b) {
        a = root(a), b = root(b);
        parent_[std::max(a, b)] = std::min(a, b);
    }

    std::vector<std::uint32_t> parent_;  // [fragment]
    std::vector<Slot> slots_;
};

using Members = std::span<Fragment>;

double total_area(Members members) {
    double area = 0;
    for (const Fragment& f : members) area += double(f.cell.area);
    return area;
}

/// Parts sets of fragments until each is a cluster.
class Halving {
public:
    Halving(float spacing, std::vector<Cluster>& clusters)
        : longest_(kLongestCluster * spacing), clusters_(clusters) {}

    /// Makes `count` clusters, or more if they would be too long, or fewer if there are not as many
    /// fragments.
    void cluster(Members members, double area, std::size_t count) {
        count = std::min(count, members.size());
        Vec3 low(kInfinity), high(-kInfinity);
        for (const Fragment& f : members) {
            low = glm::min(low, f.cell.center);
            high = glm::max(high, f.cell.center);
        }
        const Vec3 extent = high - low;
        const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0
                         : extent.y >= extent.z                       ? 1
                                                                      : 2;
        if (count <= 1 && (members.size() == 1 || extent[axis] <= longest_))
            return part_by_direction(members);
        const std::size_t first = std::max<std::size_t>(1, count / 2);
        const double share = count >= 2 ? double(first) / double(count) : 0.5;
        const std::size_t cut = part(members, axis, low[axis], extent[axis], share * area);
        const double area_below = total_area(members.first(cut));
        const auto below = std::size_t(std::lround(double(count) * area_below / area));
        const std::size_t most = std::max<std::size_t>(count, 2) - 1;
        const std::size_t count_below = std::clamp<std::size_t>(below, 1, most);
        cluster(members.first(cut), area_below, count_below);
        cluster(members.subspan(cut), area - area_below,
                count > count_below ? count - count_below : 1);
    }

private:
    // Up to here fragments are sorted; beyond, dealt into kBins bins along the axis.
    static constexpr std::size_t kFewMembers = 48;
    static constexpr int kBins = 64;

    /// Reorders members along an axis so that about `area` comes before the returned place; at
    /// least one on either side.
    static std::size_t part(Members members, int axis, float low, float extent, double area) {
        std::size_t cut = 0;
        if (members.size() > kFewMembers && extent > 0)
            cut = part_by_bins(members, axis, low, extent, area);
        return cut > 0 ? cut : part_sorted(members, axis, area);
    }

    static std::size_t part_sorted(Members members, int axis, double area) {
        std::ranges::sort(members, [axis](const Fragment& a, const Fragment& b) {
            const float x = a.cell.center[axis], y = b.cell.center[axis];
            return x != y                       ? x < y
                   : a.cell.area != b.cell.area ? a.cell.area < b.cell.area
                                                : a.triangle < b.triangle;
        });
        double below = members[0].cell.area;
        std::size_t cut = 1;
        while (cut + 1 < members.size() && below + double(members[cut].cell.area) / 2 < area)
            below += double(members[cut++].cell.area);
        return cut;
    }

    /// 0 if all are in one bin.
    static std::size_t part_by_bins(Members members, int axis, float low, float extent,
                                    double area) {
        const float scale = kBins / extent;
        const auto bin = [&](const Fragment& f) {
            return std::min(kBins - 1, int((f.cell.center[axis] - low) * scale));
        };
        std::array<double, kBins> in_bin{};
        for (const Fragment& f : members) in_bin[std::size_t(bin(f))] += double(f.cell.area);
        double below = in_bin[0];
        int last = 0;  // bin before the cut
        while (last + 2 < kBins && below + in_bin[std::size_t(last) + 1] / 2 < area)
            below += in_bin[std::size_t(++last)];
        const auto middle = std::partition(members.begin(), members.end(),
                                           [&](const Fragment& f) { return bin(f) <= last; });
        const auto cut = std::size_t(middle - members.begin());
        return cut < members.size() ? cut : 0;
    }

    void part_by_direction(Members members) {
        const Vec3 mean = mean_normal(members);
        double away = 0, area = 0;
        for (const Fragment& f : members) {
            area += double(f.cell.area);
            if (glm::dot(f.cell.normal, mean) < kSameWay) away += double(f.cell.area);
        }
        if (away <= kTolerated * area) return emit(members, area);
        // Towards the fragment farthest from the mean, or towards the one farthest from that.
        const Vec3 one = farthest(members, mean), other = farthest(members, one);
        const auto middle = std::partition(members.begin(), members.end(), [&](const Fragment& f) {
            return glm::dot(f.cell.normal, one) > glm::dot(f.cell.normal, other);
        });
        const auto cut = std::size_t(middle - members.begin());
        if (cut == 0 || cut == members.size()) return emit(members, area);
        part_by_direction(members.first(cut));
        part_by_direction(members.subspan(cut));
    }

    static Vec3 mean_normal(Members members) {
        DVec3 sum(0);
        for (const Fragment& f : members) sum += double(f.cell.area) * DVec3(f.cell.normal);
        return glm::length(sum) > 0 ? Vec3(glm::normalize(sum)) : members[0].cell.normal;
    }

    static Vec3 farthest(Members members, Vec3 n) {
        return std::ranges::min_element(
                   members, {}, [n](const Fragment& f) { return glm::dot(f.cell.normal, n); })
            ->cell.normal;
    }

    void emit(Members members, double area) {
        DVec3 center(0);
        for (const Fragment& f : members) center += double(f.cell.area) * DVec3(f.cell.center);
        center = area > 0 ? center / area : DVec3(members[0].cell.center);
        const Fragment& nearest = *std::ranges::min_element(
            members, {}, [&](const Fragment& f) { return length2(f.cell.center - Vec3(center)); });
        clusters_.push_back(
            {{Vec3(center), mean_normal(members), float(area)}, nearest.cell.center});
    }

    float longest_;
    std::vector<Cluster>& clusters_;
};

/// Clusters the fragments of one cube and direction.
class GroupClusterer {
public:
    GroupClusterer(const TriangleMesh& mesh, float spacing) : mesh_(mesh), spacing_(spacing) {}

    void cluster(std::vector<Fragment>& fragments, std::uint64_t key,
                 std::vector<Cluster>& clusters) {
        sort_by_patch(fragments);
        Halving halving(spacing_, clusters);
        const double h2 = double(spacing_) * spacing_;
        for (std::size_t k = 0; k + 1 < first_.size(); ++k) {
            const Members members =
                Members(fragments).subspan(first_[k], first_[k + 1] - first_[k]);
            if (members.empty()) continue;
            const double area = total_area(members);
            const double u = to_unit_float(random_bits(0, key, k));
            halving.cluster(members, area, std::max<std::size_t>(1, std::size_t(area / h2 + u)));
        }
    }

private:
    /// Brings patches together, the scraps first; first_[patch], and the end of all.
    void sort_by_patch(std::vector<Fragment>& fragments) {
        std::vector<std::uint32_t> patch = connections_.find(mesh_, fragments);
        std::vector<double> area(*std::ranges::max_element(patch) + 1u, 0);
        for (std::size_t i = 0; i < patch.size(); ++i)
            area[patch[i]] += double(fragments[i].cell.area);
        std::vector<std::size_t> place(area.size());  // [patch] 0 for a scrap
        std::size_t places = 1;
        const double scrap = kScrap * double(spacing_) * spacing_;
        for (std::size_t k = 0; k < area.size(); ++k) place[k] = area[k] < scrap ? 0 : places++;
        first_.assign(places + 1, 0);
        for (const std::uint32_t p : patch) ++first_[place[p] + 1];
        for (std::size_t k = 1; k < first_.size(); ++k) first_[k] += first_[k - 1];
        std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
        std::vector<Fragment> sorted(fragments.size());
        for (std::size_t i = 0; i < patch.size(); ++i)
            sorted[next[place[patch[i]]]++] = fragments[i];
        fragments = std::move(sorted);
    }

    const TriangleMesh& mesh_;
    float spacing_;
    Connections connections_;
    std::vector<std::size_t> first_;
};

/// Places in `order` where the key changes, and the end.
std::vector<std::size_t> group_begins(std::span<const std::uint64_t> keys,
                                      std::span<const std::uint32_t> order) {
    std::vector<std::size_t> begins;
    for (std::size_t i = 0; i < order.size(); ++i)
        if (i == 0 || keys[order[i]] != keys[order[i - 1]]) begins.push_back(i);
    begins.push_back(order.size());
    return begins;
}

}  // namespace

std::vector<Cluster> cluster_fragments(const TriangleMesh& mesh, const MeshPieces& pieces,
                                       float spacing) {
    if (pieces.fragments() == 0) return {};
    std::vector<std::uint64_t> keys(pieces.fragments());
    parallel_for(keys.size(), 4096, [&](std::size_t i) {
        const Cell cell = pieces.fragment(mesh, i).cell;
        keys[i] = cube_of(cell, spacing) << 3 | dominant_side(cell.normal);
    });
    const std::vector<std::uint32_t> order = sorted_order(keys);
    const std::vector<std::size_t> begins = group_begins(keys, order);

    // Groups for one task, with some ten thousand fragments.
    constexpr std::size_t kTask = 1 << 14;
    std::vector<std::size_t> first_group = {0};
    for (std::size_t g = 0; g + 1 < begins.size(); ++g)
        if (begins[g + 1] - begins[first_group.back()] >= kTask) first_group.push_back(g + 1);
    if (first_group.back() + 1 < begins.size()) first_group.push_back(begins.size() - 1);
    const std::size_t tasks = first_group.size() - 1;
    std::vector<std::vector<Cluster>> clusters(tasks);
    parallel_for(tasks, 1, [&](std::size_t task) {
        GroupClusterer clusterer(mesh, spacing);
        std::vector<Fragment> fragments;
        for (std::size_t g = first_group[task]; g < first_group[task + 1]; ++g) {
            fragments.clear();
            for (std::size_t i = begins[g]; i < begins[g + 1]; ++i)
                fragments.push_back(pieces.fragment(mesh, order[i]));
            clusterer.cluster(fragments, keys[order[begins[g]]], clusters[task]);
        }
    });
    std::vector<Cluster> all;
    for (const std::vector<Cluster>& some : clusters)
        all.insert(all.end(), some.begin(), some.end());
    return all;
}

bool CubeSubset::contains(const Cell& cell) const {
    return every == 1 || mix_bits(cube_of(cell, spacing)) % every == 0;
}

}  // namespace tallow
