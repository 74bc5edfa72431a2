// SPDX-License-Identifier: Apache-2.0
// Triangles -> cells of about spacing^2 and smaller fragments. Cuts go from the middle, or another
// fraction, of the longest edge to the opposite corner, so that slivers become well-shaped.
#include "precompute/triangle_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "common/base/parallel.h"

namespace tallow {
namespace {

// Longest edge of a cell in spacings. Chosen as that of a right-angled triangle of area sqrt(2).
constexpr float kLongestEdge = 2.3784142f;  // 2^(5/4)

// Longest edge of a fragment in spacings. Chosen: shorter ones cost time where triangles are long
// and thin, longer ones stick out of the clusters.
constexpr float kLongestFragment = 1.5f;

// Triangles that one task takes, and pieces of a triangle beyond which it becomes several tasks.
// Fixed, so that the order of pieces does not depend on the number of threads.
constexpr std::size_t kBlock = 4096;

struct Corner {
    Vec3 position;
    Vec3 normal;
};

Corner between(const Corner& a, const Corner& b, float t) {
    return {a.position + t * (b.position - a.position), a.normal + t * (b.normal - a.normal)};
}

/// A triangle, or a part of one, that is to make `pieces` cells; with 0, only fragments.
struct Piece {
    std::array<Corner, 3> corner;
    double area;
    std::uint64_t pieces;
    std::uint32_t triangle;

    /// Turned so that the edge from the first corner to the second is the longest; its squared
    /// length.
    float turn_to_longest() {
        const auto edge2 = [&](std::size_t i) {
            return length2(corner[(i + 1) % 3].position - corner[i].position);
        };
        const float e[3] = {edge2(0), edge2(1), edge2(2)};
        const float longest = std::max({e[0], e[1], e[2]});
        const std::size_t first = longest == e[0] ? 0 : longest == e[1] ? 1 : 2;
        corner = {corner[first], corner[(first + 1) % 3], corner[(first + 2) % 3]};
        return longest;
    }

    /// Cut from the third corner to the edge between the others, into parts whose areas are to each
    /// other as their numbers of pieces.
    std::array<Piece, 2> cut() const {
        const std::uint64_t first = pieces / 2, second = pieces - first;
        const double share = pieces >= 2 ? double(first) / double(pieces) : 0.5;
        const Corner m = between(corner[0], corner[1], float(share));
        return {Piece{{corner[0], m, corner[2]}, share * area, pieces >= 2 ? first : 0, triangle},
                Piece{{m, corner[1], corner[2]},
                      area - share * area,
                      pieces >= 2 ? second : 0,
                      triangle}};
    }

    Cell cell() const {
        const auto& [a, b, c] = corner;
        return {(a.position + b.position + c.position) / 3.0f,
                glm::normalize(a.normal + b.normal + c.normal), float(area)};
    }
};

Piece whole_triangle(const TriangleMesh& mesh, std::size_t t) {
    Piece piece{{}, triangle_area(mesh, t), 0, std::uint32_t(t)};
    const Vec3 flat = mesh.corner_normals.empty() ? triangle_normal(mesh, t) : Vec3(0);
    for (std::size_t k = 0; k < 3; ++k)
        piece.corner[k] = {mesh.vertices[mesh.triangles[t][k]],
                           mesh.corner_normals.empty() ? flat : mesh.corner_normals[3 * t + k]};
    return piece;
}

/// Cuts pieces and hands them on: sink.cell(Piece), sink.whole(Piece), sink.part(Piece).
template <class Sink>
class Cutter {
public:
    Cutter(float spacing, Sink& sink) : spacing_(spacing), sink_(sink) {}

    void cut_triangle(const TriangleMesh& mesh, std::size_t t, std::vector<Piece>& large) {
        Piece piece = whole_triangle(mesh, t);
        const double cells = piece.area / (double(spacing_) * spacing_);
        if (cells >= 1) piece.pieces = std::uint64_t(cells + dither(t));
        if (piece.pieces > kBlock)
            large.push_back(piece);
        else if (piece.pieces == 0 && piece.turn_to_longest() <= limit2(kLongestFragment))
            sink_.whole(piece);
        else
            cut(piece);
    }

    void cut(Piece piece) {
        const float longest2 = piece.turn_to_longest();
        if (piece.pieces == 1 && longest2 <= limit2(kLongestEdge)) return sink_.cell(piece);
        if (piece.pieces == 0 && longest2 <= limit2(kLongestFragment)) return sink_.part(piece);
        const std::array<Piece, 2> halves = piece.cut();
        // Far from the origin floats may be too coarse for the spacing.
        const Vec3 middle = halves[0].corner[1].position;
        if (middle == piece.corner[0].position || middle == piece.corner[1].position)
            return sink_.part(piece);
        for (const Piece& half : halves) cut(half);
    }

private:
    float limit2(float edges) const { return edges * edges * spacing_ * spacing_; }

