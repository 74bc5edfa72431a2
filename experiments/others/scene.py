# SPDX-License-Identifier: Apache-2.0
"""A tallow case as plain numbers, for renderers that cannot read it.

Reads what the standard cases hold: one camera, one body (mesh or sphere) of one medium or of an
opaque diffuse material, quad lights and a constant environment. All else is refused with its place.
Lengths in mm, coefficients in 1/mm, angles in radians, radiance in W/(sr mm^2), vectors as numpy
arrays of double.
"""
import dataclasses
import functools
import math
import pathlib

import numpy as np
import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
CASES = ROOT / "experiments/cases"
PRESETS = ROOT / "data/materials.yaml"
MM_PER_UNIT = {"mm": 1.0, "cm": 10.0, "m": 1000.0}

# [NGD06] table 2, as common/scene/presets.cpp reads it: the unit of its coefficients in 1/mm, and
# the tank that the liquids went into.
TABLE_UNIT = 1e-2
TANK_MILLILITRES = 23000


class InputError(Exception):
    """What is wrong with a file, and where; programs exit with 3."""


@dataclasses.dataclass(frozen=True)
class Camera:
    """A pinhole camera; `fov` is the vertical field of view."""
    position: np.ndarray
    look_at: np.ndarray
    up: np.ndarray
    fov: float
    width: int
    height: int

    def axes(self):
        """Unit vectors to the right, up and forward, as rows."""
        forward = unit(self.look_at - self.position)
        right = unit(np.cross(forward, self.up))
        return np.stack([right, np.cross(right, forward), forward])

    def direction(self, x, y):
        """Unit direction through (x, y) in pixels; (0, 0) is the top left corner."""
        right, up, forward = self.axes()
        pixel = 2 * math.tan(self.fov / 2) / self.height
        return unit(forward + (x - self.width / 2) * pixel * right
                    + (self.height / 2 - y) * pixel * up)


@dataclasses.dataclass(frozen=True)
class Sphere:
    center: np.ndarray
    radius: float


@dataclasses.dataclass(frozen=True)
class Mesh:
    """Flat triangles, counter-clockwise from outside."""
    vertices: np.ndarray  # (n, 3)
    faces: np.ndarray     # (m, 3) indices


@dataclasses.dataclass(frozen=True)
class Medium:
    """A homogeneous medium behind a smooth boundary; one row entry a channel."""
    sigma_s: np.ndarray
    sigma_a: np.ndarray
    g: float
    eta: float

    @property
    def sigma_t(self):
        return self.sigma_s + self.sigma_a

    @property
    def albedo(self):
        return self.sigma_s / self.sigma_t

    @property
    def sigma_s_prime(self):
        return (1 - self.g) * self.sigma_s


@dataclasses.dataclass(frozen=True)
class Diffuse:
    """An opaque Lambertian surface."""
    reflectance: np.ndarray


@dataclasses.dataclass(frozen=True)
class Quad:
    """A rectangle that shines to the side of `normal`; `u` and `v` are its whole edges."""
    center: np.ndarray
    u: np.ndarray
    v: np.ndarray
    normal: np.ndarray
    radiance: np.ndarray


@dataclasses.dataclass(frozen=True)
class Environment:
    """The same radiance from all directions."""
    radiance: np.ndarray


@dataclasses.dataclass(frozen=True)
class Case:
    file: pathlib.Path
    camera: Camera
    shape: Sphere | Mesh
    material: Medium | Diffuse
    lights: tuple  # of Quad and Environment


def unit(v):
    return v / np.linalg.norm(v)


# ---- YAML with places ----------------------------------------------------------------------------

