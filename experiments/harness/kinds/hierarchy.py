# SPDX-License-Identifier: Apache-2.0
"""Error of the hierarchical sum over samples against its time, ours beside the classical criterion.

Against the plain sum over the same samples in double, at points drawn with a fixed seed, by
evaluator-sweep. Samples are lit directly only and single scattering is off, so that every criterion
sums the same kernel.
"""
import dataclasses
import functools

from .. import fits, plots, words
from ..caches import CacheOnDemand
from ..cases import case_named
from ..section import Plot, Section, Table
from ..suite import require, require_each
from ..sweeps import evaluator_sweep

NAME = "hierarchy"

# How a line is called in plots, by the sweep's criterion.
SERIES = {"error": "tolerance", "certified": "certified", "solid-angle": "solid angle",
          "formula": "solid angle, formula"}
OURS = "error", "certified"
FORMULA_MODELS = "dipole", "classic-dipole"
EQUAL_ERRORS = 0.01, 0.001  # where times are compared


@dataclasses.dataclass
class Settings:
    cases: list[str] = dataclasses.field(default_factory=lambda: ["sphere-marble"])
    models: list[str] = dataclasses.field(default_factory=lambda: ["dipole", "transport"])
    samples: list[int] = dataclasses.field(default_factory=lambda: [20_000, 100_000])
    tolerances: list[float] = dataclasses.field(
        default_factory=lambda: [0.1, 0.03, 0.01, 0.003, 0.001, 0.0003])
    certify: list[float] = dataclasses.field(default_factory=lambda: [0.1, 0.01, 0.001])
    solid_angles: list[float] = dataclasses.field(
        default_factory=lambda: [0.6, 0.18, 0.06, 0.018, 0.006])
    resolution: int = 128        # pixels a side; each that sees the body is a point
    budget: float = 5            # seconds that one run of the classical criterion may take
    reference_points: int = 300  # where the plain sum is computed

    def __post_init__(self):
        for name in self.cases:
            case_named(name)
        require_each(self, "integers >= 100", lambda n: n >= 100, "samples")
        require_each(self, "numbers in [1e-9, 1)", lambda t: 1e-9 <= t < 1, "tolerances")
        require_each(self, "numbers in [1e-4, 1)", lambda t: 1e-4 <= t < 1, "certify")
        require_each(self, "numbers > 0", lambda angle: angle > 0, "solid_angles")
        require(self, "resolution", "an integer in [8, 4096]", lambda n: 8 <= n <= 4096)
        require(self, "budget", "a number of seconds > 0", lambda s: s > 0)
        require(self, "reference_points", "an integer >= 10", lambda n: n >= 10)


@dataclasses.dataclass(frozen=True)
class Problem:
    """What is summed: how a series is named in results.csv follows from it."""
    case: str
    model: str
    samples: int

    def series(self, criterion):
        return f"{SERIES[criterion]}, {self.model}, {self.samples} samples"

    def material(self):
        return {"model": self.model, "single_scattering": "off"}


def problems(settings):
    return [Problem(case, model, samples) for case in settings.cases for samples in settings.samples
            for model in settings.models]


# --- measuring -----------------------------------------------------------------------------------

class Line:
    """All settings of a criterion: the sweep measures them together, once any is asked for."""

    def __init__(self, settings, bench, problem, cache, sweep):
        self.settings, self.bench, self.problem = settings, bench, problem
        self.cache, self.sweep = cache, sweep  # sweep: arguments of evaluator_sweep

    @functools.cached_property
    def rows(self):
        """The row of each criterion and setting, and the command."""
        case = case_named(self.problem.case)
        rows, run = evaluator_sweep(
            case.scene, self.cache.path, *case.flags(**self.problem.material()),
            *scene_flags(self.settings), reference=self.settings.reference_points,
            repeat=self.bench.repeat, **self.sweep)
        return {(row["criterion"], float(row["setting"])): row for row in rows}, run.command

    def measure(self, criterion, values):
        for value in values:
            self.bench.measure(NAME, self.problem.case, self.problem.series(criterion),
                               "tolerance" if criterion in OURS else "solid_angle", value,
                               lambda: self.quantities(criterion, value),
                               settings=dataclasses.asdict(self.settings),
                               inputs=case_named(self.problem.case).fingerprint())

    def quantities(self, criterion, value):
        """Nothing for what would have taken longer than the budget."""
        rows, command = self.rows
        row = rows.get((criterion, value))
        if row is None:
            return {}, command
        grouping = float(row["grouping_s"])
        return {"seconds": [grouping + float(run) for run in row["runs_s"].split(";")],
                "relRMSE": [float(row["relRMSE"])], "p99": [float(row["p99"])],
                "max": [float(row["max"])], "samples": [int(row["lit_samples"])],
                "evaluations": [float(row["evaluations_per_point"])]}, command


