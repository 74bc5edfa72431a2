// SPDX-License-Identifier: Apache-2.0
// What users are told: the exact first line on stderr and the exit code, for flags, scenes, meshes
// and caches that are wrong, through the programs themselves.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <regex>

#include "tests/support/process.h"
#include "tests/support/test_files.h"

namespace tallow::test {
namespace {

using std::filesystem::path;

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
        text.replace(at, from.size(), to);
    return text;
}

// A file's place in a message is where this run of the test put it.
std::string without_folder(const std::string& line, const path& folder) {
    return replaced(replaced(line, folder.string() + "/", ""), folder.string(), "FOLDER");
}

constexpr const char* kScene = R"(cameras:
  main: {type: perspective, position: [0, 3, 9], look_at: [0, 0, 0], fov_deg: 40, resolution: [8, 8]}
materials:
  stone: {type: subsurface, preset: marble}
objects:
  - {shape: mesh, file: mesh.off, material: stone}
lights:
  - {type: point, position: [0, 9, 0], intensity: 100}
settings: {samples: 1, light_samples: 1}
)";

constexpr const char* kTetrahedron =
    "OFF\n4 4 0\n0 0 0\n2 0 0\n0 2 0\n0 0 2\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

/// A folder with a good scene, mesh and cache, to be spoilt.
path good_folder() {
    const path folder = fresh_folder();
    write_bytes(folder / "scene.yaml", kScene);
    write_bytes(folder / "mesh.off", kTetrahedron);
    const Result made = precompute(
        {folder / "scene.yaml", "-o", folder / "scene.tallow", "--spacing", "0.5", "--quiet"});
    EXPECT_EQ(made.exit_code, 0) << made.err;
    return folder;
}

struct Row {
    std::string replace, by;  // in the file that the table is about
    std::string message;
};

// Runs tallow-precompute on the spoilt `file` of a good folder.
void expect_refused(const std::string& file, const std::vector<Row>& rows) {
    const path folder = good_folder();
    const std::string good = read_bytes(folder / file), cache = read_bytes(folder / "scene.tallow");
    for (const Row& row : rows) {
        ASSERT_NE(good.find(row.replace), std::string::npos) << row.replace;
        write_bytes(folder / file, replaced(good, row.replace, row.by));
        const Result result =
            precompute({folder / "scene.yaml", "-o", folder / "scene.tallow", "--quiet"});
        EXPECT_EQ(result.exit_code, 3) << row.by;
        EXPECT_EQ(without_folder(result.first_error_line(), folder),
                  "tallow-precompute: error: " + row.message);
        EXPECT_EQ(read_bytes(folder / "scene.tallow"), cache) << "the old cache must survive";
        EXPECT_FALSE(std::filesystem::exists(folder / "scene.tallow.tmp"));
    }
}