class Map(dict):
    """A YAML map whose values know their place; `where` is the map's own."""

    def __init__(self, where):
        super().__init__()
        self.where = where
        self.places = {}

    def fail(self, key, expected):
        """Refuses the value of `key`, or its absence."""
        if key not in self:
            raise InputError(f"{self.where}: missing key '{key}'")
        raise InputError(f"{self.places[key]}: {key}: expected {expected}, got {self[key]!r}")

    def allow_only(self, *keys):
        for key in self:
            if key not in keys:
                raise InputError(f"{self.places[key]}: {key}: expected one of {', '.join(keys)}")

    def number(self, key, default=None):
        if key not in self and default is not None:
            return default
        return self._finite(key, self.get(key), "a number")

    def vector(self, key, default=None):
        if key not in self and default is not None:
            return np.asarray(default, float)
        return self._numbers(key, self.get(key), 3)

    def numbers(self, key, count):
        return self._numbers(key, self.get(key), count)

    def colour(self, key):
        """Three numbers; one stands for a grey."""
        value = self.get(key)
        if isinstance(value, list):
            return self._numbers(key, value, 3)
        return np.full(3, self._finite(key, value, "a number or three [r, g, b]"))

    def choice(self, key, table):
        if self.get(key) not in table:
            self.fail(key, "one of " + ", ".join(table))
        return table[self[key]]

    def only(self, key):
        """The single value of the list or map at `key`."""
        value = self.get(key)
        if not isinstance(value, (list, Map)) or len(value) != 1:
            self.fail(key, "exactly one entry")
        return next(iter(value.values() if isinstance(value, Map) else value))

    def _finite(self, key, value, expected):
        try:
            number = float(value)  # PyYAML takes 1e-12 for text
        except (TypeError, ValueError):
            self.fail(key, expected)
        if isinstance(value, bool) or not math.isfinite(number):
            self.fail(key, expected)
        return number

    def _numbers(self, key, value, count):
        expected = f"{count} numbers"
        if not isinstance(value, list) or len(value) != count:
            self.fail(key, expected)
        return np.array([self._finite(key, item, expected) for item in value])


def _convert(node, loader, file):
    if isinstance(node, yaml.SequenceNode):
        return [_convert(item, loader, file) for item in node.value]
    if not isinstance(node, yaml.MappingNode):
        return loader.construct_object(node)
    result = Map(_place(node, file))
    for key_node, value_node in node.value:
        key = loader.construct_object(key_node)
        if key in result:
            raise InputError(f"{_place(key_node, file)}: {key}: expected each key once")
        result[key] = _convert(value_node, loader, file)
        result.places[key] = _place(value_node, file)
    return result


def _place(node, file):
    return f"{file}:{node.start_mark.line + 1}:{node.start_mark.column + 1}"


def parse_yaml(text, file):
    """The map that `text` holds; `file` is what messages call it."""
    loader = yaml.SafeLoader(text)
    try:
        node = loader.get_single_node()
        if not isinstance(node, yaml.MappingNode):
            raise InputError(f"{file}:1:1: expected a map")
        return _convert(node, loader, file)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        raise InputError(f"{file}:{mark.line + 1}:{mark.column + 1}: {error.problem}") from None
    finally:
        loader.dispose()


def read_yaml(path):
    try:
        return parse_yaml(pathlib.Path(path).read_text(), path)
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read: {error}") from None


# ---- media ---------------------------------------------------------------------------------------

@functools.cache
def _presets():
    return read_yaml(PRESETS)


def _coefficients(map, eta, g):
    """sigma_s, sigma_a, g and eta from `sigma_a` with `sigma_s_prime` or `sigma_s`."""
    if "sigma_s" in map:
        scattering = map.colour("sigma_s")
    else:
        scattering = map.colour("sigma_s_prime") / (1 - g)
    return Medium(scattering, map.colour("sigma_a"), g, eta)


def _preset(map):
    preset = map.choice("preset", _presets())
    eta = map.number("eta", preset.number("eta"))
    if "volume_ml" not in preset:
        return _coefficients(preset, eta, map.number("g", 0.0))
    share = map.number("dilution", 1.0) * TABLE_UNIT * TANK_MILLILITRES / preset.number("volume_ml")
    cosines, scattering = preset.colour("g"), preset.colour("scattering")
    g = map.number("g", float(np.mean(cosines[scattering > 0])) if np.any(scattering > 0) else 0.0)
    reduced = share * (1 - cosines) * scattering
    return Medium(reduced / (1 - g), share * preset.colour("absorption"), g, eta)


def read_material(map):
    """A Medium or a Diffuse from a scene's material."""
    if map.choice("type", {"subsurface": False, "diffuse": True}):
        map.allow_only("type", "reflectance")
        return Diffuse(map.colour("reflectance"))
    map.allow_only("type", "preset", "dilution", "sigma_s", "sigma_s_prime", "sigma_a", "g", "eta",
                   "model", "single_scattering", "exit")
    if "preset" in map:
        return _preset(map)
    return _coefficients(map, map.number("eta"), map.number("g", 0.0))


def find_material(text):
    """A medium of experiments/cases/media.yaml by name, or a map such as {type: diffuse, ..}."""
    if text.lstrip().startswith("{"):
        return read_material(parse_yaml(text, "MEDIUM"))
    media = read_yaml(CASES / "media.yaml")
    if text not in media:
        raise InputError(f"MEDIUM: expected one of {', '.join(media)} or a map, got '{text}'")
    return read_material(media[text])


# ---- shapes, lights, camera ----------------------------------------------------------------------