    float spacing_;
    Sink& sink_;
};

/// Cuts a mesh with one sink for each block of work, in an order that depends on the mesh only.
template <class Sink>
std::vector<Sink> cut_in_blocks(const TriangleMesh& mesh, float spacing, const Sink& empty) {
    const std::size_t blocks = (mesh.triangles.size() + kBlock - 1) / kBlock;
    std::vector<Sink> sinks(blocks, empty);
    std::vector<std::vector<Piece>> large(blocks);
    parallel_for(blocks, 1, [&](std::size_t block) {
        Cutter cutter(spacing, sinks[block]);
        const std::size_t end = std::min(mesh.triangles.size(), (block + 1) * kBlock);
        for (std::size_t t = block * kBlock; t < end; ++t)
            cutter.cut_triangle(mesh, t, large[block]);
    });

    std::vector<Piece> tasks;
    for (const std::vector<Piece>& some : large)
        tasks.insert(tasks.end(), some.begin(), some.end());
    for (std::size_t i = 0; i < tasks.size(); ++i)
        while (tasks[i].pieces > kBlock) {
            tasks[i].turn_to_longest();
            const std::array<Piece, 2> halves = tasks[i].cut();
            tasks[i] = halves[0];
            tasks.push_back(halves[1]);
        }
    sinks.resize(blocks + tasks.size(), empty);
    parallel_for(tasks.size(), 1,
                 [&](std::size_t i) { Cutter(spacing, sinks[blocks + i]).cut(tasks[i]); });
    return sinks;
}

struct KeepingSink {
    MeshPieces pieces;

    void cell(const Piece& piece) { pieces.cells.push_back(piece.cell()); }
    void whole(const Piece& piece) {
        pieces.whole.push_back(piece.triangle);
        pieces.fragment_area += piece.area;
    }
    void part(const Piece& piece) {
        pieces.parts.push_back({piece.cell(), piece.triangle});
        pieces.fragment_area += piece.area;
    }
};

struct CountingSink {
    const std::function<bool(const Cell&)>* keep;
    CountedPieces count;

    void cell(const Piece&) { ++count.cells; }
    void whole(const Piece& piece) {
        count.kept.fragment_area += piece.area;
        if ((*keep)(piece.cell())) count.kept.whole.push_back(piece.triangle);
    }
    void part(const Piece& piece) {
        count.kept.fragment_area += piece.area;
        if (const Cell cell = piece.cell(); (*keep)(cell))
            count.kept.parts.push_back({cell, piece.triangle});
    }
};

/// All blocks' arrays, one after the other; each is freed once it is copied.
template <class T, class Sink, class Member>
std::vector<T> join(std::vector<Sink>& sinks, const Member& member) {
    std::vector<std::size_t> first = {0};
    for (Sink& sink : sinks) first.push_back(first.back() + member(sink).size());
    std::vector<T> all(first.back());
    parallel_for(sinks.size(), 1, [&](std::size_t i) {
        std::vector<T>& some = member(sinks[i]);
        std::copy(some.begin(), some.end(), all.begin() + std::ptrdiff_t(first[i]));
        some = {};
    });
    return all;
}

template <class Sink, class Pieces>
void join_fragments(std::vector<Sink>& sinks, const Pieces& pieces, MeshPieces& result) {
    result.whole = join<std::uint32_t>(
        sinks, [&](Sink & s) -> auto& { return pieces(s).whole; });
    result.parts = join<Fragment>(
        sinks, [&](Sink & s) -> auto& { return pieces(s).parts; });
    for (Sink& sink : sinks) result.fragment_area += pieces(sink).fragment_area;
}

}  // namespace

Fragment MeshPieces::fragment(const TriangleMesh& mesh, std::size_t i) const {
    if (i >= whole.size()) return parts[i - whole.size()];
    return {whole_triangle(mesh, whole[i]).cell(), whole[i]};
}

MeshPieces cut_mesh(const TriangleMesh& mesh, float spacing) {
    std::vector<KeepingSink> sinks = cut_in_blocks(mesh, spacing, KeepingSink{});
    MeshPieces result;
    const auto pieces = [](KeepingSink& sink) -> MeshPieces& { return sink.pieces; };
    result.cells = join<Cell>(
        sinks, [&](KeepingSink & s) -> auto& { return s.pieces.cells; });
    join_fragments(sinks, pieces, result);
    return result;
}

double expected_pieces(const TriangleMesh& mesh, float spacing) {
    const std::size_t blocks = (mesh.triangles.size() + kBlock - 1) / kBlock;
    std::vector<double> sums(blocks, 0);
    parallel_for(blocks, 1, [&](std::size_t block) {
        const std::size_t end = std::min(mesh.triangles.size(), (block + 1) * kBlock);
        for (std::size_t t = block * kBlock; t < end; ++t) {
            const auto& [a, b, c] = mesh.triangles[t];
            const Vec3 p = mesh.vertices[a], q = mesh.vertices[b], r = mesh.vertices[c];
            const float longest2 = std::max({length2(q - p), length2(r - q), length2(p - r)});
            const double cells = triangle_area(mesh, t) / (double(spacing) * spacing);
            sums[block] += std::max({1.0, cells, std::sqrt(double(longest2)) / spacing});
        }
    });
    return std::accumulate(sums.begin(), sums.end(), 0.0);
}

CountedPieces count_pieces(const TriangleMesh& mesh, float spacing,
                           const std::function<bool(const Cell&)>& keep) {
    std::vector<CountingSink> sinks = cut_in_blocks(mesh, spacing, CountingSink{&keep, {}});
    CountedPieces result;
    const auto pieces = [](CountingSink& sink) -> MeshPieces& { return sink.count.kept; };
    for (const CountingSink& sink : sinks) result.cells += sink.count.cells;
    join_fragments(sinks, pieces, result.kept);
    return result;
}

}  // namespace tallow
