// SPDX-License-Identifier: Apache-2.0
// Points -> Morton codes; keys -> their order. A radix sort, least significant digit first, of the
// leading bits in which keys differ, as many as share a word with the key's index. Hardly any keys
// agree in all of them; those that do are then sorted among themselves.
#include "common/cloud/morton.h"

#include <algorithm>
#include <array>
#include <bit>
#include <memory>
#include <utility>

#include "common/base/check.h"
#include "common/base/parallel.h"

namespace tallow {
namespace {

// Points or keys that one task takes. Fewer than that are done without waking another thread.
constexpr std::size_t kChunk = 1 << 16;

std::size_t chunks(std::size_t n) { return (n + kChunk - 1) / kChunk; }

/// Calls body(chunk, begin, end) for all chunks of n things.
template <class Body>
void for_chunks(std::size_t n, const Body& body) {
    parallel_for(chunks(n), 1, [&](std::size_t chunk) {
        body(chunk, chunk * kChunk, std::min((chunk + 1) * kChunk, n));
    });
}

struct Box {
    Vec3 low{kInfinity}, high{-kInfinity};

    void add(const Box& other) {
        low = glm::min(low, other.low);
        high = glm::max(high, other.high);
    }
};

Box bounds(std::span<const Vec3> points) {
    std::vector<Box> boxes(chunks(points.size()));
    for_chunks(points.size(), [&](std::size_t chunk, std::size_t begin, std::size_t end) {
        Box box;
        for (Vec3 p : points.subspan(begin, end - begin)) box.add({p, p});
        boxes[chunk] = box;
    });
    Box all;
    for (const Box& box : boxes) all.add(box);
    return all;
}

// Spreads the low 21 bits of x so that two zero bits follow each.
std::uint64_t spread_bits(std::uint64_t x) {
    x &= 0x1fffff;
    x = (x | x << 32) & 0x001f00000000ffffull;
    x = (x | x << 16) & 0x001f0000ff0000ffull;
    x = (x | x << 8) & 0x100f00f00f00f00full;
    x = (x | x << 4) & 0x10c30c30c30c30c3ull;
    x = (x | x << 2) & 0x1249249249249249ull;
    return x;
}

/// A key on its way to its place: as many of its bits as fit above its index. Comparing items
/// compares these bits, and indices where they agree.
using Item = std::uint64_t;

struct Packing {
    int index_bits;

