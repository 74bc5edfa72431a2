# SPDX-License-Identifier: Apache-2.0
"""Total error against total time: tallow beside other renderers, against volumetric truth."""
import csv
import dataclasses
import functools
import hashlib
import math
import os
import pathlib
import sys
import types
import typing

import numpy

from others import error_curve, passes, scene

from .. import fits, plots, programs, words
from ..cases import ROOT, cases_named
from ..images import read_image
from ..section import Plot, Section, Table
from ..suite import InputError, require, require_each
from .model import MODELS

NAME = "total"
OTHERS = ROOT / "experiments/others"
REFERENCE = "tallow-reference"
MITSUBA = "mitsuba"
CYCLES = ("cycles-random-walk", "cycles-burley")
BPY_PYTHON = "TALLOW_BPY_PYTHON"  # environment: a Python that has bpy

# Same model as the truth: their means have no error of their own, and their noise goes to 0.
UNBIASED = (MITSUBA, REFERENCE)

TARGETS = (0.10, 0.05, 0.02, 0.01)  # relRMSE of the table
SHARES = (1 / 16, 1 / 8, 1 / 4, 1 / 2, 1)  # of the time, where other renderers' curves are read
SEED = 2  # of tallow-reference; the truth was made with 1 and must be independent
FLAT = 1.2  # chosen: a line has ended if the last step of the tolerance gained less than this
BEYOND = 30  # chosen: a line that ends at a floor is drawn on so many times its measured time


@dataclasses.dataclass
class Settings:
    cases: list[str] | typing.Literal["all"] = dataclasses.field(
        default_factory=lambda: ["sphere-marble"])
    models: list[typing.Literal[tuple(MODELS)]] = dataclasses.field(
        default_factory=lambda: ["body-aware", "transport"])
    tolerances: list[float] = dataclasses.field(default_factory=lambda: [0.1, 0.03, 0.01, 0.003])
    samples: int = 16       # camera rays a pixel, ours
    renderers: list[typing.Literal[(MITSUBA, REFERENCE, *CYCLES)]] = dataclasses.field(
        default_factory=lambda: [MITSUBA, REFERENCE])  # beside ours; may be empty
    seconds: float = 120    # of rendering, each of the others

    def __post_init__(self):
        cases_named(self.cases)
        require_each(self, "models", lambda _: True, "models")
        require_each(self, "numbers in (0, 1)", lambda t: 0 < t < 1, "tolerances")
        require(self, "samples", "an integer in [1, 65536]", lambda n: 1 <= n <= 65536)
        require(self, "seconds", "a number in (0, 1e6]", lambda s: 0 < s <= 1e6)


# --- measuring -----------------------------------------------------------------------------------

def measure(settings, bench):
    for case in cases_named(settings.cases):
        if not case.reference.exists():
            bench.say(f"{NAME}: {case.name}: no reference {case.reference}")
            continue
        for model in settings.models:
            for tolerance in settings.tolerances:
                _measure_ours(settings, bench, case, model, tolerance)
        for renderer in settings.renderers:
            if reason := unavailable(renderer):
                bench.say(f"{NAME}: {renderer} is left out: {reason}")
                continue
            try:
                _measure_other(settings, bench, case, renderer)
            except programs.ProgramFailed as error:  # the rest of the suite does not need it
                bench.say(f"{NAME}: {renderer} is left out: {error}")


@functools.cache
def _truth(path):
    try:
        return error_curve.Truth(path)
    except scene.InputError as error:  # the other renderers' own
        raise InputError(str(error)) from None


def _row(case, mean, variance, seconds):
    """Errors of a picture (h, w, 3) over the pixels that count for all renderers."""
    truth = _truth(case.reference)
    if mean.shape != truth.R.shape:
        raise InputError(f"{case.reference}: expected the size of the scene's camera, "
                         f"{mean.shape[1]} x {mean.shape[0]} pixels")
    return truth.row(types.SimpleNamespace(mean=mean, variance=variance, seconds=seconds,
                                           startup_seconds=0.0, spp=0))


def _measure_ours(settings, bench, case, model, tolerance):
    def how():
        rows, command = [], ""
        for _ in range(bench.repeat):
            row, command = _render_ours(settings, bench, case, model, tolerance)
            rows.append(row)
        return {name: [row[name] for row in rows]
                for name in ("seconds", "relRMSE", "bias")}, command

    bench.measure(NAME, case.name, model, "tolerance", tolerance, how, samples=settings.samples,
                  inputs=case.fingerprint())


