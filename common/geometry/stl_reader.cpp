// SPDX-License-Identifier: Apache-2.0
//
// Bytes of an STL file in, triangles out; ASCII ("solid", facets, "endsolid") or binary (80 bytes
// of header, a count, 50 bytes a triangle: normal, three corners, 2 attribute bytes). The format
// repeats every vertex in each of its triangles; corners at equal positions become one vertex, so
// that a good file needs no repair. Facet normals are ignored: the order of corners says it too.
// Source: 3D Systems, "Stereolithography Interface Specification", 1989.

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <unordered_map>

#include "common/base/errors.h"
#include "common/geometry/byte_cursor.h"
#include "common/geometry/mesh_readers.h"
#include "common/geometry/position_hash.h"
#include "common/geometry/text_scanner.h"

namespace tallow {

namespace {

constexpr std::size_t kHeaderBytes = 80, kTriangleBytes = 50;

/// Collects corners, three a triangle, as shared vertices.
class TriangleCollector {
public:
    void add(Vec3 position) {
        const auto next = static_cast<std::uint32_t>(soup_.vertices.size());
        const auto [known, is_new] = index_.try_emplace(position, next);
        if (is_new) soup_.vertices.push_back(position);
        if (soup_.polygons.empty() || soup_.polygons.back().size() == 3)
            soup_.polygons.emplace_back().reserve(3);
        soup_.polygons.back().push_back(known->second);
    }
    PolygonSoup take() { return std::move(soup_); }

private:
    PolygonSoup soup_;
    std::unordered_map<Vec3, std::uint32_t, PositionHash> index_;
};

bool equal_ignoring_case(std::string_view a, std::string_view lower) {
    return std::equal(a.begin(), a.end(), lower.begin(), lower.end(), [](char c, char l) {
        return (c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c) == l;
    });
}

void expect_word(TextScanner& scan, std::string_view expected) {
    const std::string what = fmt::format("'{}'", expected);
    const std::string_view word = scan.word(what);
    if (!equal_ignoring_case(word, expected)) scan.fail_expected(what, in_quotes(word));
}

void expect_line(TextScanner& scan, std::string_view first, std::string_view second = {}) {
    scan.require_line(fmt::format("'{}'", first));
    expect_word(scan, first);
    if (!second.empty()) expect_word(scan, second);
}

/// The lines of one facet after the word "facet".
void read_facet(TextScanner& scan, TriangleCollector& triangles) {
    expect_word(scan, "normal");
    for (int i = 0; i < 3; ++i) scan.word("a normal's coordinate");  // often nan, never needed
    scan.expect_end_of_line();
    expect_line(scan, "outer", "loop");
    for (int corner = 0; corner < 3; ++corner) {
        expect_line(scan, "vertex");
        triangles.add(scan.vector("a coordinate"));
        scan.expect_end_of_line();
    }
    expect_line(scan, "endloop");
    expect_line(scan, "endfacet");
}

PolygonSoup read_ascii(const MeshFile& file) {
    TextScanner scan(file.name, file.bytes, '\0');
    TriangleCollector triangles;
    while (scan.next_line()) {  // a file may hold several solids
        expect_word(scan, "solid");
        for (;;) {
            scan.require_line("'facet' or 'endsolid'");
            const std::string_view word = scan.next_word();
            if (equal_ignoring_case(word, "endsolid")) break;
            if (!equal_ignoring_case(word, "facet"))
                scan.fail_expected("'facet' or 'endsolid'", in_quotes(word));
            read_facet(scan, triangles);
        }
    }
    return triangles.take();
}

PolygonSoup read_binary(const MeshFile& file) {
    ByteCursor cursor(file.bytes, std::endian::little);
    std::uint32_t count;
    if (!cursor.skip(kHeaderBytes) || !cursor.read(count))
        throw InputError(
            fmt::format("{}: expected 'solid' or 84 bytes of binary header, got {} bytes",
                        file.name, file.bytes.size()));
    if (cursor.left() != count * kTriangleBytes)
        throw InputError(
            fmt::format("{}: header promises {} triangles in {} bytes, but {} bytes follow",
                        file.name, count, count * kTriangleBytes, cursor.left()));
    TriangleCollector triangles;
    for (std::uint32_t t = 0; t < count; ++t) {
        cursor.skip(sizeof(Vec3));  // the normal
        for (int corner = 0; corner < 3; ++corner) {
            Vec3 p;
            cursor.read(p.x);
            cursor.read(p.y);
            cursor.read(p.z);
            triangles.add(p);
        }
        cursor.skip(2);  // attributes
    }
    return triangles.take();
}

/// Binary files may begin with "solid" too, against the rule; but text holds no zero bytes.
bool is_ascii(std::string_view bytes) {
    constexpr std::size_t kProbed = 512;  // more than the header, whose rest is often zero
    return equal_ignoring_case(bytes.substr(0, 5), "solid") &&
           bytes.substr(0, kProbed).find('\0') == std::string_view::npos;
}

}  // namespace

PolygonSoup read_stl(const MeshFile& file) {
    return is_ascii(file.bytes) ? read_ascii(file) : read_binary(file);
}

}  // namespace tallow
