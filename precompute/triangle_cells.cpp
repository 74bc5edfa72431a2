// SPDX-License-Identifier: Apache-2.0
// Triangles -> cells of about spacing^2 and smaller fragments. A triangle that is not too oblique
// is cut into rows of trapezoids; others first in two, from the longest edge to the opposite
// corner.
#include "precompute/triangle_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "common/base/parallel.h"

namespace tallow {
namespace {

// Longest edge, in spacings, of a triangle that is one cell; least height, in sides of a square of
// a cell's area, of one that is several. Beyond, it becomes fragments. Chosen: with 2.4 in place of
// 3 every tenth triangle needs one cell more, at the same error for the number of cells.
constexpr float kLongestEdge = 3;
constexpr double kLeastHeight = 0.5;

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

    /// Squared length of the edge from corner i.
    float edge2(std::size_t i) const {
        return length2(corner[(i + 1) % 3].position - corner[i].position);
    }

    void turn_to(std::size_t first) {
        corner = {corner[first], corner[(first + 1) % 3], corner[(first + 2) % 3]};
    }

    /// Turned so that the edge from the first corner to the second is the longest; its squared
    /// length.
    float turn_to_longest() {
        const float e[3] = {edge2(0), edge2(1), edge2(2)};
        const float longest = std::max({e[0], e[1], e[2]});
        turn_to(longest == e[0] ? 0 : longest == e[1] ? 1 : 2);
        return longest;
    }

    /// Turned so that the third corner is as near as can be to the middle above the edge between
    /// the others; how far it is from there, in heights: the distance of its foot from the middle
    /// is (b^2 - c^2) / 2a, the height 2 area / a.
    double turn_to_upright() {
        double e[3];  // in double: those of a needle differ by little
        for (std::size_t i = 0; i < 3; ++i) {
            const DVec3 edge = DVec3(corner[(i + 1) % 3].position) - DVec3(corner[i].position);
            e[i] = glm::dot(edge, edge);
        }
        std::size_t best = 0;
        const auto lean = [&](std::size_t i) { return std::abs(e[(i + 1) % 3] - e[(i + 2) % 3]); };
        for (std::size_t i = 1; i < 3; ++i)
            if (lean(i) < lean(best)) best = i;
        turn_to(best);
        return lean(best) / (4 * area);
    }

    /// Cut from the third corner to the edge between the others; `first` of the pieces, and `share`
    /// of the area, on the side of the first corner.
    std::array<Piece, 2> cut(std::uint64_t first, double share) const {
        const Corner m = between(corner[0], corner[1], float(share));
        return {Piece{{corner[0], m, corner[2]}, share * area, first, triangle},
                Piece{{m, corner[1], corner[2]}, area - share * area, pieces - first, triangle}};
    }

    std::array<Piece, 2> cut_in_half() const {
        return cut(pieces / 2, double(pieces / 2) / double(pieces));
    }

    /// Cut near the foot of the height on the longest edge, to which it must have been turned: what
    /// comes out are two nearly right-angled triangles.
    std::array<Piece, 2> cut_at_foot() const {
        const Vec3 edge = corner[1].position - corner[0].position;
        const double foot = std::clamp(
            double(glm::dot(corner[2].position - corner[0].position, edge) / length2(edge)), 0.0,
            1.0);
        if (pieces < 2) return cut(0, foot);
        const auto first = std::uint64_t(std::round(foot * double(pieces)));
        const std::uint64_t inside = std::clamp<std::uint64_t>(first, 1, pieces - 1);
        return cut(inside, double(inside) / double(pieces));
    }

    /// The point (1 - y) c + y ((1 - u) a + u b) as a cell of one of the pieces.
    Cell cell_at(double y, double u, double share) const {
        const float a = float(y * (1 - u)), b = float(y * u), c = float(1 - y);
        return {a * corner[0].position + b * corner[1].position + c * corner[2].position,
                glm::normalize(a * corner[0].normal + b * corner[1].normal + c * corner[2].normal),
                float(share * area)};
    }

    Cell cell() const { return cell_at(2.0 / 3, 0.5, 1); }
};

Piece whole_triangle(const TriangleMesh& mesh, std::size_t t) {
    Piece piece{{}, triangle_area(mesh, t), 0, std::uint32_t(t)};
    const Vec3 flat = mesh.corner_normals.empty() ? triangle_normal(mesh, t) : Vec3(0);
    for (std::size_t k = 0; k < 3; ++k)
        piece.corner[k] = {mesh.vertices[mesh.triangles[t][k]],
                           mesh.corner_normals.empty() ? flat : mesh.corner_normals[3 * t + k]};
    return piece;
}

/// Cuts pieces and hands them on: sink.cell(Cell), sink.whole(Piece), sink.part(Cell,
/// triangle).
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
        if (piece.pieces == 1 && longest2 <= limit2(kLongestEdge)) return sink_.cell(piece.cell());
        if (piece.pieces == 1 || is_thin(piece, longest2)) piece.pieces = 0;
        if (piece.pieces == 0 && longest2 <= limit2(kLongestFragment)) return emit_part(piece);
        const std::array<Piece, 2> halves = piece.cut_at_foot();
        if (piece.turn_to_upright() <= 1)
            return piece.pieces == 0 ? fragments_in_rows(piece) : cells_in_rows(piece);
        // Far from the origin floats may be too coarse for the spacing.
        const Vec3 middle = halves[0].corner[1].position;
        if (middle == halves[0].corner[0].position || middle == halves[1].corner[1].position)
            return emit_part(piece);
        for (const Piece& half : halves) cut(half);
    }