def _render_ours(settings, bench, case, model, tolerance):
    """Both passes from nothing: errors with the seconds of both processes, and the commands."""
    accuracy = ["--tolerance", str(tolerance)]
    cache, first = bench.cache(case, *accuracy, material=MODELS[model])
    path, second = bench.image(case, cache, f"{case.name}-total", *accuracy, "--samples",
                               settings.samples, layers="scattered", material=MODELS[model])
    picture = read_image(path)["scattered"].astype(float)
    row = _row(case, picture, numpy.zeros_like(picture), first.seconds + second.seconds)
    return row, f"{first.command} && {second.command}"


def _measure_other(settings, bench, case, renderer):
    """A curve: one render, read after parts of its time."""
    @functools.cache
    def curve():
        if renderer == REFERENCE:
            return _reference_curve(settings, bench, case)
        return _other_curve(settings, bench, case, renderer)

    def how(seconds):
        rows, command = curve()
        return _quantities(nearest(rows, seconds), renderer), command

    # What other renderers do does not change with our programs, and is not repeated.
    identity = {} if renderer == REFERENCE else {"programs": _version_of_other(renderer)}
    for share in SHARES:
        bench.measure(NAME, case.name, renderer, "seconds", settings.seconds * share,
                      lambda share=share: how(settings.seconds * share),
                      of=settings.seconds, inputs=case.fingerprint(), repeat=1, **identity)


def _quantities(row, renderer):
    result = {"seconds": row["seconds"], "startup_seconds": row["startup_seconds"],
              "relRMSE": row["relRMSE"], "bias": row["bias"], "own_noise": row["noise"]}
    if renderer not in UNBIASED:
        result["floor"] = row["floor"]
    return {name: [number] for name, number in result.items()}


def nearest(rows, seconds):
    """The row of a curve whose time is nearest, by ratio."""
    return min(rows, key=lambda row: abs(math.log(row["seconds"] / seconds)))


def _other_curve(settings, bench, case, renderer):
    file = bench.work / f"{case.name}-{renderer}.csv"
    words_of = [OTHERS / "error_curve.py", case.figure, case.medium, case.reference,
                "--renderer", renderer, "--seconds", settings.seconds, "-o", file]
    python = python_of(renderer)
    programs.run(python.name, *words_of, bin=python.parent, stats=False)
    with open(file, newline="", encoding="utf-8") as lines:
        rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(lines)]
    return rows, programs.shown(words_of)


def _reference_curve(settings, bench, case):
    """Our tracer, stopped and resumed; the seconds are those of its processes added up."""
    path = bench.work / f"{case.name}-{REFERENCE}.exr"
    for old in (path, pathlib.Path(f"{path}.checkpoint")):
        old.unlink(missing_ok=True)
    rows, seconds, command = [], 0.0, ""
    for share in SHARES:
        run = programs.run(REFERENCE, case.scene, "-o", path, *case.flags(), "--seed", SEED,
                           "--seconds", settings.seconds * share, *(["--resume"] if rows else []))
        seconds += run.seconds
        channels = passes.read_exr(path)
        rows.append(_row(case, passes.layer(channels, "", path),
                         passes.layer(channels, "variance", path), seconds))
        command = command or run.command
    return rows, command


# --- what there is -------------------------------------------------------------------------------

PROBE = """
import sys
sys.path.insert(0, {path!r})
try:
    {attempt}
except Exception as error:
    sys.exit(str(error))
"""
ATTEMPTS = {
    MITSUBA: "from others import mitsuba_render as m; "
             "print(m.load_mitsuba(m.VARIANTS[0]).__version__)",
    **dict.fromkeys(CYCLES, "import bpy, OpenEXR, trimesh, yaml; print(bpy.app.version_string)"),
}


def python_of(renderer):
    """The Python that runs it."""
    named = os.environ.get(BPY_PYTHON) if renderer in CYCLES else None
    return pathlib.Path(named or sys.executable).absolute()


@functools.cache
def _probe(renderer, python):
    """Version (or None), and why there is none."""
    code = PROBE.format(path=str(OTHERS.parent), attempt=ATTEMPTS[renderer])
    try:
        run = programs.run(python.name, "-c", code, bin=python.parent, stats=False)
        return run.stdout.strip().splitlines()[-1], ""
    except programs.ProgramFailed as error:
        return None, str(error).strip().splitlines()[-1]


def unavailable(renderer):
    """Why a renderer cannot be used; empty if it can."""
    if renderer == REFERENCE:
        there = (ROOT / "build/release/bin" / REFERENCE).exists()
        return "" if there else "it has not been built"
    version, error = _probe(renderer, python_of(renderer))
    if version:
        return ""
    hint = f"; {BPY_PYTHON} may name a Python that has bpy" if renderer in CYCLES else ""
    return error + hint