    int key_bits() const { return 64 - index_bits; }
    Item item(std::uint64_t key, std::size_t index) const { return key << index_bits | index; }
    std::uint64_t key(Item item) const { return item >> index_bits; }
    std::uint32_t index(Item item) const {
        return std::uint32_t(item & ((std::uint64_t{1} << index_bits) - 1));
    }
};

// Measured: a million keys take the same from 8 to 12, 60 000 keys of 30 bits least with 11.
constexpr int kDigitBits = 11;
constexpr std::size_t kDigits = 1 << kDigitBits;

// Runs up to this length are sorted by comparison. Chosen: below, a radix sort would spend its time
// on its kDigits counters.
constexpr std::size_t kShortRun = 512;

/// Moves items from `source` to `target`, stably, by the digit at `shift`; false if they all share
/// that digit, and stay.
bool move_by_digit(std::span<const Item> source, std::span<Item> target, int shift) {
    using Counters = std::array<std::uint32_t, kDigits>;
    const auto digit = [shift](Item item) { return item >> shift & (kDigits - 1); };
    std::vector<Counters> place(chunks(source.size()), Counters{});  // [chunk][digit]
    for_chunks(source.size(), [&](std::size_t chunk, std::size_t begin, std::size_t end) {
        Counters count{};
        for (std::size_t i = begin; i < end; ++i) ++count[digit(source[i])];
        place[chunk] = count;
    });
    std::uint32_t sum = 0;
    for (std::size_t d = 0; d < kDigits; ++d) {
        const std::uint32_t before = sum;
        for (Counters& counters : place) sum += std::exchange(counters[d], sum);
        if (sum - before == source.size()) return false;
    }
    for_chunks(source.size(), [&](std::size_t chunk, std::size_t begin, std::size_t end) {
        Counters next = place[chunk];
        for (std::size_t i = begin; i < end; ++i) target[next[digit(source[i])]++] = source[i];
    });
    return true;
}

/// Sorts items, given in the order of their indices, whose keys differ in the lowest `key_bits`.
void sort_items(std::span<Item> items, Packing packing, int key_bits) {
    if (items.size() <= kShortRun) {
        std::sort(items.begin(), items.end());
        return;
    }
    const auto memory = std::make_unique_for_overwrite<Item[]>(items.size());
    std::span<Item> source = items, target(memory.get(), items.size());
    for (int bit = 0; bit < key_bits; bit += kDigitBits)
        if (move_by_digit(source, target, packing.index_bits + bit)) std::swap(source, target);
    if (source.data() != items.data()) std::copy(source.begin(), source.end(), items.begin());
}

/// First item after `i` and before `last` whose bits differ from the one before, or `last`.
std::size_t run_end(std::span<const Item> items, Packing packing, std::size_t i, std::size_t last) {
    do ++i;
    while (i < last && packing.key(items[i]) == packing.key(items[i - 1]));
    return i;
}

/// Sorts each run of items that agree in their bits by the lower bits of their keys.
void sort_runs(std::span<Item> items, Packing packing, std::span<const std::uint64_t> keys,
               int low_bits) {
    std::vector<std::size_t> part = {0};  // chunks, each extended to the end of a run
    while (part.back() < items.size())
        part.push_back(run_end(items, packing, std::min(part.back() + kChunk, items.size()) - 1,
                               items.size()));
    parallel_for(part.size() - 1, 1, [&](std::size_t k) {
        for (std::size_t begin = part[k]; begin < part[k + 1];) {
            const std::size_t end = run_end(items, packing, begin, part[k + 1]);
            if (end - begin > 1) {
                const std::span<Item> run = items.subspan(begin, end - begin);
                for (Item& item : run)
                    item = packing.item(keys[packing.index(item)], packing.index(item));
                sort_items(run, packing, low_bits);
            }
            begin = end;
        }
    });
}

/// The bits in which not all keys agree.
std::uint64_t differing_bits(std::span<const std::uint64_t> keys) {
    std::vector<std::uint64_t> differing(chunks(keys.size()), 0);
    for_chunks(keys.size(), [&](std::size_t chunk, std::size_t begin, std::size_t end) {
        std::uint64_t bits = 0;
        for (std::size_t i = begin; i < end; ++i) bits |= keys[i] ^ keys[0];
        differing[chunk] = bits;
    });
    std::uint64_t all = 0;
    for (std::uint64_t bits : differing) all |= bits;
    return all;
}

}  // namespace

std::vector<std::uint64_t> morton_codes(std::span<const Vec3> points, int bits) {
    TALLOW_CHECK(bits >= 1 && bits <= kMortonBits, "{} bits", bits);
    const Box box = bounds(points);
    const Vec3 extent = box.high - box.low;
    const double side = std::max({extent.x, extent.y, extent.z, 1e-30f});
    const std::int64_t cells = std::int64_t{1} << bits;
    const double scale = double(cells) / side;

    std::vector<std::uint64_t> codes(points.size());
    parallel_for(points.size(), 4096, [&](std::size_t i) {
        std::uint64_t code = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const double x = (double(points[i][axis]) - box.low[axis]) * scale;
            const std::int64_t cell = std::min(cells - 1, std::int64_t(x));
            code |= spread_bits(std::uint64_t(cell)) << (2 - axis);
        }
        codes[i] = code;
    });
    return codes;
}

std::vector<std::uint32_t> sorted_order(std::span<const std::uint64_t> keys) {
    TALLOW_CHECK(keys.size() <= 0xffffffffu, "{} keys", keys.size());
    const Packing packing{std::max(1, int(std::bit_width(keys.size())))};
    const int width = int(std::bit_width(differing_bits(keys)));
    const int low_bits = std::max(0, width - packing.key_bits());
    const auto memory = std::make_unique_for_overwrite<Item[]>(keys.size());
    const std::span<Item> items(memory.get(), keys.size());
    for_chunks(keys.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) items[i] = packing.item(keys[i] >> low_bits, i);
    });
    sort_items(items, packing, width - low_bits);
    if (low_bits > 0) sort_runs(items, packing, keys, low_bits);

    std::vector<std::uint32_t> order(keys.size());
    for_chunks(keys.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) order[i] = packing.index(items[i]);
    });
    return order;
}

}  // namespace tallow
