// SPDX-License-Identifier: Apache-2.0
// Samples -> tree of patches with moments. Down to the fine patches level by level, all patches of
// a level at once; below them each by itself, without looking at normals.
#include "common/diffusion/patch_tree.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "common/base/parallel.h"

namespace tallow {
namespace {

// Normals of a patch differ by at most so much in any of x, y, z. Chosen: patches do not reach
// around edges, and a smooth surface of many patches is not cut for its curvature.
constexpr float kMostNormalExtent = 0.8f;

// Patches of so few samples are not halved any more.
constexpr std::uint32_t kLeafSamples = 4;

struct Extent {
    int axis;
    float length, middle;
};

/// Orders the samples of patches so that their halves lie side by side.
class Splitter {
public:
    Splitter(const SampledSurface& samples, std::vector<std::uint32_t>& order)
        : samples_(samples), order_(order) {}

    double area(const SurfacePatch& patch) const {
        double sum = 0;
        for (std::uint32_t i = patch.begin; i < patch.end; ++i)
            sum += double(samples_.area[order_[i]]);
        return sum;
    }
    Extent normals(const SurfacePatch& patch) const { return widest(patch, samples_.normal); }

    /// Where the second half begins.
    std::uint32_t halve(const SurfacePatch& patch) const {
        const int axis = widest(patch, samples_.position).axis;
        const auto begin = order_.begin() + patch.begin, end = order_.begin() + patch.end;
        const auto middle = begin + (end - begin) / 2;
        std::nth_element(begin, middle, end, [&](std::uint32_t a, std::uint32_t b) {
            const float u = samples_.position[a][axis], v = samples_.position[b][axis];
            return u < v || (u == v && a < b);
        });
        return std::uint32_t(middle - order_.begin());
    }
    std::uint32_t part_normals(const SurfacePatch& patch, const Extent& extent) const {
        const auto middle = std::stable_partition(
            order_.begin() + patch.begin, order_.begin() + patch.end,
            [&](std::uint32_t i) { return samples_.normal[i][extent.axis] < extent.middle; });
        return std::uint32_t(middle - order_.begin());
    }

private:
    Extent widest(const SurfacePatch& patch, std::span<const Vec3> values) const {
        Vec3 low = values[order_[patch.begin]], high = low;
        for (std::uint32_t i = patch.begin; i < patch.end; ++i) {
            low = glm::min(low, values[order_[i]]);
            high = glm::max(high, values[order_[i]]);
        }
        const Vec3 size = high - low;
        int axis = size.x >= size.y ? 0 : 1;
        if (size.z > size[axis]) axis = 2;
        return {axis, size[axis], (low[axis] + high[axis]) / 2};
    }

    const SampledSurface& samples_;
    std::vector<std::uint32_t>& order_;
};

SurfacePatch range(std::uint32_t begin, std::uint32_t end) {
    SurfacePatch patch;
    patch.begin = begin, patch.end = end;
    return patch;
}

class Builder {
public:
    Builder(const SampledSurface& samples, double largest_area)
        : samples_(samples), largest_area_(largest_area), splitter_(samples, tree_.order) {
        tree_.order.resize(samples.size());
        std::iota(tree_.order.begin(), tree_.order.end(), 0u);
    }

    PatchTree build() {
        if (samples_.size() == 0) return std::move(tree_);
        tree_.patches.push_back(range(0, std::uint32_t(samples_.size())));
        for (std::size_t level = 0; level < tree_.patches.size();) {
            const std::size_t end = tree_.patches.size();
            split_level(level, end);
            level = end;
        }
        const std::size_t coarse = tree_.patches.size();
        for (std::uint32_t i = 0; i < coarse; ++i)
            if (tree_.patches[i].child == SurfacePatch::kNone) tree_.fine.push_back(i);
        std::ranges::sort(tree_.fine, {}, [&](std::uint32_t i) { return tree_.patches[i].begin; });
        split_fine();
        for (std::size_t i = coarse; i-- > 0;)
            if (SurfacePatch& patch = tree_.patches[i]; patch.child < coarse)
                join(patch, tree_.patches);
        tree_.area = 0;
        for (const std::uint32_t i : tree_.fine) tree_.area += double(tree_.patches[i].area);
        return std::move(tree_);
    }

private:
    void split_level(std::size_t begin, std::size_t end) {
        std::vector<std::uint32_t> cuts(end - begin);  // 0: none
        parallel_for(cuts.size(), 1,
                     [&](std::size_t i) { cuts[i] = cut(tree_.patches[begin + i]); });
        for (std::size_t i = 0; i < cuts.size(); ++i)
            if (cuts[i] > 0) add_halves(tree_.patches, begin + i, cuts[i]);
    }