def _version_of_other(renderer):
    """Changes with the renderer and with the programs that drive it."""
    digest = hashlib.sha256()
    for path in sorted(OTHERS.glob("*.py")):
        if not path.name.startswith(("test_", "check_scenes")):
            digest.update(path.read_bytes())
    return f"{_probe(renderer, python_of(renderer))[0]} {digest.hexdigest()[:16]}"


# --- reading lines -------------------------------------------------------------------------------

@dataclasses.dataclass(frozen=True)
class NoiseLine:
    """error^2 = floor^2 + noise^2 seconds / t: a renderer that was measured for `seconds`."""
    seconds: float
    noise: float
    floor: float = 0.0

    def error_at(self, seconds):
        return math.sqrt(self.floor ** 2 + self.noise ** 2 * self.seconds / seconds)

    def seconds_to(self, error):
        """Infinite at and below the floor."""
        return error_curve.seconds_to([vars(self)], error, self.floor)

    def beyond(self, least=TARGETS[-1], count=20):
        """Seconds and errors to draw dashed: on to the error `least`, or along the floor."""
        end = self.seconds_to(least)
        end = BEYOND * self.seconds if math.isinf(end) else end
        if end <= self.seconds:
            return [], []
        times = list(numpy.geomspace(self.seconds, end, count))
        return times, [self.error_at(t) for t in times]


def noise_line(points, renderer):
    """The line that another renderer's longest measurement gives."""
    last = max(points, key=lambda p: p.median("seconds"))
    floor = 0.0 if renderer in UNBIASED else last.median("floor")
    return NoiseLine(last.median("seconds"), last.median("own_noise"), floor)


def floor_of_ours(points):
    """relRMSE at the finest tolerance: what is left is the model's, if has_ended()."""
    return min(points, key=lambda p: p.value).median("relRMSE")


def has_ended(points):
    """Whether a finer tolerance would gain little: the finest error is the model's."""
    errors = [p.median("relRMSE") for p in sorted(points, key=lambda p: p.value)]
    return len(errors) > 1 and errors[1] < FLAT * errors[0]


def duration(seconds):
    """As words.seconds, hours from two hours on."""
    return words.seconds(seconds) if seconds < 7200 else f"{words.significant(seconds / 3600)} h"


def not_reached(floor):
    return f"not reached: floor {words.percent(floor)}"


def ours_to(points, error):
    """A table's cell: the time to an error, read between measured tolerances."""
    reached = [p for p in points if p.median("relRMSE") <= error]
    if not reached and not has_ended(points):
        return f"not reached: {words.percent(floor_of_ours(points))} at the finest tolerance"
    if not reached:
        return not_reached(floor_of_ours(points))
    between = fits.median_at(points, error)
    if between is not None:
        return duration(between)
    return f"at most {duration(min(p.median('seconds') for p in reached))}"


def other_to(line, error, first=0.0):
    """A table's cell: the time to an error along a line that began `first` s after its start."""
    seconds = line.seconds_to(error)
    if math.isinf(seconds):
        return not_reached(line.floor)
    if seconds < first:
        return f"at most {duration(first)}"
    return duration(seconds) + (" (extrapolated)" if seconds > line.seconds else "")


# --- reporting -----------------------------------------------------------------------------------

TEXT = """
How long until a picture is within so many per cent of the truth, when nothing is there yet. Ours \
is the time of both whole processes, pass one and pass two, nothing reused, at tolerances of \
{tolerances} with {samples} camera rays a pixel. Mitsuba and Cycles are given {seconds:g} s of \
rendering on the same machine, without their start-up, which is in their favour; our tracer of \
references {seconds:g} s with it, or as long as its least picture takes. All cores are used.

The error is the relRMSE of everything that scattered in the body against volumetric path tracing \
(experiments/references), in the pixels that the body covers and that show no mirror image of a \
lamp: one mask for all. The mean square of the truth's own noise has been taken off.

A tolerance is for the sum and its samples, not for the model: our lines end at the error of the \
model, their floor, which is the error at the finest tolerance; where the last step of the \
tolerance still gained a sixth or more, the line has not ended, and the report says so. Mitsuba \
(`volpathmis`, without depth limit or roulette) and our own tracer of references compute what \
the truth is, so that only their noise is left. It is drawn on, dashed, as time^(-1/2) from the \
variance that they measured themselves. As long as Mitsuba has not met its rare bright paths, \
its variance, and so the time, is too small. Cycles computes another model; its line ends at its \
bias, what is left of its error without its noise.\
"""