TEST(BadInput, Scenes) {
    expect_refused(
        "scene.yaml",
        {
            {"preset: marble", "preset: granite",
             "scene.yaml:4:37: preset: expected one of apple, apple-juice, budweiser-beer, "
             "chardonnay, chicken1, chicken2, clorox, coke, coors-light-beer, cranberry-juice, "
             "cream, espresso, gatorade, grape-juice, head-and-shoulders-shampoo, ketchup, "
             "lowfat-chocolate-milk, lowfat-milk, lowfat-soy-milk, marble, merlot, "
             "mint-mocha-coffee, pepsi, potato, reduced-milk, regular-chocolate-milk, "
             "regular-milk, regular-soy-milk, ruby-grapefruit-juice, shampoo, skimmilk, skin1, "
             "skin2, spectralon, sprite, strawberry-shampoo, white-grapefruit-juice, "
             "white-zinfandel, wholemilk, got 'granite'"},
            {"preset: marble", "sigma_a: -1, sigma_s_prime: 1, eta: 1.3",
             "scene.yaml:4:38: sigma_a: expected a number >= 0, got '-1'"},
            {"preset: marble", "sigma_a: 0, sigma_s_prime: 0, eta: 1.3",
             "scene.yaml:4:38: sigma_a: expected sigma_a + sigma_s_prime >= 1e-06 in each channel, "
             "got 0 in red"},
            {"preset: marble", "preset: marble, sigma_sp: 1",
             "scene.yaml:4:45: sigma_sp: unknown key, did you mean 'sigma_s'?"},
            {"preset: marble", "preset: marble, preset: skin1",
             "scene.yaml:4:45: preset: given twice, first at scene.yaml:4:29"},
            {"preset: marble", "preset: marble, model: tripole",
             "scene.yaml:4:52: model: expected one of dipole, classic-dipole, better-dipole, "
             "normalized-diffusion, photon-beam-diffusion, transport, body-aware, got 'tripole'"},
            {"preset: marble", "sigma_a: [1, 2], sigma_s_prime: 1, eta: 1.3",
             "scene.yaml:4:38: sigma_a: expected a number or three [r, g, b], got a list of 2"},
            {"preset: marble", "sigma_a: .nan, sigma_s_prime: 1, eta: 1.3",
             "scene.yaml:4:38: sigma_a: expected a number >= 0, got '.nan'"},
            {"preset: marble", "sigma_a: 1.5mm, sigma_s_prime: 1, eta: 1.3",
             "scene.yaml:4:38: sigma_a: expected a number >= 0, got '1.5mm'"},
            {"type: subsurface", "type: jelly",
             "scene.yaml:4:17: type: expected one of subsurface, diffuse, plastic, mirror, got "
             "'jelly'"},
            {"material: stone", "material: marble",
             "scene.yaml:6:45: material: expected one of stone, got 'marble'"},
            {"material: stone", "", "scene.yaml:6:5: missing key 'material'"},
            {"file: mesh.off", "file: lost.off", "lost.off: no such file"},
            {"{shape: mesh, file: mesh.off", "{shape: torus, radius: 1",
             "scene.yaml:6:13: shape: expected one of sphere, cube, plane, disc, mesh, got "
             "'torus'"},
            {"{shape: mesh, file: mesh.off", "{shape: disc, normal: [0, 1, 0], radius: 1",
             "scene.yaml:6:13: shape: a disc encloses no volume, which a subsurface material "
             "needs"},
            {"{shape: mesh, file: mesh.off", "{shape: sphere, radius: 0",
             "scene.yaml:6:29: radius: expected a number > 0, got '0'"},
            {"{shape: mesh, file: mesh.off", "{shape: plane, point: [0, 0, 0], normal: [0, 1, 0]",
             "scene.yaml:6:5: missing key 'radius'"},
            {"type: point", "type: lamp",
             "scene.yaml:8:12: type: expected one of point, directional, spot, quad, disc, "
             "sphere, mesh, environment, got 'lamp'"},
            {"intensity: 100", "intensity: [1, 2, inf]",
             "scene.yaml:8:58: intensity: expected a number >= 0, got 'inf'"},
            {"cameras:", "camera:", "scene.yaml:1:1: camera: unknown key, did you mean 'cameras'?"},
            {"fov_deg: 40", "fov_deg: 180",
             "scene.yaml:2:79: fov_deg: expected an angle in (0, 180) degrees, got '180'"},
            {"resolution: [8, 8]", "resolution: [8, 0]",
             "scene.yaml:2:99: resolution: expected an integer in [1, 65536], got '0'"},
            {"samples: 1,", "samples: 0.5,",
             "scene.yaml:9:21: samples: expected an integer in [1, 65536], got '0.5'"},
            {"settings:", "settings: {samples: 2}\nsettings:",
             "scene.yaml:10:1: settings: given twice, first at scene.yaml:9:1"},
            {"lights:\n", "lights: [\n", "scene.yaml:8:3: wrong YAML: illegal block entry"},
        });
}

TEST(BadInput, Meshes) {
    expect_refused(
        "mesh.off",
        {
            {"3 1 2 3\n", "3 1 2 9\n", "mesh.off: face 3: vertex 9 out of range (4 vertices)"},
            {"3 1 2 3\n", "", "mesh.off: line 9: expected face 3 of 4, got the end of the file"},
            {"4 4 0", "4 3 0", "mesh.off: line 10: expected the end of the file, got '3'"},
            {"2 0 0\n", "2 nan 0\n", "mesh.off: line 4: expected a coordinate, got 'nan'"},
            {"OFF\n", "PLY\n",
             "mesh.off: line 1: expected 'OFF', 'COFF', 'NOFF' or 'CNOFF', got 'PLY'"},
            {"4 4 0", "99999999999 4 0",
             "mesh.off: line 2: 99999999999 vertices do not fit in the 56 bytes that follow"},
            {kTetrahedron, "OFF\n4 3 0\n0 0 0\n2 0 0\n0 2 0\n0 0 2\n3 0 2 1\n3 0 1 3\n3 0 3 2\n",
             "scene.yaml:6:5: mesh.off: a translucent body must enclose a volume, but this mesh is "
             "open: boundary loop of 3 edges, 8.49 long, through (2, 0, 0); close it, or give it "
             "an opaque material"},
            {kTetrahedron, "", "mesh.off: expected a mesh, got an empty file"},
            {"3 0 1 3", "2 0 1", "mesh.off: line 8: expected at least three corners, got 2"},
        });
}