    std::uint32_t cut(SurfacePatch& patch) const {
        const Extent normals = splitter_.normals(patch);
        const double area = splitter_.area(patch);
        patch.edge = normals.length > kMostNormalExtent && patch.end - patch.begin > 1;
        if (patch.end - patch.begin < 2 || (!patch.edge && area <= largest_area_)) return 0;
        // A large patch is halved in space first: most of what differs in it lies far apart.
        return patch.edge && area <= 2 * largest_area_ ? splitter_.part_normals(patch, normals)
                                                       : splitter_.halve(patch);
    }

    static void add_halves(std::vector<SurfacePatch>& patches, std::size_t parent,
                           std::uint32_t cut) {
        const std::uint32_t begin = patches[parent].begin, end = patches[parent].end;
        patches[parent].child = std::uint32_t(patches.size());
        patches.push_back(range(begin, cut));
        patches.push_back(range(cut, end));
    }

    // Patches within each fine one, put behind all others.
    void split_fine() {
        std::vector<std::vector<SurfacePatch>> within(tree_.fine.size());
        parallel_for(within.size(), 16, [&](std::size_t f) {
            std::vector<SurfacePatch>& patches = within[f];
            patches.push_back(tree_.patches[tree_.fine[f]]);
            for (std::size_t i = 0; i < patches.size(); ++i)
                if (patches[i].end - patches[i].begin > kLeafSamples)
                    add_halves(patches, i, splitter_.halve(patches[i]));
            for (std::size_t i = patches.size(); i-- > 0;)
                patches[i].child == SurfacePatch::kNone ? describe(patches[i])
                                                        : join(patches[i], patches);
        });
        for (std::size_t f = 0; f < within.size(); ++f) {
            // The first takes the place of the fine patch, the others move together.
            const auto offset = std::uint32_t(tree_.patches.size() - 1);
            for (SurfacePatch& patch : within[f])
                if (patch.child != SurfacePatch::kNone) patch.child += offset;
            tree_.patches[tree_.fine[f]] = within[f].front();
            tree_.patches.insert(tree_.patches.end(), within[f].begin() + 1, within[f].end());
        }
    }

    // Moments from the samples, whose cells are discs.
    void describe(SurfacePatch& patch) const {
        DVec3 centroid(0), vector_area(0);
        double area = 0;
        for (const std::uint32_t s : tree_.samples(patch)) {
            const double a = double(samples_.area[s]);
            area += a;
            centroid += a * DVec3(samples_.position[s]);
            vector_area += a * DVec3(samples_.normal[s]);
        }
        patch.area = float(area);
        patch.centroid = Vec3(centroid / area);
        patch.vector_area = Vec3(vector_area);
        for (const std::uint32_t s : tree_.samples(patch)) {
            const float a = samples_.area[s];
            const Vec3 n = samples_.normal[s], d = samples_.position[s] - patch.centroid;
            const float cell = a * a / (4 * std::numbers::pi_v<float>);
            const Symmetric identity{cell, cell, cell};
            patch.second += a * symmetric_product(d, d);
            patch.second += identity;
            patch.second += -cell * symmetric_product(n, n);
            patch.vector_first += a * symmetric_product(n, d);
        }
        set_radius(patch);
    }

    static void join(SurfacePatch& patch, const std::vector<SurfacePatch>& patches) {
        const SurfacePatch parts[] = {patches[patch.child], patches[patch.child + 1]};
        patch.area = parts[0].area + parts[1].area;
        patch.vector_area = parts[0].vector_area + parts[1].vector_area;
        patch.centroid =
            (parts[0].area * parts[0].centroid + parts[1].area * parts[1].centroid) / patch.area;
        for (const SurfacePatch& part : parts) {
            const Vec3 d = part.centroid - patch.centroid;
            patch.second += part.second;
            patch.second += part.area * symmetric_product(d, d);
            patch.vector_first += part.vector_first;
            patch.vector_first += symmetric_product(part.vector_area, d);
        }
        set_radius(patch);
    }

    static void set_radius(SurfacePatch& patch) {
        patch.radius = std::sqrt(2 * patch.second.trace() / patch.area);
    }

    const SampledSurface& samples_;
    double largest_area_;
    PatchTree tree_;
    Splitter splitter_;
};

}  // namespace

PatchTree build_patch_tree(const SampledSurface& samples, double largest_area) {
    return Builder(samples, largest_area).build();
}

}  // namespace tallow
