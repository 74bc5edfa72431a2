// SPDX-License-Identifier: Apache-2.0
//
// Lines from "ply" to "end_header" in, a list of elements with typed properties out.
// Source: Greg Turk, "The PLY Polygon File Format", 1994.

#include "common/geometry/ply_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

namespace tallow {

namespace {

// Two names a type: Turk's and the later ones that state the size.
constexpr std::array<std::pair<std::string_view, PlyType>, 16> kTypeNames = {{
    {"char", PlyType::int8},
    {"int8", PlyType::int8},
    {"uchar", PlyType::uint8},
    {"uint8", PlyType::uint8},
    {"short", PlyType::int16},
    {"int16", PlyType::int16},
    {"ushort", PlyType::uint16},
    {"uint16", PlyType::uint16},
    {"int", PlyType::int32},
    {"int32", PlyType::int32},
    {"uint", PlyType::uint32},
    {"uint32", PlyType::uint32},
    {"float", PlyType::float32},
    {"float32", PlyType::float32},
    {"double", PlyType::float64},
    {"float64", PlyType::float64},
}};

PlyType find_type(const TextScanner& scan, std::string_view name) {
    for (const auto& [known, type] : kTypeNames)
        if (known == name) return type;
    scan.fail_expected("a PLY type such as 'float' or 'uchar'", in_quotes(name));
}

PlyFormat read_format(TextScanner& scan) {
    std::string_view keyword = "comment";
    while (keyword == "comment" || keyword == "obj_info") {
        scan.require_line("'format'");
        keyword = scan.next_word();
    }
    if (keyword != "format") scan.fail_expected("'format'", in_quotes(keyword));
    const std::string_view name = scan.word("a format");
    if (const auto version = scan.word("version 1.0"); version != "1.0")
        scan.fail_expected("version 1.0", in_quotes(version));
    scan.expect_end_of_line();
    if (name == "ascii") return PlyFormat::ascii;
    if (name == "binary_little_endian") return PlyFormat::binary_little_endian;
    if (name == "binary_big_endian") return PlyFormat::binary_big_endian;
    scan.fail_expected("'ascii', 'binary_little_endian' or 'binary_big_endian'", in_quotes(name));
}

PlyElement read_element(TextScanner& scan, const PlyHeader& header) {
    PlyElement element;
    element.name = scan.word("an element's name");
    for (const PlyElement& other : header.elements)
        if (other.name == element.name) scan.fail("element " + in_quotes(element.name) + " twice");
    const std::int64_t count = scan.integer("a number of items");
    if (count < 0) scan.fail_expected("a number of items", fmt::format("{}", count));
    element.count = static_cast<std::size_t>(count);
    return element;
}

PlyProperty read_property(TextScanner& scan, const PlyElement& element) {
    PlyProperty property;
    std::string_view type = scan.word("a property's type");
    if (type == "list") {
        property.count_type = find_type(scan, scan.word("the type of a list's length"));
        if (*property.count_type >= PlyType::float32)
            scan.fail("expected an integer type for a list's length");
        type = scan.word("the type of a list's items");
    }
    property.type = find_type(scan, type);
    property.name = scan.word("a property's name");
    if (element.find(property.name)) scan.fail("property " + in_quotes(property.name) + " twice");
    return property;
}

}  // namespace

std::size_t size_in_bytes(PlyType type) {
    constexpr std::array<std::size_t, 8> kSizes = {1, 1, 2, 2, 4, 4, 4, 8};
    return kSizes[static_cast<std::size_t>(type)];
}

std::optional<std::size_t> PlyElement::find(std::string_view property) const {
    const auto found = std::find_if(properties.begin(), properties.end(),
                                    [&](const PlyProperty& p) { return p.name == property; });
    if (found == properties.end()) return std::nullopt;
    return static_cast<std::size_t>(found - properties.begin());
}

PlyHeader read_ply_header(TextScanner& scan) {
    scan.require_line("'ply'");
    if (const auto magic = scan.next_word(); magic != "ply")
        scan.fail_expected("'ply'", in_quotes(magic));
    PlyHeader header;
    header.format = read_format(scan);
    for (;;) {
        scan.require_line("'end_header'");
        const std::string_view keyword = scan.next_word();
        if (keyword == "comment" || keyword == "obj_info") continue;
        if (keyword == "end_header") break;
        if (keyword == "element") {
            header.elements.push_back(read_element(scan, header));
        } else if (keyword == "property" && !header.elements.empty()) {
            PlyElement& element = header.elements.back();
            element.properties.push_back(read_property(scan, element));
        } else {
            scan.fail_expected("'element', 'property' or 'end_header'", in_quotes(keyword));
        }
        scan.expect_end_of_line();
    }
    scan.expect_end_of_line();
    return header;
}

}  // namespace tallow