def scene_flags(settings):
    size = settings.resolution
    return ["--set", f"cameras.main.resolution=[{size},{size}]", "--set", "settings.bounces=0"]


def measure(settings, bench):
    caches = {}
    for problem in problems(settings):
        key = problem.case, problem.samples
        if key not in caches:
            caches[key] = CacheOnDemand(bench, case_named(problem.case), "--points",
                                        problem.samples, "--set", "settings.bounces=0",
                                        name=f"{problem.case}-{problem.samples}")
        measure_problem(settings, bench, problem, caches[key])


def measure_problem(settings, bench, problem, cache):
    ours = Line(settings, bench, problem, cache,
                {"criterion": "error", "accuracy": settings.tolerances,
                 "certify": settings.certify})
    ours.measure("error", settings.tolerances)
    ours.measure("certified", settings.certify)
    for criterion in ["solid-angle"] + ["formula"] * (problem.model in FORMULA_MODELS):
        line = Line(settings, bench, problem, cache,
                    {"criterion": criterion, "accuracy": settings.solid_angles,
                     "budget": settings.budget})
        line.measure(criterion, settings.solid_angles)


# --- telling -------------------------------------------------------------------------------------

def points_of(bench, problem, criterion):
    return [p for p in bench.of(NAME, case=problem.case, series=problem.series(criterion))
            if p.quantities]


def renamed(points, series):
    return [dataclasses.replace(p, series=series) for p in points]


def error_plot(settings, bench, case, model):
    """All criteria at the most samples."""
    problem = Problem(case, model, max(settings.samples))
    points = [p for criterion in SERIES
              for p in renamed(points_of(bench, problem, criterion), SERIES[criterion])]
    figure = plots.error_against_time(points, title=f"{case}, {model}, {problem.samples} samples",
                                      series=list(SERIES.values()))
    return Plot(f"{NAME}-{case}-{model}", figure,
                "Error of the sum over samples against the time of grouping and evaluation: "
                f"{case}, {model}, {words.count(problem.samples)} samples asked for. A point a "
                f"setting; bars from the fastest to the slowest of {bench.repeat} runs.",
                points[0].command)


def growth_points(settings, bench, case, model):
    """Time at 1 % for each criterion and number of lit samples, interpolated."""
    result = []
    for criterion in SERIES:
        for samples in settings.samples:
            points = points_of(bench, Problem(case, model, samples), criterion)
            at = time_at(points, EQUAL_ERRORS[0])
            if at is not None:
                lit = points[0].median("samples")
                result.append(dataclasses.replace(
                    points[0], series=SERIES[criterion], parameter="samples with light", value=lit,
                    quantities={"seconds": [at]}))
    return result


def growth_plot(points, case, model):
    figure = plots.against(points, "value", "seconds", fit=True, series=list(SERIES.values()),
                           title=f"{case}, {model}: time at an error of 1 %")
    return Plot(f"{NAME}-samples-{case}-{model}", figure,
                f"Time to a measured error of {words.percent(EQUAL_ERRORS[0])}, interpolated "
                f"between settings, against the number of samples with light: {case}, {model}.",
                points[0].command)


