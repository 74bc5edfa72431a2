// SPDX-License-Identifier: Apache-2.0
//
// Text of an OFF file in, polygons out. The format: a word "OFF" with prefixes for what a vertex
// line holds besides its position (ST texture, C colour, N normal), counts of vertices, faces and
// edges, then one line a vertex and one line a face, "3 0 1 2" and perhaps a colour; comments
// from '#'. The 4-dimensional and binary variants are refused.
// Source: Geomview manual, section "OFF Files".

#include <fmt/format.h>

#include "common/geometry/mesh_readers.h"
#include "common/geometry/text_scanner.h"

namespace tallow {

namespace {

/// Reads the magic word; returns whether vertices carry normals.
bool read_magic(TextScanner& scan) {
    scan.require_line("'OFF'");
    const std::string_view magic = scan.word("'OFF'");
    std::string_view prefix = magic;
    const bool texture = prefix.starts_with("ST");
    if (texture) prefix.remove_prefix(2);
    if (prefix.starts_with("C")) prefix.remove_prefix(1);
    const bool normals = prefix.starts_with("N");
    if (normals) prefix.remove_prefix(1);
    if (prefix != "OFF")
        scan.fail("expected 'OFF', 'COFF', 'NOFF' or 'CNOFF', got " + in_quotes(magic));
    return normals;
}

void read_vertices(TextScanner& scan, std::size_t count, bool normals, PolygonSoup& soup) {
    soup.vertices.reserve(count);
    if (normals) soup.normals.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
        scan.require_line(fmt::format("vertex {} of {}", i, count));
        soup.vertices.push_back(scan.vector("a coordinate"));
        if (normals) soup.normals.push_back(scan.vector("a normal's coordinate"));
        scan.skip_numbers();  // colours and texture coordinates come last
    }
}

void read_faces(TextScanner& scan, std::size_t count, PolygonSoup& soup) {
    soup.polygons.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
        scan.require_line(fmt::format("face {} of {}", i, count));
        auto& polygon = soup.polygons.emplace_back();
        const std::int64_t corners = scan.integer("a number of corners");
        if (corners < 3) scan.fail(fmt::format("expected at least three corners, got {}", corners));
        // No reserve for more: the line ends where it ends, whatever the number promised.
        polygon.reserve(corners < 8 ? static_cast<std::size_t>(corners) : 8);
        for (std::int64_t c = 0; c < corners; ++c) polygon.push_back(scan.index());
        scan.skip_numbers();
    }
}

}  // namespace

PolygonSoup read_off(const MeshFile& file) {
    TextScanner scan(file.name, file.bytes, '#');
    const bool normals = read_magic(scan);
    if (scan.at_end_of_line()) scan.require_line("the numbers of vertices, faces and edges");
    const std::size_t vertices = scan.count("vertices", 6);
    const std::size_t faces = scan.count("faces", 8);
    scan.skip_numbers();

    PolygonSoup soup;
    read_vertices(scan, vertices, normals, soup);
    read_faces(scan, faces, soup);
    scan.expect_end_of_file();
    return soup;
}

}  // namespace tallow
