# SPDX-License-Identifier: Apache-2.0
"""Suites: which experiments to run, with which settings. Files in experiments/suites/."""
import dataclasses
import pathlib
import re
import typing

import yaml


class InputError(Exception):
    """What the user gave is wrong; the message says where and what was expected."""


class BadValue(Exception):
    """A setting that has the right type but makes no sense; `checked` adds the place."""

    def __init__(self, key, expected, value):
        super().__init__(f"{key}: expected {expected}, got {value!r}")
        self.key = key


def require(settings, key, expected, holds):
    """Throws BadValue unless holds(value of `key`); for __post_init__ of Settings."""
    value = getattr(settings, key)
    if not holds(value):
        raise BadValue(key, expected, value)


def require_each(settings, expected, holds, *keys):
    """The same for lists that must not be empty: each item has to hold."""
    for key in keys:
        require(settings, key, f"a list of {expected}",
                lambda items: items and all(holds(item) for item in items))


class Mapping(dict):
    """A mapping of a YAML file that knows where its keys stand."""

    def __init__(self, file, line, column):
        super().__init__()
        self.file, self.line, self.column = file, line, column
        self.places = {}

    def where(self, key=None):
        line, column = self.places.get(key, (self.line, self.column))
        return f"{self.file}:{line}:{column}"


def read_yaml(path):
    """The file's content; mappings are Mapping. Unreadable files and repeated keys are errors."""
    try:
        with open(path, encoding="utf-8") as file:
            node = yaml.compose(file, Loader=yaml.SafeLoader)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        raise InputError(f"{path}:{mark.line + 1}:{mark.column + 1}: {error.problem}") from None
    return _construct(node, path)


def _construct(node, path):
    if isinstance(node, yaml.MappingNode):
        mark = node.start_mark
        result = Mapping(path, mark.line + 1, mark.column + 1)
        for key_node, value_node in node.value:
            key = _construct(key_node, path)
            place = key_node.start_mark.line + 1, key_node.start_mark.column + 1
            if key in result:
                raise InputError(f"{path}:{place[0]}:{place[1]}: {key}: given twice")
            result.places[key] = place
            result[key] = _construct(value_node, path)
        return result
    if isinstance(node, yaml.SequenceNode):
        return [_construct(item, path) for item in node.value]
    return _scalar(node) if node else None


def _scalar(node):
    """As YAML 1.2 has it: on, off, yes, no are text, and 1e-3 is a number."""
    if node.tag == "tag:yaml.org,2002:bool" and node.value.lower() not in ("true", "false"):
        return node.value
    if node.tag == "tag:yaml.org,2002:str" and node.style is None and _EXPONENT.match(node.value):
        return float(node.value)
    return yaml.SafeLoader("").construct_object(node)


_EXPONENT = re.compile(r"[-+]?\d+(\.\d*)?[eE][-+]?\d+$")  # which YAML 1.1 wants a dot and sign in


def checked(cls, mapping):
    """`mapping` as an instance of the dataclass `cls`.

    A key that `cls` does not have, a value of another type, or a missing one without a default is
    an InputError that names the place; so is a BadValue
    or InputError that cls throws when it is made.
    """
    if not isinstance(mapping, Mapping):
        raise InputError(f"expected a mapping for {cls.__name__}, got {mapping!r}")
    fields = {f.name: f for f in dataclasses.fields(cls)}
    types = typing.get_type_hints(cls)
    for key, value in mapping.items():
        if key not in fields:
            raise InputError(f"{mapping.where(key)}: {key}: unknown key, expected one of "
                             + ", ".join(fields))
        if not _is_a(value, types[key]):
            raise InputError(f"{mapping.where(key)}: {key}: expected {_name(types[key])}, "
                             f"got {value!r}")
    for name, field in fields.items():
        required = field.default is dataclasses.MISSING
        if required and field.default_factory is dataclasses.MISSING and name not in mapping:
            raise InputError(f"{mapping.where()}: {name}: missing")
    try:
        return cls(**mapping)
    except BadValue as bad:
        raise InputError(f"{mapping.where(bad.key)}: {bad}") from None
    except InputError as error:
        key = next((key for key in ("cases", "case") if key in mapping), None)
        raise InputError(f"{mapping.where(key)}: {key or cls.__name__}: {error}") from None


def _is_a(value, kind):
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if origin is typing.Literal:
        return any(value is one or (isinstance(value, str) and value == one) for one in arguments)
    if origin is list:
        return isinstance(value, list) and all(_is_a(item, arguments[0]) for item in value)
    if origin is typing.Union or str(type(kind)) == "<class 'types.UnionType'>":
        return any(_is_a(value, one) for one in arguments)
    if kind is float:
        return isinstance(value, (int, float)) and not isinstance(value, bool)
    if kind is int:
        return isinstance(value, int) and not isinstance(value, bool)
    return isinstance(value, kind)


def _name(kind):
    """A type as a user calls it: "a list of a number", "one of on, off"."""
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if origin is typing.Literal:
        return "one of " + ", ".join(map(str, arguments)) if len(arguments) > 1 else arguments[0]
    if origin is list:
        return f"a list, each {_name(arguments[0])}"
    if arguments:
        return " or ".join(map(_name, arguments))
    return {float: "a number", int: "an integer", str: "text", bool: "true or false",
            list: "a list", dict: "a mapping"}.get(kind, getattr(kind, "__name__", str(kind)))


@dataclasses.dataclass
class Suite:
    """A suite's file, checked as far as it does not concern one kind of experiment alone."""
    title: str
    experiments: list
    about: str = ""
    repeat: int = 3        # runs behind each time; medians, least and most are reported
    publish: bool = False  # whether docs/results and README's generated numbers come from it

    def __post_init__(self):
        require(self, "repeat", "an integer of at least 1", lambda n: n >= 1)
        require(self, "experiments", "at least one", bool)


def read_suite(path: pathlib.Path) -> Suite:
    """A suite's file, checked but for the settings of its experiments."""
    mapping = read_yaml(path)
    if not isinstance(mapping, Mapping):
        raise InputError(f"{path}: expected a mapping with a title and experiments")
    suite = checked(Suite, mapping)
    for experiment in suite.experiments:
        if not isinstance(experiment, Mapping) or not isinstance(experiment.get("kind"), str):
            raise InputError(f"{mapping.where('experiments')}: experiments: expected mappings with "
                             f"a `kind`, got {experiment!r}")
    return suite
