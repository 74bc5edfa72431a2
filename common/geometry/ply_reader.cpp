// SPDX-License-Identifier: Apache-2.0
//
// Bytes of a PLY file in, polygons out. The header says which elements follow with which
// properties; "vertex" (x y z, perhaps nx ny nz and texture coordinates) and "face" (a list
// vertex_indices, perhaps a list texcoord of two numbers a corner, as MeshLab writes it, which goes
// before those of the vertices) are kept, everything else is read and forgotten. Two sources of
// values, text and bytes, serve one loop.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "common/base/errors.h"
#include "common/geometry/byte_cursor.h"
#include "common/geometry/mesh_readers.h"
#include "common/geometry/ply_header.h"
#include "common/geometry/text_scanner.h"

namespace tallow {

namespace {

/// Values as words: one line an item.
class AsciiValues {
public:
    explicit AsciiValues(const TextScanner& scan) : scan_(scan) {}

    std::size_t left() const { return scan_.rest().size() + 1; }  // the last line end may lack
    static std::size_t least_bytes(PlyType) { return 2; }         // a digit and what ends it

    void begin_item(const PlyElement& element, std::size_t i) {
        scan_.require_line(fmt::format("{} {} of {}", element.name, i, element.count));
    }
    double value(PlyType type) {
        if (type >= PlyType::float32) return scan_.number("a number");
        return static_cast<double>(scan_.integer("an integer"));
    }
    void end_item() { scan_.expect_end_of_line(); }
    void end_file() { scan_.expect_end_of_file(); }
    [[noreturn]] void fail(const std::string& message) const { scan_.fail(message); }

private:
    TextScanner scan_;
};

/// Values as bytes, without gaps.
class BinaryValues {
public:
    BinaryValues(const std::string& file, std::string_view bytes, std::endian order)
        : file_(file), cursor_(bytes, order) {}

    std::size_t left() const { return cursor_.left(); }
    static std::size_t least_bytes(PlyType type) { return size_in_bytes(type); }

    void begin_item(const PlyElement& element, std::size_t i) {
        element_ = &element;
        item_ = i;
    }
    double value(PlyType type) {
        switch (type) {
            case PlyType::int8:
                return read<std::int8_t>();
            case PlyType::uint8:
                return read<std::uint8_t>();
            case PlyType::int16:
                return read<std::int16_t>();
            case PlyType::uint16:
                return read<std::uint16_t>();
            case PlyType::int32:
                return read<std::int32_t>();
            case PlyType::uint32:
                return read<std::uint32_t>();
            case PlyType::float32:
                return read<float>();
            case PlyType::float64:
                return read<double>();
        }
        return 0;
    }
    void end_item() {}
    void end_file() const {
        if (cursor_.left() > 0)
            throw InputError(
                fmt::format("{}: {} bytes follow after the last element", file_, cursor_.left()));
    }
    [[noreturn]] void fail(const std::string& message) const {
        throw InputError(fmt::format("{}: {} {}: {}", file_, element_->name, item_, message));
    }

private:
    template <class T>
    double read() {
        T value;
        if (!cursor_.read(value))
            fail(fmt::format("the file ends here, {} promised", element_->count));
        return static_cast<double>(value);
    }

    const std::string& file_;
    ByteCursor cursor_;
    const PlyElement* element_ = nullptr;
    std::size_t item_ = 0;
};

template <class Values>
class PlyReader {
public:
    PlyReader(const std::string& file, Values values) : file_(file), values_(std::move(values)) {}

    PolygonSoup read(const PlyHeader& header) {
        for (const PlyElement& element : header.elements) {
            if (element.name == "vertex")
                read_vertices(element);
            else if (element.name == "face")
                read_faces(element);
            else
                skip(element);
        }
        values_.end_file();
        if (soup_.uvs.empty() && !vertex_uvs_.empty()) spread_vertex_uvs();
        return std::move(soup_);
    }

private:
    static constexpr std::size_t kUvSlot = 6, kIgnored = 8;  // after x y z nx ny nz, and u v

