// SPDX-License-Identifier: Apache-2.0
// The `textures` section, and the colours of materials that refer to it.
#include "common/scene/textures_yaml.h"

#include <fmt/format.h>

#include "common/base/errors.h"

namespace tallow {
namespace {

using TextureKind = decltype(Texture::kind);

/// What reading one texture needs besides its map.
struct Context {
    const std::filesystem::path& folder;
    const std::vector<NamedTexture>& before;  // images are shared with them
};

TextureKind read_checker(const YamlMap& map, const Context&, NamedTexture&) {
    map.allow_only({"type", "even", "odd", "coordinates", "period"});
    return CheckerTexture{map.rgb("even", kZeroToOne), map.rgb("odd", kZeroToOne)};
}

TextureKind read_image_texture(const YamlMap& map, const Context& context, NamedTexture& named) {
    map.allow_only({"type", "file", "coordinates", "period"});
    named.file = context.folder / map.text("file");
    for (const NamedTexture& other : context.before)
        if (other.file == named.file) return other.texture->kind;
    try {
        return ImageTexture{std::make_shared<RgbImage>(read_image(named.file))};
    } catch (const InputError& e) {
        map.fail("file", e.what());
    }
}

/// In uv a number or [u, v]; in object space lengths, which no default can guess.
Vec3 read_period(const YamlMap& map, Texture::Coordinates coordinates,
                 const LengthReader& lengths) {
    if (coordinates == Texture::Coordinates::uv) {
        if (!map.has("period")) return Vec3(1);
        const YamlNode& node = map.at("period");
        if (node.kind == YamlNode::Kind::scalar)
            return Vec3(yaml_number(node, "period", kPositive));
        const auto& items = yaml_items(node, "period", 2, "a number or two [u, v]");
        return {yaml_number(items[0], "period", kPositive),
                yaml_number(items[1], "period", kPositive), 1};
    }
    const YamlNode& node = map.at("period");
    if (node.kind == YamlNode::Kind::scalar) return Vec3(lengths.positive(node, "period"));
    const auto& items = yaml_items(node, "period", 3, "a number or three [x, y, z]");
    return {lengths.positive(items[0], "period"), lengths.positive(items[1], "period"),
            lengths.positive(items[2], "period")};
}

const NamedTexture& known_texture(const YamlMap& map, const std::vector<NamedTexture>& textures) {
    const std::string name = map.text("texture");
    std::vector<std::string_view> names;
    for (const NamedTexture& texture : textures) {
        if (texture.name == name) return texture;
        names.push_back(texture.name);
    }
    fail_expected(map.at("texture"), "texture",
                  names.empty() ? "a name from textures, which is empty" : one_of(names));
}

/// Refuses a surface that would reflect more light than it gets.
void require_at_most_one(const YamlWhere& where, std::string_view key, const NamedTexture& named,
                         Rgb scale) {
    const char* product = scale == Rgb(1) ? "" : " times scale";
    const auto check = [&](Rgb color, const auto& place) {
        if (const float largest = max_channel(scale * color); !(largest <= 1))
            fail_at(where, key,
                    fmt::format("{}: expected colours of at most 1{}, got {:g}", place(), product,
                                largest));
    };
    if (const auto* checker = std::get_if<CheckerTexture>(&named.texture->kind)) {
        check(checker->even, [&] { return fmt::format("even of texture {}", named.name); });
        check(checker->odd, [&] { return fmt::format("odd of texture {}", named.name); });
    } else {
        const RgbImage& image = *std::get<ImageTexture>(named.texture->kind).image;
        for (int y = 0; y < image.height; ++y)
            for (int x = 0; x < image.width; ++x)
                check(image.at(x, y),
                      [&] { return fmt::format("{}: pixel ({}, {})", named.file.string(), x, y); });
    }
}

}  // namespace

std::vector<NamedTexture> read_textures(const YamlNode& section,
                                        const std::filesystem::path& folder,
                                        const LengthReader& lengths) {
    using Reader = TextureKind (*)(const YamlMap&, const Context&, NamedTexture&);
    using enum Texture::Coordinates;
    std::vector<NamedTexture> textures;
    for (const YamlEntry& entry : YamlMap(section, "textures").entries()) {
        require_name(entry.key_where, entry.key);
        const YamlMap map(entry.value, entry.key);
        const auto read =
            map.choice<Reader>("type", {{"checker", read_checker}, {"image", read_image_texture}});
        NamedTexture named{entry.key, {}, {}};
        const TextureKind kind = read(map, {folder, textures}, named);
        const auto coordinates = map.choice_or("coordinates", {{"uv", uv}, {"object", object}}, uv);
        named.texture = std::make_shared<Texture>(
            Texture{kind, coordinates, read_period(map, coordinates, lengths)});
        textures.push_back(std::move(named));
    }
    return textures;
}

SurfaceColor read_surface_color(const YamlMap& map, std::string_view key,
                                const std::vector<NamedTexture>& textures) {
    const YamlNode& node = map.at(key);
    if (node.kind != YamlNode::Kind::map) {
        if (node.kind != YamlNode::Kind::scalar && node.kind != YamlNode::Kind::list)
            fail_expected(node, key, "a number, three [r, g, b] or {texture: NAME}");
        return map.rgb(key, kZeroToOne);
    }
    const YamlMap reference(node, key);
    reference.allow_only({"texture", "scale"});
    const NamedTexture& named = known_texture(reference, textures);
    SurfaceColor color(reference.rgb_or("scale", kNonNegative, Rgb(1)));
    color.texture = named.texture;
    require_at_most_one(node.where, key, named, color.value);
    return color;
}

}  // namespace tallow
