// SPDX-License-Identifier: Apache-2.0
// Every refusal of a scene, with its exact message: messages are output.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "common/base/errors.h"
#include "tests/support/error_text.h"
#include "tests/support/scene_text.h"

namespace tallow {
namespace {

std::string input_error(const std::string& text) {
    return error_text<InputError>([&] { parse_scene(text, "scene.yaml"); });
}

struct Row {
    std::string text;  // begins on line 2, behind kCamera
    std::string message;
};

void expect_messages(const std::vector<Row>& rows, const std::string& before = "",
                     const std::string& after = "") {
    for (const Row& row : rows)
        EXPECT_EQ(input_error(kCamera + before + row.text + after), row.message)
            << before + row.text + after;
}

TEST(SceneErrors, Syntax) {
    const std::vector<Row> rows = {
        {"objects: [\n", "scene.yaml:3:1: wrong YAML: end of sequence flow not found"},
        {"unit: \"mm\n", "scene.yaml:2:7: unit: expected one of mm, cm, m, got the text 'mm '"},
        {"\tunit: mm\n", "scene.yaml:2:2: wrong YAML: end of map not found"},
        {"unit: mm\nunit: cm\n", "scene.yaml:3:1: unit: given twice, first at scene.yaml:2:1"},
        {"objects: [{shape: sphere, shape: cube}]\n",
         "scene.yaml:2:27: shape: given twice, first at scene.yaml:2:12"},
        {"? [a, b]\n: c\n",
         "scene.yaml:2:3: expected a key, got a list or map, is a bracket left open?"},
        {"~: 3\n", "scene.yaml:2:1: expected a key, got nothing"},
        {"unit: !!str mm\n", "scene.yaml:2:7: expected no tag, got 'tag:yaml.org,2002:str'"},
        {"--- \nunit: mm\n", "scene.yaml:2:1: expected one document, got a second"},
        {"unit: *mm\n", "scene.yaml:2:7: wrong YAML: the referenced anchor is not defined"},
        {"materials: &m {a: *m}\n",
         "scene.yaml:2:19: an alias may not refer to the list or map that it is in"},
        {"foo: 1\n",
         "scene.yaml:2:1: foo: unknown key, expected one of unit, cameras, textures, materials, "
         "objects, "
         "lights, groups, settings"},
        {"lihgts: []\n", "scene.yaml:2:1: lihgts: unknown key, did you mean 'lights'?"},
        {"units: mm\n", "scene.yaml:2:1: units: unknown key, did you mean 'unit'?"},
        {"\"line\\nbreak\": 1\n",
         "scene.yaml:2:1: line?break: unknown key, expected one of unit, cameras, textures, "
         "materials, "
         "objects, lights, groups, settings"},
        {"materials: [1, 2]\n", "scene.yaml:2:12: materials: expected a map, got a list of 2"},
        {"materials:\n", "scene.yaml:2:1: materials: expected a map, got nothing"},
        {"objects: {}\n", "scene.yaml:2:10: objects: expected a list, got an empty map"},
        {"lights: 3\n", "scene.yaml:2:9: lights: expected a list, got '3'"},
        {"unit: km\n", "scene.yaml:2:7: unit: expected one of mm, cm, m, got 'km'"},
        {"unit: [mm]\n", "scene.yaml:2:7: unit: expected one of mm, cm, m, got a list of 1"},
    };
    expect_messages(rows);
}

TEST(SceneErrors, Materials) {
    const std::vector<Row> rows = {
        {"a: {}", "scene.yaml:2:16: missing key 'type'"},
        {"a: 3", "scene.yaml:2:16: a: expected a map, got '3'"},
        {"a: {type: glass}",
         "scene.yaml:2:23: type: expected one of subsurface, diffuse, plastic, mirror, got "
         "'glass'"},
        {"a: {type: diffuse}", "scene.yaml:2:16: missing key 'reflectance'"},
        {"a: {type: diffuse, reflectance: 1.5}",
         "scene.yaml:2:45: reflectance: expected a number in [0, 1], got '1.5'"},
        {"a: {type: diffuse, reflectance: [0.5, -0.1, 0]}",
         "scene.yaml:2:51: reflectance: expected a number in [0, 1], got '-0.1'"},
        {"a: {type: diffuse, reflectance: [0.5, 0.5]}",
         "scene.yaml:2:45: reflectance: expected a number or three [r, g, b], got a list of 2"},
        {"a: {type: diffuse, reflectance: red}",
         "scene.yaml:2:45: reflectance: expected a number in [0, 1], got 'red'"},
        {"a: {type: diffuse, reflectance: \"0.5\"}",
         "scene.yaml:2:45: reflectance: expected a number in [0, 1], got the text '0.5'"},
        {"a: {type: diffuse, reflectance: .nan}",
         "scene.yaml:2:45: reflectance: expected a number in [0, 1], got '.nan'"},
        {"a: {type: diffuse, reflectance: 0.5x}",
         "scene.yaml:2:45: reflectance: expected a number in [0, 1], got '0.5x'"},
        {"a: {type: diffuse, reflectance: }",
         "scene.yaml:2:32: reflectance: expected a number, three [r, g, b] or {texture: NAME}, got "
         "nothing"},
        {"a: {type: diffuse, reflectence: 1}",
         "scene.yaml:2:32: reflectence: unknown key, did you mean 'reflectance'?"},
        {"a: {type: mirror, eta: 1.5}",
         "scene.yaml:2:31: eta: unknown key, expected one of type, reflectance"},
        {"a: {type: plastic, reflectance: 1, eta: 0.9}",
         "scene.yaml:2:53: eta: expected a relative index in [1, 3], got '0.9'"},
        {"a.b: {type: mirror}",
         "scene.yaml:2:13: expected a name without '.', ',', '=', got 'a.b'"},
        {"a: {type: subsurface}",
         "scene.yaml:2:16: missing key 'preset', 'sigma_a' or 'diffuse_color'"},
        {"a: {type: subsurface, preset: marbel}",
         "scene.yaml:2:43: preset: expected one of apple, apple-juice, budweiser-beer, "
         "chardonnay, chicken1, chicken2, clorox, coke, coors-light-beer, cranberry-juice, "
         "cream, espresso, gatorade, grape-juice, head-and-shoulders-shampoo, ketchup, "
         "lowfat-chocolate-milk, lowfat-milk, lowfat-soy-milk, marble, merlot, "
         "mint-mocha-coffee, pepsi, potato, reduced-milk, regular-chocolate-milk, "
         "regular-milk, regular-soy-milk, ruby-grapefruit-juice, shampoo, skimmilk, skin1, "
         "skin2, spectralon, sprite, strawberry-shampoo, white-grapefruit-juice, "
         "white-zinfandel, wholemilk, got 'marbel'"},
        {"a: {type: subsurface, preset: marble, sigma_a: 1}",
         "scene.yaml:2:51: sigma_a: cannot be given together with 'preset'"},
        {"a: {type: subsurface, sigma_s_prime: 1, preset: marble}",
         "scene.yaml:2:35: sigma_s_prime: cannot be given together with 'preset'"},
        {"a: {type: subsurface, sigma_a: -0.1, sigma_s_prime: 1, eta: 1.3}",
         "scene.yaml:2:44: sigma_a: expected a number >= 0, got '-0.1'"},
        {"a: {type: subsurface, sigma_a: 1, eta: 1.3}",
         "scene.yaml:2:16: missing key 'sigma_s_prime'"},
        {"a: {type: subsurface, sigma_a: 1, sigma_s_prime: 1}",
         "scene.yaml:2:16: missing key 'eta'"},
        {"a: {type: subsurface, sigma_a: 1, sigma_s_prime: 1, sigma_s: 1, eta: 1.3}",
         "scene.yaml:2:65: sigma_s: cannot be given together with 'sigma_s_prime'"},
        {"a: {type: subsurface, sigma_a: [1, 0, 1], sigma_s_prime: [0, 0, 1], eta: 1.3}",
         "scene.yaml:2:44: sigma_a: expected sigma_a + sigma_s_prime >= 1e-06 in each channel, got "
         "0 in green"},
        {"a: {type: subsurface, preset: marble, g: 1}",
         "scene.yaml:2:54: g: expected a number in (-1, 1), got '1'"},
        {"a: {type: subsurface, preset: marble, g: 0.99999999999}",
         "scene.yaml:2:54: g: expected a number in (-1, 1), got '0.99999999999'"},
        {"a: {type: subsurface, preset: marble, eta: 5}",
         "scene.yaml:2:56: eta: expected a relative index in [1, 3], got '5'"},
        {"a: {type: subsurface, sigma_a: 1e39, sigma_s_prime: 1, eta: 1.3}",
         "scene.yaml:2:44: sigma_a: expected a magnitude of at most 1e+12, got '1e39'"},
        {"a: {type: subsurface, sigma_a: 1e13, sigma_s_prime: 1, eta: 1.3}",
         "scene.yaml:2:44: sigma_a: expected a magnitude of at most 1e+12, got '1e13'"},
        {"a: {type: subsurface, preset: marble, model: tripole}",
         "scene.yaml:2:58: model: expected one of dipole, classic-dipole, better-dipole, "
         "normalized-diffusion, photon-beam-diffusion, transport, body-aware, got 'tripole'"},
        {"a: {type: subsurface, preset: marble, single_scattering: yes}",
         "scene.yaml:2:70: single_scattering: expected one of auto, on, off, straight, exact, got "
         "'yes'"},
        {"a: {type: subsurface, preset: marble, shifts: maybe}",
         "scene.yaml:2:59: shifts: expected one of on, off, got 'maybe'"},
        {"a: {type: subsurface, preset: marble, boundary_elements: 2000}",
         "scene.yaml:2:70: boundary_elements: expected one of on, off, got '2000'"},
        {"a: {type: subsurface, preset: marble, exit: lambert}",
         "scene.yaml:2:57: exit: expected one of normalized, classic, directional, got 'lambert'"},
        {"a: {type: subsurface, preset: marble, surface: rough}",
         "scene.yaml:2:60: surface: expected one of smooth, got 'rough'"},
        {"a: {type: subsurface, preset: marble, sigma_x: 1}",
         "scene.yaml:2:51: sigma_x: unknown key, did you mean 'sigma_a'?"},
    };
    expect_messages(rows, "materials: {", "}\n");
}

TEST(SceneErrors, Objects) {
    const std::vector<Row> rows = {
        {"{}", "scene.yaml:3:11: missing key 'shape'"},
        {"7", "scene.yaml:3:11: objects.0: expected a map, got '7'"},
        {"{shape: box}",
         "scene.yaml:3:19: shape: expected one of sphere, cube, plane, disc, mesh, got 'box'"},
        {"{shape: sphere}", "scene.yaml:3:11: missing key 'material'"},
        {"{shape: sphere, material: skin, radius: 1}",
         "scene.yaml:3:37: material: expected one of wax, floor, got 'skin'"},
        {"{shape: sphere, material: wax}", "scene.yaml:3:11: missing key 'radius'"},
        {"{shape: sphere, material: wax, radius: 0}",
         "scene.yaml:3:50: radius: expected a number > 0, got '0'"},
        {"{shape: sphere, material: wax, radius: 1.5mm}",
         "scene.yaml:3:50: radius: expected a number > 0, got '1.5mm'"},
        {"{shape: sphere, material: wax, radius: 1e-30}",
         "scene.yaml:3:50: radius: expected a length in [1e-12, 1e+12] mm, got '1e-30'"},
        {"{shape: sphere, material: wax, radius: 1, centre: [0, 0, 0]}",
         "scene.yaml:3:53: centre: unknown key, did you mean 'center'?"},
        {"{shape: sphere, material: wax, radius: 1, center: [0, 0]}",
         "scene.yaml:3:61: center: expected three numbers [x, y, z], got a list of 2"},
        {"{shape: sphere, material: wax, radius: 1, center: 0}",
         "scene.yaml:3:61: center: expected three numbers [x, y, z], got '0'"},
        {"{shape: cube, material: wax, size: [1, 1]}",
         "scene.yaml:3:46: size: expected a number or three [x, y, z], got a list of 2"},
        {"{shape: cube, material: wax, size: [1, 0, 1]}",
         "scene.yaml:3:50: size: expected a number > 0, got '0'"},
        {"{shape: cube, material: wax, size: 1, radius: 2}",
         "scene.yaml:3:49: radius: unknown key, expected one of shape, material, transform, "
         "center, size"},
        {"{shape: plane, material: wax, point: [0, 0, 0], normal: [0, 1, 0]}",
         "scene.yaml:3:11: missing key 'radius'"},
        {"{shape: plane, material: floor, point: [0, 0, 0], normal: [0, 1, 0], radius: 2}",
         "scene.yaml:3:88: radius: only a plane of subsurface material has a radius"},
        {"{shape: plane, material: floor, point: [0, 0, 0], normal: [0, 0, 0]}",
         "scene.yaml:3:69: normal: expected a direction, got a vector of length 0"},
        {"{shape: disc, material: wax, normal: [0, 1, 0], radius: 1}",
         "scene.yaml:3:19: shape: a disc encloses no volume, which a subsurface material needs"},
        {"{shape: mesh, material: wax}", "scene.yaml:3:11: missing key 'file'"},
        {"{shape: mesh, material: wax, file: \"\"}",
         "scene.yaml:3:46: file: expected a text, got the text ''"},
        {"{shape: mesh, material: wax, file: a.ply, normals: phong}",
         "scene.yaml:3:62: normals: expected one of flat, smooth, got 'phong'"},
        {"{shape: sphere, material: wax, radius: 1, transform: {scale: 1}}",
         "scene.yaml:3:64: transform: expected a list, got a map"},
        {"{shape: sphere, material: wax, radius: 1, transform: [1]}",
         "scene.yaml:3:65: transform: expected a map, got '1'"},
        {"{shape: sphere, material: wax, radius: 1, transform: [{}]}",
         "scene.yaml:3:65: transform: expected one key in each step, got 0"},
        {"{shape: sphere, material: wax, radius: 1, transform: [{scale: 1, translate: [0, 0, 0]}]}",
         "scene.yaml:3:65: transform: expected one key in each step, got 2"},
        {"{shape: sphere, material: wax, radius: 1, transform: [{rotate: [0, 1, 0, 3]}]}",
         "scene.yaml:3:66: rotate: unknown key, expected one of scale, rotate_deg, translate"},
        {"{shape: sphere, material: wax, radius: 1, transform: [{scale: 0}]}",
         "scene.yaml:3:73: scale: expected a factor of magnitude in [1e-06, 1e+06], got "
         "'0'"},
        {"{shape: sphere, material: wax, radius: 1, transform: [{scale: -1}]}",
         "scene.yaml:3:73: scale: expected a number > 0 or three [x, y, z], got '-1'"},
        {"{shape: sphere, material: wax, radius: 1, transform: [{scale: [1, 0, 1]}]}",
         "scene.yaml:3:77: scale: expected a factor of magnitude in [1e-06, 1e+06], got "
         "'0'"},
        {"{shape: sphere, material: wax, radius: 1, transform: [{scale: [1, 2]}]}",
         "scene.yaml:3:73: scale: expected a number > 0 or three [x, y, z], got a list of 2"},
        {"{shape: sphere, material: wax, radius: 1, transform: [{rotate_deg: [0, 0, 0, 9]}]}",
         "scene.yaml:3:78: rotate_deg: expected an axis, got a vector of length 0"},
        {"{shape: sphere, material: wax, radius: 1, transform: [{rotate_deg: [0, 1, 9]}]}",
         "scene.yaml:3:78: rotate_deg: expected four numbers [x, y, z, degrees], got a list of 3"},
        {"{shape: sphere, material: wax, radius: 1, transform: [{scale: 1e6}, {scale: 1e6}]}",
         "scene.yaml:3:64: transform: expected a change of volume in [1e-18, 1e+18] altogether"},
    };
    expect_messages(
        rows,
        "materials: {wax: {type: subsurface, preset: skin1}, floor: {type: mirror}}\nobjects: [",
        "]\n");
}

TEST(SceneErrors, Lights) {
    const std::vector<Row> rows = {
        {"{}", "scene.yaml:2:10: missing key 'type'"},
        {"{type: lamp}",
         "scene.yaml:2:17: type: expected one of point, directional, spot, quad, disc, "
         "sphere, mesh, environment, got 'lamp'"},
        {"{type: point, position: [0, 0, 0]}", "scene.yaml:2:10: missing key 'intensity'"},
        {"{type: point, position: [0, 0, 0], intensity: -1}",
         "scene.yaml:2:56: intensity: expected a number >= 0, got '-1'"},
        {"{type: point, position: [0, 0, 0], intensity: 1, group: a.b}",
         "scene.yaml:2:66: expected a name without '.', ',', '=', got 'a.b'"},
        {"{type: point, position: [0, 0, 0], intensity: 1, radius: 1}",
         "scene.yaml:2:59: radius: unknown key, expected one of type, group, position, intensity"},
        {"{type: point, position: [1e12, 0, 1e13], intensity: 1}",
         "scene.yaml:2:44: position: expected a magnitude of at most 1e+12, got '1e13'"},
        {"{type: directional, direction: [0, 0, 0], irradiance: 1}",
         "scene.yaml:2:41: direction: expected a direction, got a vector of length 0"},
        {"{type: spot, position: [0, 0, 0], intensity: 1, cone_deg: 30}",
         "scene.yaml:2:10: missing key 'look_at' or 'direction'"},
        {"{type: spot, position: [0, 0, 0], intensity: 1, cone_deg: 180}",
         "scene.yaml:2:68: cone_deg: expected an angle in (0, 180) degrees, got '180'"},
        {"{type: spot, position: [0, 0, 0], intensity: 1, cone_deg: 30, inner_deg: 30, direction: "
         "[0, 1, 0]}",
         "scene.yaml:2:83: inner_deg: expected an angle in [0, cone_deg) degrees, got '30'"},
        {"{type: spot, position: [0, 0, 0], look_at: [1, 0, 0], direction: [0, 1, 0], intensity: "
         "1, cone_deg: 30}",
         "scene.yaml:2:64: direction: cannot be given together with 'look_at'"},
        {"{type: spot, position: [1, 0, 0], look_at: [1, 0, 0], intensity: 1, cone_deg: 30}",
         "scene.yaml:2:53: look_at: expected another point than position"},
        {"{type: spot, position: [0, 0, 0], direction: [1, 0, 0], intensity: 1, cone_deg: 1e-9}",
         "scene.yaml:2:90: cone_deg: expected a cone wide enough for a soft edge"},
        {"{type: quad, position: [0, 9, 0], look_at: [0, 0, 0], up: [0, 0.1, 0], size: [1, 1], "
         "radiance: 1}",
         "scene.yaml:2:68: up: expected a direction that is not the direction of view"},
        {"{type: quad, position: [0, 9, 0], look_at: [9, 9, 0], size: 1, radiance: 1}",
         "scene.yaml:2:70: size: expected two numbers [width, height], got '1'"},
        {"{type: quad, position: [0, 9, 0], look_at: [9, 9, 0], size: [1, 1, 1], radiance: 1}",
         "scene.yaml:2:70: size: expected two numbers [width, height], got a list of 3"},
        {"{type: sphere, position: [0, 9, 0], radius: -1, radiance: 1}",
         "scene.yaml:2:54: radius: expected a number > 0, got '-1'"},
        {"{type: environment, radiance: 1}, {type: environment, radiance: 2}",
         "scene.yaml:2:44: expected one environment, got a second; the first is at "
         "scene.yaml:2:10"},
    };
    expect_messages(rows, "lights: [", "]\n");
}

TEST(SceneErrors, GroupsAndSettings) {
    const std::vector<Row> rows = {
        {"groups: {kei: {scale: 1}}\n",
         "scene.yaml:3:10: groups: expected the group of a light, one of key, got 'kei'"},
        {"groups: {key: 2}\n", "scene.yaml:3:15: key: expected a map, got '2'"},
        {"groups: {key: {scale: -1}}\n",
         "scene.yaml:3:23: scale: expected a number >= 0, got '-1'"},
        {"groups: {key: {intensity: 1}}\n",
         "scene.yaml:3:16: intensity: unknown key, expected one of scale"},
        {"settings: {tolerance: 1}\n",
         "scene.yaml:3:23: tolerance: expected a number in [0, 1), got '1'"},
        {"settings: {tolerance: -0.1}\n",
         "scene.yaml:3:23: tolerance: expected a number in [0, 1), got '-0.1'"},
        {"settings: {samples: 0}\n",
         "scene.yaml:3:21: samples: expected an integer in [1, 65536], got '0'"},
        {"settings: {samples: 16.0}\n",
         "scene.yaml:3:21: samples: expected an integer in [1, 65536], got '16.0'"},
        {"settings: {samples: 65537}\n",
         "scene.yaml:3:21: samples: expected an integer in [1, 65536], got '65537'"},
        {"settings: {light_samples: many}\n",
         "scene.yaml:3:27: light_samples: expected an integer in [1, 65536], got 'many'"},
        {"settings: {single_scattering_depths: 0}\n",
         "scene.yaml:3:38: single_scattering_depths: expected an integer in [1, 65536], got '0'"},
        {"settings: {sampels: 1}\n",
         "scene.yaml:3:12: sampels: unknown key, did you mean 'samples'?"},
        {"settings: []\n", "scene.yaml:3:11: settings: expected a map, got an empty list"},
    };
    expect_messages(rows, "lights: [{type: environment, radiance: 1, group: key}]\n");
}

TEST(SceneErrors, Cameras) {
    const std::vector<Row> rows = {
        {"{}", "scene.yaml:1:10: cameras: expected at least one camera, got an empty map"},
        {"{main: {}}", "scene.yaml:1:17: missing key 'type'"},
        {"{main: {type: orthographic}}",
         "scene.yaml:1:24: type: expected one of perspective, thin-lens, got 'orthographic'"},
        {"{main: {type: perspective, position: [0, 0, 1]}}",
         "scene.yaml:1:17: missing key 'look_at'"},
        {"{main: {type: perspective, position: [0, 0, 1], look_at: [0, 0, 1], fov_deg: 40, "
         "resolution: [1, 1]}}",
         "scene.yaml:1:67: look_at: expected another point than position"},
        {"{main: {type: perspective, position: [0, 5, 0], look_at: [0, 0, 0], up: [0, 0, 0], "
         "fov_deg: 40, resolution: [1, 1]}}",
         "scene.yaml:1:82: up: expected a direction, got a vector of length 0"},
        {"{main: {type: perspective, position: [0, 0, 1], look_at: [0, 0, 0], fov_deg: 180, "
         "resolution: [1, 1]}}",
         "scene.yaml:1:87: fov_deg: expected an angle in (0, 180) degrees, got '180'"},
        {"{main: {type: perspective, position: [0, 0, 1], look_at: [0, 0, 0], fov_deg: 40, "
         "resolution: [0, 1]}}",
         "scene.yaml:1:104: resolution: expected an integer in [1, 65536], got '0'"},
        {"{main: {type: perspective, position: [0, 0, 1], look_at: [0, 0, 0], fov_deg: 40, "
         "resolution: 512}}",
         "scene.yaml:1:103: resolution: expected two integers [width, height], got '512'"},
        {"{main: {type: perspective, position: [0, 0, 1], look_at: [0, 0, 0], fov_deg: 40, "
         "resolution: [1, 1], fovx: 3}}",
         "scene.yaml:1:111: fovx: unknown key, expected one of type, position, look_at, up, "
         "fov_deg, resolution, turntable, keyframes"},
        {"{\"\": {type: perspective}}",
         "scene.yaml:1:11: expected a name without '.', ',', '=', got ''"},
    };
    for (const Row& row : rows)
        EXPECT_EQ(input_error("cameras: " + row.text + "\n"), row.message) << row.text;
}

// Rows begin where a camera that is whole but for its motion or lens ends.
void expect_camera_messages(const std::string& type, const std::vector<Row>& rows) {
    const std::string camera = "cameras:\n main:\n  {type: " + type +
                               ", position: [0, 0, 9], look_at: [0, 0, 0], fov_deg: 40, "
                               "resolution: [1, 1],\n";
    for (const Row& row : rows) EXPECT_EQ(input_error(camera + row.text + "}\n"), row.message);
}

TEST(SceneErrors, CameraMotion) {
    const std::vector<Row> rows = {
        {"turntable: 36", "scene.yaml:4:12: turntable: expected a map, got '36'"},
        {"turntable: {axis: [0, 1, 0]}", "scene.yaml:4:12: missing key 'frames'"},
        {"turntable: {frames: 0}",
         "scene.yaml:4:21: frames: expected an integer in [1, 65536], got '0'"},
        {"turntable: {frames: 3, axis: [0, 0, 0]}",
         "scene.yaml:4:30: axis: expected a direction, got a vector of length 0"},
        {"turntable: {frames: 3, degrees: 1e9}",
         "scene.yaml:4:33: degrees: expected an angle in [-36000, 36000] degrees, got '1e9'"},
        {"turntable: {frames: 3, angle: 90}",
         "scene.yaml:4:24: angle: unknown key, expected one of frames, axis, degrees"},
        {"turntable: {frames: 3}, keyframes: [{frame: 0}]",
         "scene.yaml:4:36: keyframes: cannot be given together with 'turntable'"},
        {"keyframes: {frame: 0}", "scene.yaml:4:12: keyframes: expected a list, got a map"},
        {"keyframes: []",
         "scene.yaml:4:12: keyframes: expected at least one keyframe, got an empty list"},
        {"keyframes: [7]", "scene.yaml:4:13: keyframes: expected a map, got '7'"},
        {"keyframes: [{fov_deg: 3}]", "scene.yaml:4:13: missing key 'frame'"},
        {"keyframes: [{frame: -1}]",
         "scene.yaml:4:21: frame: expected an integer in [0, 65535], got '-1'"},
        {"keyframes: [{frame: 0}, {frame: 4}, {frame: 4}]",
         "scene.yaml:4:45: frame: expected a frame after 4, got '4'"},
        {"keyframes: [{frame: 0, up: [0, 1, 0]}]",
         "scene.yaml:4:24: up: unknown key, expected one of frame, position, look_at, fov_deg"},
        {"keyframes: [{frame: 0, position: [1, 2]}]",
         "scene.yaml:4:34: position: expected three numbers [x, y, z], got a list of 2"},
        {"keyframes: [{frame: 0, fov_deg: 200}]",
         "scene.yaml:4:33: fov_deg: expected an angle in (0, 180) degrees, got '200'"},
        {"keyframes: [{frame: 0, position: [0, 0, 0]}]",
         "scene.yaml:4:12: keyframes: expected position and look_at to be apart, got one point in "
         "frame 0"},
        {"keyframes: [{frame: 0}, {frame: 8, position: [0, 0, -9]}]",
         "scene.yaml:4:12: keyframes: expected position and look_at to be apart, got one point in "
         "frame 4"},
        {"keyframes: [{frame: 0}, {frame: 3, position: [0, 9, 0]}]",
         "scene.yaml:4:12: keyframes: expected a view that is not along 'up', got one in frame 3"},
    };
    expect_camera_messages("perspective", rows);
    EXPECT_EQ(input_error("cameras: {a: {type: perspective, resolution: [1, 1], keyframes: "
                          "[{frame: 0, look_at: [0, 0, 0]}]}}\n"),
              "scene.yaml:1:14: missing key 'position'");
}

TEST(SceneErrors, Lenses) {
    const std::vector<Row> rows = {
        {"focus_mm: 9", "scene.yaml:3:3: missing key 'aperture_mm'"},
        {"aperture_mm: 2", "scene.yaml:3:3: missing key 'focus_mm' or 'focus_at'"},
        {"aperture_mm: -2, focus_mm: 9",
         "scene.yaml:4:14: aperture_mm: expected a number >= 0, got '-2'"},
        {"aperture_mm: 2, focus_mm: 0",
         "scene.yaml:4:27: focus_mm: expected a length >= 1e-12 mm, got '0'"},
        {"aperture_mm: 2, focus_mm: 9, focus_at: [0, 0, 0]",
         "scene.yaml:4:40: focus_at: cannot be given together with 'focus_mm'"},
        {"aperture_mm: 2, focus_at: [0, 0, 10]",
         "scene.yaml:4:27: focus_at: expected a point before the camera, got one behind it"},
        {"aperture_mm: 2, focus_at: [0, 0, 8.5], keyframes: [{frame: 0}, {frame: 8, position: [0, "
         "0, 1]}]",
         "scene.yaml:4:27: focus_at: expected a point before the camera, got one behind it in "
         "frame 1"},
    };
    expect_camera_messages("thin-lens", rows);
    expect_camera_messages(
        "perspective",
        {{"aperture_mm: 2",
          "scene.yaml:4:1: aperture_mm: unknown key, expected one of type, position, look_at, up, "
          "fov_deg, resolution, turntable, keyframes"}});
}

// A wrong value that came from a flag is the flag's fault: exit code 2, and no line of the file.
TEST(SceneErrors, Overrides) {
    const std::vector<std::pair<std::string, std::string>> rows = {
        {"unit", "--set: expected KEY=VALUE, got 'unit'"},
        {"=3", "--set: expected KEY=VALUE, got '=3'"},
        {"unit=", "--set unit: expected a value, got nothing"},
        {"unit=[mm", "--set unit: expected a key, got a list or map, is a bracket left open?"},
        {"unit={a: 1, a: 2}", "--set unit: a: given twice, first at --set unit"},
        {"a..b=1", "--set a..b: expected names separated by single dots"},
        {"unit.x=1", "--set unit.x: expected unit to be a map or a list, got 'cm'"},
        {"unit=km", "--set unit: expected one of mm, cm, m, got 'km'"},
        {"materials.candel.eta=1",
         "--set materials.candel.eta: materials has no 'candel', did you mean 'candle'?"},
        {"matter.x=1", "--set matter.x: the scene has no 'matter'"},
        {"materials.candle.sigma_a=-0.1",
         "--set materials.candle.sigma_a: expected a number >= 0, got '-0.1'"},
        {"materials.candle.sigma_a=[1, 2, x]",
         "--set materials.candle.sigma_a: expected a number >= 0, got 'x'"},
        {"materials.candle.sigma=1",
         "--set materials.candle.sigma: unknown key, did you mean 'sigma_a'?"},
        {"materials.body.sigma_a=1",
         "--set materials.body.sigma_a: cannot be given together with 'preset'"},
        {"materials.floor={type: diffuse}", "--set materials.floor: missing key 'reflectance'"},
        {"materials.floor={type: diffuse, reflectance: 2}",
         "--set materials.floor: reflectance: expected a number in [0, 1], got '2'"},
        {"lights.7.radiance=1",
         "--set lights.7.radiance: lights has 7 items, counted from 0, got '7'"},
        {"lights.x=1", "--set lights.x: lights has 7 items, counted from 0, got 'x'"},
        {"groups.kei.scale=1",
         "--set groups.kei.scale: groups: expected the group of a light, one of key, default, "
         "fill, "
         "got 'kei'"},
        {"settings.samples=0.5",
         "--set settings.samples: expected an integer in [1, 65536], got '0.5'"},
    };
    for (const auto& [override_text, message] : rows)
        EXPECT_EQ(error_text<UsageError>([&] { scene_of(kFullScene, {override_text}); }), message);
}

TEST(SceneErrors, Files) {
    const auto file = std::filesystem::path(TALLOW_TEST_OUT) / "wrong.yaml";
    std::ofstream(file) << "unit: km\n";
    EXPECT_EQ(error_text<InputError>([&] { load_scene(file); }),
              file.string() + ":1:7: unit: expected one of mm, cm, m, got 'km'");
    std::ofstream(file) << kCamera;
    EXPECT_EQ(load_scene(file).file, file);
    EXPECT_EQ(error_text<InputError>([] { load_scene("missing.yaml"); }),
              "missing.yaml: cannot be read: No such file or directory");
    EXPECT_EQ(error_text<InputError>([] { load_scene(TALLOW_TEST_OUT); }),
              TALLOW_TEST_OUT ": cannot be read: Is a directory");
    EXPECT_EQ(input_error(""), "scene.yaml:1:1: expected a value, got nothing");
    EXPECT_EQ(input_error("# only a comment\n"), "scene.yaml:1:1: expected a value, got nothing");
    EXPECT_EQ(input_error("3\n"), "scene.yaml:1:1: scene: expected a map, got '3'");
    EXPECT_EQ(input_error("unit: mm\n"), "scene.yaml:1:1: missing key 'cameras'");
}

}  // namespace
}  // namespace tallow