private:
    static bool is_thin(const Piece& piece, float longest2) {
        const double height2 = 4 * piece.area * piece.area / double(longest2);
        return height2 * double(piece.pieces) < kLeastHeight * kLeastHeight * piece.area;
    }

    /// Calls append(y, u, share) for `count` cells side by side between y0 and y1, where y = 0 is
    /// the tip and y = 1 the edge, so that the area above y is y^2. Their centroids are at
    /// 2/3 (y1^3 - y0^3) / (y1^2 - y0^2), because widths grow with y.
    template <class Append>
    static void append_row(double y0, double y1, double count, const Append& append) {
        const double y = 2.0 / 3 * (y1 * y1 + y1 * y0 + y0 * y0) / (y1 + y0);
        for (double k = 0; k < count; ++k)
            append(y, (k + 0.5) / count, (y1 * y1 - y0 * y0) / count);
    }

    /// Rows parallel to the edge, each of cells of the same area that are about as wide as high.
    void cells_in_rows(const Piece& piece) {
        const auto count = double(piece.pieces);
        const double side = std::sqrt(piece.area / count);
        const double height = 2 * piece.area / std::sqrt(double(piece.edge2(0)));
        const double rows = std::clamp(std::round(height / side), 1.0, count);
        double above = 0;  // cells of the rows before
        for (double row = 1; row <= rows; ++row) {
            double below = std::round(count * (row / rows) * (row / rows));
            below = std::clamp(below, above + 1, count - (rows - row));
            append_row(
                std::sqrt(above / count), std::sqrt(below / count), below - above,
                [&](double y, double u, double) { sink_.cell(piece.cell_at(y, u, 1 / count)); });
            above = below;
        }
    }

    /// Rows of the same height, each of fragments of the same area, short enough.
    void fragments_in_rows(const Piece& piece) {
        const double limit = double(spacing_) * kLongestFragment / std::numbers::sqrt2;
        const double width = std::sqrt(double(piece.edge2(0)));
        const double rows = std::ceil(2 * piece.area / width / limit);
        for (double row = 0; row < rows; ++row) {
            const double y0 = row / rows, y1 = (row + 1) / rows;
            append_row(y0, y1, std::ceil(y1 * width / limit),
                       [&](double y, double u, double share) {
                           sink_.part(piece.cell_at(y, u, share), piece.triangle);
                       });
        }
    }

    void emit_part(const Piece& piece) { sink_.part(piece.cell(), piece.triangle); }

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
            const std::array<Piece, 2> halves = tasks[i].cut_in_half();
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

    void cell(const Cell& cell) { pieces.cells.push_back(cell); }
    void whole(const Piece& piece) {
        pieces.whole.push_back(piece.triangle);
        pieces.fragment_area += piece.area;
    }
    void part(const Cell& cell, std::uint32_t triangle) {
        pieces.parts.push_back({cell, triangle});
        pieces.fragment_area += double(cell.area);
    }
};

struct CountingSink {
    const std::function<bool(const Cell&)>* keep;
    CountedPieces count;

    void cell(const Cell&) { ++count.cells; }
    void whole(const Piece& piece) {
        count.kept.fragment_area += piece.area;
        if ((*keep)(piece.cell())) count.kept.whole.push_back(piece.triangle);
    }
    void part(const Cell& cell, std::uint32_t triangle) {
        count.kept.fragment_area += double(cell.area);
        if ((*keep)(cell)) count.kept.parts.push_back({cell, triangle});
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

WorkEstimate estimate_work(const TriangleMesh& mesh, float spacing) {
    const std::size_t blocks = (mesh.triangles.size() + kBlock - 1) / kBlock;
    std::vector<WorkEstimate> of_block(blocks);
    parallel_for(blocks, 1, [&](std::size_t block) {
        const std::size_t end = std::min(mesh.triangles.size(), (block + 1) * kBlock);
        for (std::size_t t = block * kBlock; t < end; ++t) {
            const auto& [a, b, c] = mesh.triangles[t];
            const Vec3 p = mesh.vertices[a], q = mesh.vertices[b], r = mesh.vertices[c];
            const float longest2 = std::max({length2(q - p), length2(r - q), length2(p - r)});
            const double cells = triangle_area(mesh, t) / (double(spacing) * spacing);
            const double spacings = std::sqrt(double(longest2)) / spacing;
            of_block[block].samples += cells;
            if (cells < 0.2 * spacings) of_block[block].fragments += std::max(1.0, spacings);
        }
    });
    WorkEstimate all;
    for (const WorkEstimate& some : of_block) {
        all.samples += some.samples;
        all.fragments += some.fragments;
    }
    return all;
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