    [[noreturn]] void fail(const PlyElement& element, const std::string& message) const {
        throw InputError(
            fmt::format("{}: element {}: {}", file_, in_quotes(element.name), message));
    }

    /// Believes the header's count only as far as the bytes left can hold it. A corner list has at
    /// least three items.
    void check_count(const PlyElement& element, std::size_t corner_list) const {
        if (element.count > 0 && element.properties.empty()) fail(element, "has no properties");
        std::size_t bytes_each = 0;
        for (std::size_t p = 0; p < element.properties.size(); ++p) {
            const PlyProperty& property = element.properties[p];
            bytes_each += Values::least_bytes(property.count_type.value_or(property.type));
            if (p == corner_list) bytes_each += 3 * Values::least_bytes(property.type);
        }
        if (element.count > 0 && element.count > values_.left() / bytes_each)
            fail(element, fmt::format("{} items do not fit in the {} bytes that follow",
                                      element.count, values_.left()));
    }

    void skip(const PlyElement& element) {
        check_count(element, kNoList);
        for (std::size_t i = 0; i < element.count; ++i) {
            values_.begin_item(element, i);
            for (const PlyProperty& property : element.properties) skip(property);
            values_.end_item();
        }
    }

    void skip(const PlyProperty& property) {
        const double items = property.count_type ? values_.value(*property.count_type) : 1;
        for (double i = 0; i < items; ++i) values_.value(property.type);
    }

    void read_vertices(const PlyElement& element) {
        check_count(element, kNoList);
        const std::vector<std::size_t> slots = vertex_slots(element);
        const bool normals = element.find("nx") && element.find("ny") && element.find("nz");
        soup_.vertices.reserve(element.count);
        if (normals) soup_.normals.reserve(element.count);
        const bool uvs = std::ranges::count(slots, kUvSlot) > 0;
        for (std::size_t i = 0; i < element.count; ++i) {
            std::array<float, kIgnored> v{};
            values_.begin_item(element, i);
            for (std::size_t p = 0; p < slots.size(); ++p) {
                if (slots[p] == kIgnored)
                    skip(element.properties[p]);
                else
                    v[slots[p]] = static_cast<float>(values_.value(element.properties[p].type));
            }
            values_.end_item();
            soup_.vertices.emplace_back(v[0], v[1], v[2]);
            if (normals) soup_.normals.emplace_back(v[3], v[4], v[5]);
            if (uvs) vertex_uvs_.emplace_back(v[kUvSlot], v[kUvSlot + 1]);
        }
    }

    /// For each property of a vertex the place where its value goes.
    std::vector<std::size_t> vertex_slots(const PlyElement& element) const {
        constexpr std::array<std::string_view, kUvSlot> kNames = {"x", "y", "z", "nx", "ny", "nz"};
        std::vector<std::size_t> slots(element.properties.size(), kIgnored);
        for (std::size_t slot = 0; slot < kNames.size(); ++slot) {
            const auto p = element.find(kNames[slot]);
            if (!p && slot < 3)
                fail(element, fmt::format("expected a property '{}'", kNames[slot]));
            if (!p) continue;
            if (element.properties[*p].count_type)
                fail(element, fmt::format("expected a number '{}', got a list", kNames[slot]));
            slots[*p] = slot;
        }
        find_uv_slots(element, slots);
        return slots;
    }

    /// Texture coordinates go by many names: Blender's, MeshLab's, Assimp's.
    static void find_uv_slots(const PlyElement& element, std::vector<std::size_t>& slots) {
        constexpr std::pair<std::string_view, std::string_view> kPairs[] = {
            {"s", "t"}, {"u", "v"}, {"texture_u", "texture_v"}};
        for (const auto& [first, second] : kPairs) {
            const auto u = element.find(first), v = element.find(second);
            if (!u || !v || element.properties[*u].count_type || element.properties[*v].count_type)
                continue;
            slots[*u] = kUvSlot;
            slots[*v] = kUvSlot + 1;
            return;
        }
    }

