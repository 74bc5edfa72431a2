// SPDX-License-Identifier: Apache-2.0
//
// Text of a Wavefront OBJ file in, polygons out: lines "v x y z", "vn x y z", "vt u v" and "f" with
// corners v, v/vt, v//vn or v/vt/vn, counted from one or, if negative, backwards from the latest.
// Names, groups, materials, lines and points are skipped; curves and surfaces are refused, for they
// are shape that we would lose. Where there is no line "vt", corners may name what they like.
//
// A vertex that corners use with different normals becomes one soup vertex for each of them.
// Source: Wavefront, "Advanced Visualizer Manual", appendix B1.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

#include "common/geometry/mesh_readers.h"
#include "common/geometry/text_scanner.h"

namespace tallow {

namespace {

constexpr std::array<std::string_view, 16> kNoShape = {
    "o",      "g",      "s",   "mg",    "l",        "p",        "usemtl",     "mtllib",
    "usemap", "maplib", "lod", "bevel", "c_interp", "d_interp", "shadow_obj", "trace_obj"};

class ObjReader {
public:
    explicit ObjReader(const MeshFile& file) : scan_(file.name, file.bytes, '#') {}

    PolygonSoup read() {
        while (scan_.next_line()) read_line(scan_.next_word());
        check_indices();
        if (!normals_.empty()) separate_normals();
        build_polygons();
        if (!uvs_.empty()) build_uvs();
        return std::move(soup_);
    }

private:
    static constexpr std::int64_t kNone = -1;
    static constexpr std::int64_t kFarBack = 1ll << 40;  // no file is so long; -index is safe

    struct Corner {
        std::int64_t vertex;
        std::int64_t texture = kNone;
        std::int64_t normal = kNone;
    };

    struct Face {
        std::size_t first_corner;
        std::size_t line;
    };

    void read_line(std::string_view keyword) {
        if (keyword == "v") {
            soup_.vertices.push_back(scan_.vector("a coordinate"));
            scan_.skip_numbers();  // a weight or a colour
        } else if (keyword == "vn") {
            normals_.push_back(scan_.vector("a normal's coordinate"));
            scan_.expect_end_of_line();
        } else if (keyword == "vt") {
            const float u = scan_.number("a texture coordinate");
            uvs_.emplace_back(u, scan_.at_end_of_line() ? 0 : scan_.number("a texture coordinate"));
            scan_.skip_numbers();  // a third coordinate
        } else if (keyword == "f") {
            read_face();
        } else if (std::find(kNoShape.begin(), kNoShape.end(), keyword) == kNoShape.end()) {
            scan_.fail("expected an OBJ keyword for polygons, got " + in_quotes(keyword));
        }
    }

    void read_face() {
        faces_.push_back({corners_.size(), scan_.line()});
        for (auto word = scan_.next_word(); !word.empty(); word = scan_.next_word()) {
            if (word == "\\")
                scan_.require_line("the rest of the face");
            else
                corners_.push_back(parse_corner(word));
        }
        const std::size_t size = corners_.size() - faces_.back().first_corner;
        if (size < 3) scan_.fail(fmt::format("expected at least three corners, got {}", size));
    }

    Corner parse_corner(std::string_view word) const {
        std::array<std::string_view, 3> part;  // vertex, texture, normal
        std::size_t parts = 0;
        for (std::string_view left = word;; ++parts) {
            const std::size_t slash = left.find('/');
            if (parts == 3) fail_corner(word);
            part[parts] = left.substr(0, slash);
            if (slash == std::string_view::npos) break;
            left.remove_prefix(slash + 1);
        }
        Corner corner{resolve(part[0], soup_.vertices.size(), word)};
        if (!part[1].empty()) corner.texture = resolve_texture(part[1], word);
        if (!part[2].empty()) corner.normal = resolve(part[2], normals_.size(), word);
        return corner;
    }

    /// The index counted from zero. `so_far` is how many there are before this line.
    std::int64_t resolve(std::string_view text, std::size_t so_far, std::string_view word) const {
        const std::int64_t index = parse_index(text, word);
        if (index > 0) return index - 1;
        const auto count = static_cast<std::int64_t>(so_far);
        if (-index > count)
            scan_.fail(fmt::format("{} counts back beyond the {} so far", index, count));
        return count + index;
    }