TEST(BadInput, Flags) {
    const path folder = good_folder();
    const std::string scene = folder / "scene.yaml", cache = folder / "scene.tallow";
    const std::string image = folder / "image.exr";
    const auto with = [](std::vector<std::string> first, const std::vector<std::string>& more) {
        first.insert(first.end(), more.begin(), more.end());
        return first;
    };
    const std::vector<std::string> rendering = {scene, "--cache", cache, "-o", image};
    struct FlagRow {
        bool render;
        std::vector<std::string> arguments;
        std::string message;
    };
    const std::vector<FlagRow> rows = {
        {false, {}, "SCENE: expected a scene file"},
        {false, {scene}, "--output: expected a cache file to write"},
        {false,
         {scene, "-o", cache, "--spacing", "0.5mm"},
         "--spacing: expected a number of mm > 0, or auto, got '0.5mm'"},
        {false,
         {scene, "-o", cache, "--spacing", "0"},
         "--spacing: expected a number of mm > 0, or auto, got '0'"},
        {false,
         {scene, "-o", cache, "--points", "1000", "--spacing", "0.5"},
         "--points: expected without --spacing, got both"},
        {false,
         {scene, "-o", cache, "--points", "1k"},
         "--points: expected a number of samples in [1, 4e9], got '1k'"},
        {false,
         {scene, "-o", cache, "--light-samples", "2.5"},
         "--light-samples: expected an integer in [1, 65536], or auto, got '2.5'"},
        {false, {scene, "-o", cache, "--colour"}, "unknown flag '--colour', see --help"},
        {false, {scene, "-o", cache, "-o", cache}, "--output: given 2 times"},
        {false, {scene, "more.yaml", "-o", cache}, "unexpected argument 'more.yaml', see --help"},
        {false,
         {scene, "-o", cache, "--threads", "0"},
         "--threads: expected an integer in [1, 1024], got '0'"},
        {true,
         {scene, "-o", image},
         "--cache: expected a cache file, because the scene has translucent bodies; make one with "
         "tallow-precompute"},
        {true, {scene, "--cache", cache}, "--output: expected an image to write"},
        {true,
         {scene, "--cache", cache, "-o", "image.jpg"},
         "--output: expected a name ending in .exr or .png, got 'image.jpg'"},
        {true, with(rendering, {"--tolerance", "-1"}),
         "--tolerance: expected a number in [0, 1), got '-1'"},
        {true, with(rendering, {"--samples", "0"}),
         "--samples: expected an integer in [1, 65536], got '0'"},
        {true, with(rendering, {"--camera", "side"}), "--camera: expected one of main, got 'side'"},
        {true, with(rendering, {"--crop", "0,0,9,8"}),
         "--crop: expected four integers X0,Y0,X1,Y1 inside 8 x 8 pixels, got '0,0,9,8'"},
        {true, with(rendering, {"--crop", "4,4,4,8"}),
         "--crop: expected four integers X0,Y0,X1,Y1 inside 8 x 8 pixels, got '4,4,4,8'"},
        {true, with(rendering, {"--aovs", "depth"}),
         "--aovs: expected all, none or some of multiple, single, diffuse, specular, "
         "transmitted, emission, "
         "scattered, exitance, error_bound, albedo, N, P, Z, evaluations, got 'depth'"},
        {true, with(rendering, {"--certify", "0.00001"}),
         "--certify: expected a number in [1e-4, 1), got '0.00001'"},
        {true, with(rendering, {"--certify", "0.01", "--tolerance", "0.01"}),
         "--certify: expected instead of --tolerance, got both"},
        {true, with(rendering, {"--criterion", "angle"}),
         "--criterion: expected error or solid-angle, got 'angle'"},
        {true, with(rendering, {"--certify", "0.01", "--criterion", "solid-angle"}),
         "--certify: expected --criterion error, got solid-angle, which has no bound"},
        {true, with(rendering, {"--aovs", "error_bound"}), "--aovs: error_bound needs --certify"},
        {true, with(rendering, {"--aovs", "Z,Z"}), "--aovs: 'Z' is asked for twice"},
        {true, with(rendering, {"--set", "materials.stone.colour=1"}),
         "--set materials.stone.colour: unknown key, expected one of type, preset, dilution, "
         "sigma_a, "
         "sigma_s_prime, sigma_s, diffuse_color, mean_free_path, g, eta, model, single_scattering, "
         "exit, surface, albedo, diffuse_limit, shifts, boundary_elements, re_entry, "
         "transmission"},
        {true, with(rendering, {"--set", "materials.wax.eta=1.4"}),
         "--set materials.wax.eta: materials has no 'wax'"},
        {true, with(rendering, {"--set", "eta"}), "--set: expected KEY=VALUE, got 'eta'"},
    };
    for (const FlagRow& row : rows) {
        const Result result = row.render ? render(row.arguments) : precompute(row.arguments);
        EXPECT_EQ(result.exit_code, 2) << row.message;
        EXPECT_EQ(
            without_folder(result.first_error_line(), folder),
            (row.render ? "tallow-render: usage: " : "tallow-precompute: usage: ") + row.message);
        EXPECT_FALSE(std::filesystem::exists(image));
    }
}