    void read_faces(const PlyElement& element) {
        auto corners = element.find("vertex_indices");
        if (!corners) corners = element.find("vertex_index");
        if (!corners || !element.properties[*corners].count_type)
            fail(element, "expected a list 'vertex_indices'");
        check_count(element, *corners);
        std::size_t texcoord = element.find("texcoord").value_or(kNoList);
        if (texcoord != kNoList && !element.properties[texcoord].count_type) texcoord = kNoList;
        soup_.polygons.reserve(element.count);
        for (std::size_t i = 0; i < element.count; ++i) {
            values_.begin_item(element, i);
            for (std::size_t p = 0; p < element.properties.size(); ++p) {
                if (p == *corners)
                    read_polygon(element.properties[p]);
                else if (p == texcoord)
                    read_texcoord(element.properties[p]);
                else
                    skip(element.properties[p]);
            }
            if (texcoord != kNoList) append_texcoord();
            values_.end_item();
        }
    }

    void read_polygon(const PlyProperty& list) {
        const double corners = values_.value(*list.count_type);
        if (corners < 3)
            values_.fail(fmt::format("expected at least three corners, got {}", corners));
        auto& polygon = soup_.polygons.emplace_back();
        polygon.reserve(static_cast<std::size_t>(std::min(corners, 8.0)));
        for (double i = 0; i < corners; ++i) {
            const double index = values_.value(list.type);
            constexpr double kLast = std::numeric_limits<std::uint32_t>::max();
            if (!(index >= 0 && index <= kLast && index == std::floor(index)))
                values_.fail(fmt::format("expected a vertex index, got {}", index));
            polygon.push_back(static_cast<std::uint32_t>(index));
        }
    }

    void read_texcoord(const PlyProperty& list) {
        texcoord_.clear();
        const double items = values_.value(*list.count_type);
        for (double i = 0; i < items; ++i)
            texcoord_.push_back(static_cast<float>(values_.value(list.type)));
    }

    /// Those of the polygon just read; an empty list stands for none.
    void append_texcoord() {
        const std::size_t corners = soup_.polygons.back().size();
        if (!texcoord_.empty() && texcoord_.size() != 2 * corners)
            values_.fail(fmt::format("expected {} texture coordinates for {} corners, got {}",
                                     2 * corners, corners, texcoord_.size()));
        if (texcoord_.empty()) soup_.corners_without_uv += corners;
        texcoord_.resize(2 * corners);
        for (std::size_t c = 0; c < corners; ++c)
            soup_.uvs.emplace_back(texcoord_[2 * c], texcoord_[2 * c + 1]);
    }

    void spread_vertex_uvs() {
        for (const auto& polygon : soup_.polygons)
            for (const std::uint32_t v : polygon)  // whether it is in range is asked later
                soup_.uvs.push_back(v < vertex_uvs_.size() ? vertex_uvs_[v] : Vec2(0));
    }

    static constexpr std::size_t kNoList = std::numeric_limits<std::size_t>::max();

    const std::string& file_;
    Values values_;
    PolygonSoup soup_;
    std::vector<Vec2> vertex_uvs_;  // [vertex] or empty
    std::vector<float> texcoord_;   // of the face just read
};

}  // namespace

PolygonSoup read_ply(const MeshFile& file) {
    TextScanner scan(file.name, file.bytes, '\0');
    const PlyHeader header = read_ply_header(scan);
    if (header.format == PlyFormat::ascii)
        return PlyReader(file.name, AsciiValues(scan)).read(header);
    const auto order =
        header.format == PlyFormat::binary_little_endian ? std::endian::little : std::endian::big;
    return PlyReader(file.name, BinaryValues(file.name, scan.rest(), order)).read(header);
}

}  // namespace tallow