def section(settings, bench):
    points = bench.of(NAME)
    cases = cases_named(settings.cases)
    text = TEXT.format(tolerances=words.listed(f"{t:g}" for t in settings.tolerances),
                       samples=settings.samples, seconds=settings.seconds)
    missing = [case.name for case in cases if not case.reference.exists()]
    if missing:
        text += ("\n\nNot measured, because experiments/references holds no truth for them: "
                 f"{', '.join(missing)}.")
    known = [case for case in cases if case.reference.exists()]
    text += "".join(f"\n\n{sentence}" for sentence in _left_out(settings, known, points))
    if known:
        text += "\n\nNoise of the truth: " + ", ".join(
            f"{case.name} {words.percent(noise_of(_truth(case.reference)))}" for case in known)
        text += "."
    lines = {case.name: [p for p in points if p.case == case.name] for case in known}
    return Section("Total error against total time", text,
                   [plot_of(settings, name, own) for name, own in lines.items() if own],
                   tables=[table_of(settings, name, own) for name, own in lines.items() if own])


def noise_of(truth):
    """relRMSE of the truth's noise over the pixels that count."""
    return math.sqrt(truth.noise2) / truth.mean


def _left_out(settings, cases, points):
    for renderer in settings.renderers:
        without = [case.name for case in cases
                   if not any(p.series == renderer and p.case == case.name for p in points)]
        if without:
            reason = unavailable(renderer) or "it failed; its words are in the run's output"
            yield f"{renderer} was left out of {', '.join(without)}: {reason.rstrip('.')}."


def _series(settings, points):
    """(name, its points) of everything that was measured, in the settings' order."""
    for name in dict.fromkeys([*settings.models, *settings.renderers]):
        own = [p for p in points if p.series == name]
        if own:
            yield name, own


def label_of(settings, name):
    return f"tallow, {name}" if name in settings.models else name


def plot_of(settings, case, points):
    figure, axes = plots.empty(plots.axis_label("seconds"), plots.axis_label("relRMSE"), "xy", case)
    style_of = plots.styles([*settings.models, *settings.renderers])
    floors = {}
    for name, own in _series(settings, points):
        style = style_of[name]
        visible = [p for p in own if p.median("relRMSE") > 0]  # noise taken off may leave nothing
        plots.draw_series(axes, visible, "seconds", "relRMSE", style, label_of(settings, name))
        if name in settings.renderers:
            line = noise_line(own, name)
            times, errors = line.beyond()
            plots.draw_dashed(axes, times, [100 * e for e in errors], style)
            floors[name] = line.floor, "bias"
        else:
            _draw_tolerances(axes, visible)
            what = "model error" if has_ended(own) else "finest tolerance"
            floors[name] = floor_of_ours(own), what
    _draw_floors(axes, {name: floor for name, floor in floors.items() if floor[0] > 0}, style_of)
    caption = (f"{case}: error of the picture over seconds from nothing. Numbers beside points are "
               "our tolerances. Dotted levels are where the lines of their colour end.")
    return Plot(f"{NAME}-{case}", plots.finish(figure, axes), caption, points[0].command)


def _draw_tolerances(axes, points):
    for group in crowds(points):
        first, last = group[0].value, group[-1].value
        plots.draw_words(axes, group[0], "seconds", "relRMSE",
                         f"{first:g}" if first == last else f"{first:g} to {last:g}")


def crowds(points):
    """Points from the coarsest tolerance on, in groups too close for words of their own."""
    groups = []
    for point in sorted(points, key=lambda p: -p.value):
        if groups and not _apart(groups[-1][0], point):
            groups[-1].append(point)
        else:
            groups.append([point])
    return groups


def _apart(a, b):
    """Whether words fit between; the factors were chosen for axes of seven and four decades."""
    def ratio(quantity):
        low, high = sorted(p.median(quantity) for p in (a, b))
        return high / low
    return ratio("seconds") > 4 or ratio("relRMSE") > 1.4


def _draw_floors(axes, floors, style_of):
    """Levels with their words, on alternate places: those of two models may be close."""
    ordered = sorted(floors.items(), key=lambda item: item[1][0])
    for place, (name, (level, what)) in enumerate(ordered):
        plots.draw_floor(axes, 100 * level, f"{what}: {words.percent(level)}",
                         style_of[name].color, right=(1, 0.68)[place % 2])


def table_of(settings, case, points):
    """Seconds to each target, a row a renderer."""
    rows = []
    for name, own in _series(settings, points):
        if name in settings.renderers:
            line = noise_line(own, name)
            first = min(p.median("seconds") for p in own)
            rows.append([name, *(other_to(line, target, first) for target in TARGETS),
                         words.percent(line.floor) if line.floor else "no floor"])
        else:
            rows.append([label_of(settings, name), *(ours_to(own, target) for target in TARGETS),
                         words.percent(floor_of_ours(own))
                         + ("" if has_ended(own) else ", still falling")])
    return Table(["renderer", *(f"to {100 * target:g} %" for target in TARGETS), "ends at"], rows,
                 f"{case}: time to an error, from nothing; medians.")