    /// Where no texture coordinates have come yet, there is nothing to count back from.
    std::int64_t resolve_texture(std::string_view text, std::string_view word) const {
        return uvs_.empty() && parse_index(text, word) < 0 ? kNone
                                                           : resolve(text, uvs_.size(), word);
    }

    std::int64_t parse_index(std::string_view text, std::string_view word) const {
        std::int64_t index;
        if (!parse_integer(text, index) || index == 0 || index < -kFarBack) fail_corner(word);
        return index;
    }

    [[noreturn]] void fail_corner(std::string_view word) const {
        scan_.fail("expected a corner like 3, 3/1, 3//2 or 3/1/2, got " + in_quotes(word));
    }

    /// Only at the end, because a face may come before its vertices.
    void check_indices() const {
        for (std::size_t f = 0; f < faces_.size(); ++f)
            for (std::size_t c = faces_[f].first_corner; c < end_of_face(f); ++c) {
                check(corners_[c].vertex, soup_.vertices.size(), "vertex", "vertices", f);
                if (corners_[c].texture != kNone && !uvs_.empty())
                    check(corners_[c].texture, uvs_.size(), "texture coordinate",
                          "texture coordinates", f);
                if (corners_[c].normal != kNone)
                    check(corners_[c].normal, normals_.size(), "normal", "normals", f);
            }
    }

    void check(std::int64_t index, std::size_t count, const char* one, const char* many,
               std::size_t f) const {
        if (index >= static_cast<std::int64_t>(count))
            scan_.fail_at(faces_[f].line, fmt::format("face {}: {} {} out of range ({} {})", f, one,
                                                      index + 1, count, many));
    }

    std::size_t end_of_face(std::size_t f) const {
        return f + 1 < faces_.size() ? faces_[f + 1].first_corner : corners_.size();
    }

    /// Splits vertices so that each has one normal; those without keep a zero vector.
    void separate_normals() {
        std::vector<std::int64_t> normal_of(soup_.vertices.size(), kNone);
        std::map<std::pair<std::int64_t, std::int64_t>, std::int64_t> copies;
        for (Corner& corner : corners_) {
            if (corner.normal == kNone) continue;
            std::int64_t& taken = normal_of[static_cast<std::size_t>(corner.vertex)];
            if (taken == kNone) taken = corner.normal;
            if (taken == corner.normal) continue;
            const auto fresh = static_cast<std::int64_t>(soup_.vertices.size());
            const auto [copy, is_new] = copies.try_emplace({corner.vertex, corner.normal}, fresh);
            if (is_new) {
                soup_.vertices.push_back(soup_.vertices[static_cast<std::size_t>(corner.vertex)]);
                normal_of.push_back(corner.normal);
            }
            corner.vertex = copy->second;
        }
        for (const std::int64_t n : normal_of)
            soup_.normals.push_back(n == kNone ? Vec3(0) : normals_[static_cast<std::size_t>(n)]);
    }

    void build_polygons() {
        soup_.polygons.resize(faces_.size());
        for (std::size_t f = 0; f < faces_.size(); ++f)
            for (std::size_t c = faces_[f].first_corner; c < end_of_face(f); ++c)
                soup_.polygons[f].push_back(static_cast<std::uint32_t>(corners_[c].vertex));
    }

    void build_uvs() {
        for (const Corner& corner : corners_) {
            const bool has = corner.texture != kNone;
            soup_.uvs.push_back(has ? uvs_[static_cast<std::size_t>(corner.texture)] : Vec2(0));
            soup_.corners_without_uv += !has;
        }
    }

    TextScanner scan_;
    PolygonSoup soup_;
    std::vector<Vec2> uvs_;
    std::vector<Vec3> normals_;
    std::vector<Corner> corners_;  // of all faces, one after the other
    std::vector<Face> faces_;
};

}  // namespace

PolygonSoup read_obj(const MeshFile& file) { return ObjReader(file).read(); }

}  // namespace tallow