def rotation(axis, degrees):
    """Right-handed rotation about `axis` (Rodrigues), 3x3."""
    x, y, z = unit(np.asarray(axis, float))
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = math.radians(degrees)
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


def read_transform(steps, mm_per_unit):
    """The steps in order, as (linear 3x3, translation): x -> linear x + translation."""
    linear, translation = np.eye(3), np.zeros(3)
    for step in steps:
        step.allow_only("scale", "rotate_deg", "translate")
        if "translate" in step:
            translation = translation + mm_per_unit * step.vector("translate")
            continue
        if "rotate_deg" in step:
            *axis, degrees = step.numbers("rotate_deg", 4)
            matrix = rotation(axis, degrees)
        else:
            matrix = np.diag(step.colour("scale"))
        linear, translation = matrix @ linear, matrix @ translation
    return linear, translation


def _load_mesh(map, folder):
    import trimesh
    path = folder / str(map.get("file"))
    try:
        return trimesh.load(path, process=False, force="mesh")
    except Exception as error:  # trimesh raises what its readers happen to raise
        raise InputError(f"{map.places.get('file', map.where)}: file: {path}: {error}") from None


def _read_mesh(map, folder, mm_per_unit):
    map.allow_only("shape", "file", "material", "normals", "transform")
    if map.get("normals", "flat") != "flat":
        map.fail("normals", "flat")
    loaded = _load_mesh(map, folder)
    linear, translation = read_transform(map.get("transform", []), mm_per_unit)
    vertices = mm_per_unit * np.asarray(loaded.vertices, float) @ linear.T + translation
    faces = np.asarray(loaded.faces)
    if signed_volume(vertices, faces) < 0:  # the file's winding, or a mirroring scale
        faces = faces[:, ::-1]
    return Mesh(vertices, np.ascontiguousarray(faces))


def signed_volume(vertices, faces):
    """Volume inside a closed mesh, negative if its triangles run clockwise from outside."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def _read_shape(map, folder, mm_per_unit):
    if map.choice("shape", {"mesh": True, "sphere": False}):
        return _read_mesh(map, folder, mm_per_unit)
    map.allow_only("shape", "center", "radius", "material")
    return Sphere(mm_per_unit * map.vector("center", [0, 0, 0]), mm_per_unit * map.number("radius"))


def _read_up(map, forward):
    up = map.vector("up", [0, 1, 0])
    # As tallow: seen straight from above or below, north is up.
    if "up" not in map and np.linalg.norm(np.cross(forward, up)) < 1e-3:
        return np.array([0.0, 0.0, -1.0])
    return up


def _read_camera(map, mm_per_unit):
    map.allow_only("type", "position", "look_at", "up", "fov_deg", "resolution")
    position, look_at = (mm_per_unit * map.vector(key) for key in ("position", "look_at"))
    width, height = map.numbers("resolution", 2)
    return Camera(position, look_at, _read_up(map, unit(look_at - position)),
                  math.radians(map.number("fov_deg")), int(width), int(height))


def _read_light(map, mm_per_unit):
    if map.choice("type", {"environment": True, "quad": False}):
        map.allow_only("type", "group", "radiance")
        return Environment(map.colour("radiance"))
    map.allow_only("type", "group", "position", "look_at", "up", "size", "radiance")
    position, look_at = (mm_per_unit * map.vector(key) for key in ("position", "look_at"))
    up = _read_up(map, unit(look_at - position))
    return make_quad(position, look_at, up, mm_per_unit * map.numbers("size", 2),
                     map.colour("radiance"))


def make_quad(center, look_at, up, size, radiance):
    """A rectangle of [width, height] about `center` that shines towards `look_at`."""
    normal = unit(look_at - center)
    right = unit(np.cross(normal, up))
    return Quad(center, size[0] * right, size[1] * np.cross(right, normal), normal, radiance)


def find_case(name):
    """The file of a standard case by name, or `name` itself."""
    known = CASES / f"{name}.yaml"
    return known if known.is_file() else pathlib.Path(name)


def load_case(name, material=None):
    """Reads a case by name or file; `material` takes the place of its body's. Raises InputError."""
    file = find_case(name)
    map = read_yaml(file)
    map.allow_only("unit", "cameras", "materials", "objects", "lights", "settings")
    mm_per_unit = map.choice("unit", MM_PER_UNIT) if "unit" in map else 1.0
    if not isinstance(map.get("lights"), list):
        map.fail("lights", "a list")
    return Case(file, _read_camera(map.only("cameras"), mm_per_unit),
                _read_shape(map.only("objects"), file.parent, mm_per_unit),
                material or read_material(map.only("materials")),
                tuple(_read_light(light, mm_per_unit) for light in map["lights"]))