def time_at(points, error):
    """Seconds at a measured error, interpolated; of the fastest setting if all are better: nobody
    can ask for less."""
    points = [p for p in points if p.median("relRMSE") > 0]
    if points and max(p.median("relRMSE") for p in points) < error:
        return min(p.median("seconds") for p in points)
    return fits.median_at(points, error)


def speedup_rows(settings, bench):
    for problem in problems(settings):
        for error in EQUAL_ERRORS:
            at = {c: time_at(points_of(bench, problem, c), error) for c in SERIES}
            ours, classic, formula = at["error"], at["solid-angle"], at["formula"]
            yield problem, error, at, [classic / ours if classic and ours else None,
                                       formula / ours if formula and ours else None]


def speedup_table(settings, bench):
    rows = []
    for problem, error, at, ratios in speedup_rows(settings, bench):
        rows.append([problem.case, problem.model, words.count(problem.samples),
                     words.percent(error),
                     *("" if at[c] is None else words.seconds(at[c]) for c in SERIES),
                     *("" if ratio is None else words.times(ratio) for ratio in ratios)])
    return Table(["case", "model", "samples", "error", *SERIES.values(), "speed-up",
                  "over the formula"], rows,
                 "Time at equal measured error, interpolated between settings on logarithmic axes, "
                 "or that of the fastest setting if all are better. Empty where no setting was so "
                 "good (or not within the budget), or for a model without a formula.")


def speedup_words(settings, bench):
    """A sentence an error level: from how much to how much faster."""
    for error in EQUAL_ERRORS:
        found = [(ratios[0], problem) for problem, level, _, ratios in
                 speedup_rows(settings, bench) if level == error and ratios[0]]
        if not found:
            yield (f"At {words.percent(error)} the solid-angle criterion had no setting within "
                   f"{words.seconds(settings.budget)} to compare with.")
            continue
        low, high = (pick(found, key=lambda pair: pair[0]) for pick in (min, max))
        yield (f"At an error of {words.percent(error)} cutting the tree by error takes "
               "less time than the solid-angle criterion with the same table, by "
               f"{words.times(low[0])} ({low[1].case}, {low[1].model}, "
               f"{words.count(low[1].samples)} samples)"
               + (f", by {words.times(high[0])} where it gains most ({high[1].case}, "
                  f"{high[1].model}, {words.count(high[1].samples)})." if high != low else "."))


def promise_words(settings, bench):
    """Whether what was asked for was kept."""
    def worst(criterion, error):
        ratios = [(p.median(error) / p.value, p) for problem in problems(settings)
                  for p in points_of(bench, problem, criterion)]
        return max(ratios, key=lambda pair: pair[0])
    mean, at_mean = worst("error", "relRMSE")
    largest, at_largest = worst("certified", "max")
    return (f"With --tolerance, the measured relRMSE was {words.times(mean)} what was asked for at "
            f"most ({words.percent(at_mean.median('relRMSE'))} at {at_mean.value:g}). With "
            "--certify, where every pixel and channel has a proven bound, the largest single error "
            f"was {words.times(largest)} the tolerance (at {at_largest.value:g}).")


def section(settings, bench):
    text = ("The error that the hierarchy alone makes: against the plain sum over the same "
            f"samples, in double, at {settings.reference_points} points drawn with a fixed seed, "
            f"of all that see the body at {settings.resolution} x {settings.resolution} pixels. "
            "Times are of grouping the points and of the evaluation, by the sweep's own clock; "
            "loading and building the tree are not in them. `tolerance` cuts the tree by bounds of "
            "the error, `certified` adds the bounds up and proves them, `solid angle` is the "
            "classical criterion with our table of the profile, and with the dipole's formula "
            "evaluated at each node as it was published.\n\n"
            + " ".join(speedup_words(settings, bench)) + "\n\n" + promise_words(settings, bench))
    lines = []
    for case in settings.cases:
        for model in settings.models:
            lines.append(error_plot(settings, bench, case, model))
            growth = growth_points(settings, bench, case, model)
            if len({p.value for p in growth}) > 1:
                lines.append(growth_plot(growth, case, model))
    return Section("Error of the hierarchy against time", text, plots=lines,
                   tables=[speedup_table(settings, bench)])