// Runs tallow-render with the bytes as its cache.
void expect_cache_refused(const path& folder, const std::string& bytes,
                          const std::string& message) {
    static const std::regex checksum("[0-9a-f]{16}");
    write_bytes(folder / "bad.tallow", bytes);
    const Result result = render(
        {folder / "scene.yaml", "--cache", folder / "bad.tallow", "-o", folder / "image.exr"});
    EXPECT_EQ(result.exit_code, 3);
    const std::string line = without_folder(result.first_error_line(), folder);
    EXPECT_EQ(std::regex_replace(line, checksum, "CHECKSUM"), "tallow-render: error: " + message);
    EXPECT_FALSE(std::filesystem::exists(folder / "image.exr"));
}

TEST(BadInput, Caches) {
    const path folder = good_folder();
    const std::string good = read_bytes(folder / "scene.tallow");
    const auto with_byte = [&](std::size_t at, char value) {
        std::string bytes = good;
        bytes[at] = value;
        return bytes;
    };
    expect_cache_refused(folder, "", "bad.tallow: is empty; re-run tallow-precompute");
    expect_cache_refused(folder, "not a cache at all, but long enough to hold a header of one",
                         "bad.tallow: not a tallow cache: does not begin with TALLOW");
    expect_cache_refused(
        folder, good.substr(0, 20),
        "bad.tallow: cut short: 20 bytes, the header alone has 40; re-run tallow-precompute");
    expect_cache_refused(
        folder, good.substr(0, good.size() - 1),
        fmt::format("bad.tallow: header: expected a file of {} bytes, got {}; re-run "
                    "tallow-precompute",
                    good.size(), good.size() - 1));
    expect_cache_refused(
        folder, good + '\0',
        fmt::format("bad.tallow: header: expected a file of {} bytes, got {}; re-run "
                    "tallow-precompute",
                    good.size(), good.size() + 1));
    expect_cache_refused(
        folder, with_byte(8, 3),
        "bad.tallow: format version 3, but this program reads version 2; re-run tallow-precompute");
    expect_cache_refused(folder, with_byte(60, 99),
                         "bad.tallow: section table: expected checksum CHECKSUM, got CHECKSUM; "
                         "re-run tallow-precompute");
    expect_cache_refused(folder, with_byte(good.size() - 3, char(good[good.size() - 3] ^ 1)),
                         "bad.tallow: section 'directions_indirect' of body 0, group 0: expected "
                         "checksum CHECKSUM, got CHECKSUM; re-run tallow-precompute");
}

TEST(BadInput, MissingFilesAndFolders) {
    const path folder = good_folder();
    const std::string scene = folder / "scene.yaml", cache = folder / "scene.tallow";
    struct FileRow {
        Result result;
        int exit_code;
        std::string message;
    };
    const std::vector<FileRow> rows = {
        {precompute({folder / "lost.yaml", "-o", cache}), 3,
         "lost.yaml: cannot be read: No such file or directory"},
        {precompute({folder, "-o", cache}), 3, "FOLDER: cannot be read: Is a directory"},
        {precompute({scene, "-o", folder / "no/such/folder.tallow", "--quiet"}), 4,
         "no/such/folder.tallow: cannot be written: No such file or directory"},
        {precompute({"--info", folder / "lost.tallow"}), 3,
         "lost.tallow: cannot open: No such file or directory"},
        {render({scene, "--cache", folder / "lost.tallow", "-o", folder / "image.exr"}), 3,
         "lost.tallow: cannot open: No such file or directory"},
        {render({scene, "--cache", cache, "-o", folder / "no/image.exr", "--quiet"}), 4,
         "no/image.exr: cannot be written: No such file or directory"},
        {render({scene, "--cache", cache, "-o", folder / "no/image.png", "--quiet"}), 4,
         "no/image.png: cannot be written: No such file or directory"},
    };
    for (const FileRow& row : rows) {
        EXPECT_EQ(row.result.exit_code, row.exit_code);
        const std::string line = row.result.first_error_line();
        EXPECT_EQ(without_folder(line.substr(line.find(": error: ") + 9), folder), row.message);
    }
}

// The method sees bodies from outside.
TEST(BadInput, CameraInsideABody) {
    const path folder = good_folder();
    const Result result =
        render({folder / "scene.yaml", "--cache", folder / "scene.tallow", "-o",
                folder / "image.exr", "--set", "cameras.main.position=[0.3, 0.3, 0.3]"});
    EXPECT_EQ(result.exit_code, 3);
    EXPECT_EQ(
        without_folder(result.first_error_line(), folder),
        "tallow-render: error: scene.yaml:6:5: camera 'main' is inside this translucent body; "
        "move it outside");
}

}  // namespace
}  // namespace tallow::test
