# SPDX-License-Identifier: Apache-2.0
"""Time and memory of both programs against samples on the surface, pixels, camera rays, threads."""
import dataclasses

from .. import fits, plots, words
from ..caches import CacheOnDemand
from ..cases import case_named
from ..points import PHASES, by_value
from ..section import Plot, Section, Table
from ..suite import require, require_each

NAME = "scaling"

SAMPLES, RESOLUTION, RAYS = "samples on the surface", "pixels a side", "camera rays a pixel"
PASS_ONE, PASS_TWO = "pass one", "pass two"
MIB = 2 ** 20


@dataclasses.dataclass
class Settings:
    cases: list[str] = dataclasses.field(default_factory=lambda: ["sphere-marble"])
    samples: list[int] = dataclasses.field(default_factory=lambda: [10_000, 50_000, 250_000])
    resolutions: list[int] = dataclasses.field(default_factory=lambda: [128, 256, 512])
    camera_samples: list[int] = dataclasses.field(default_factory=lambda: [1, 4, 16])
    threads: list[int] = dataclasses.field(default_factory=lambda: [1, 2])
    resolution: int = 256        # while something else varies
    rays: int = 4                # camera rays a pixel, while something else varies

    def __post_init__(self):
        for name in self.cases:
            case_named(name)
        require_each(self, "integers >= 100", lambda n: n >= 100, "samples")
        require_each(self, "integers in [8, 8192]", lambda n: 8 <= n <= 8192, "resolutions")
        require_each(self, "integers in [1, 65536]", lambda n: 1 <= n <= 65536, "camera_samples")
        require_each(self, "integers in [1, 1024]", lambda n: 1 <= n <= 1024, "threads")
        require(self, "resolution", "an integer in [8, 8192]", lambda n: 8 <= n <= 8192)
        require(self, "rays", "an integer in [1, 65536]", lambda n: 1 <= n <= 65536)


def series(program, threads):
    return f"{program}, {threads} {'thread' if threads == 1 else 'threads'}"


# --- measuring -----------------------------------------------------------------------------------

def quantities(runs):
    """Process time, memory and phases of some runs of a program."""
    result = {"seconds": [r.seconds for r in runs], "peak_mib": [r.peak_mib for r in runs],
              "samples": [runs[0].stats["counts"]["samples"]]}
    for phase in PHASES:
        if phase in runs[0].stats["seconds"]:
            result[f"seconds_{phase}"] = [r.stats["seconds"][phase] for r in runs]
    return result, runs[0].command


def pass_one(bench, case, name, *flags):
    return quantities([bench.cache(case, *flags, name=name)[1] for _ in range(bench.repeat)])


def pass_two(bench, case, cache, resolution, rays, threads):
    return quantities([
        bench.image(case, cache.path, f"{case.name}-{NAME}", "--set",
                    f"cameras.main.resolution=[{resolution},{resolution}]", "--samples", rays,
                    "--threads", threads, layers="none")[1] for _ in range(bench.repeat)])


def measure_samples(settings, bench, case):
    for number in settings.samples:
        name = f"{case.name}-{number}"
        cache = CacheOnDemand(bench, case, "--points", number, name=name)
        for threads in settings.threads:
            bench.measure(NAME, case.name, series(PASS_ONE, threads), SAMPLES, number,
                          lambda: pass_one(bench, case, name, "--points", number, "--threads",
                                           threads), inputs=case.fingerprint())
            bench.measure(NAME, case.name, series(PASS_TWO, threads), SAMPLES, number,
                          lambda: pass_two(bench, case, cache, settings.resolution, settings.rays,
                                           threads),
                          settings=[settings.resolution, settings.rays], inputs=case.fingerprint())


def measure_pixels(settings, bench, case):
    cache = CacheOnDemand(bench, case)
    for threads in settings.threads:
        for resolution in settings.resolutions:
            bench.measure(NAME, case.name, series(PASS_TWO, threads), RESOLUTION, resolution,
                          lambda: pass_two(bench, case, cache, resolution, settings.rays, threads),
                          settings=settings.rays, inputs=case.fingerprint())
        for rays in settings.camera_samples:
            bench.measure(NAME, case.name, series(PASS_TWO, threads), RAYS, rays,
                          lambda: pass_two(bench, case, cache, settings.resolution, rays, threads),
                          settings=settings.resolution, inputs=case.fingerprint())


def measure(settings, bench):
    for name in settings.cases:
        measure_samples(settings, bench, case_named(name))
        measure_pixels(settings, bench, case_named(name))


# --- telling -------------------------------------------------------------------------------------

def lines_of(settings, bench, case, parameter):
    """The points of each line: [(program, threads, points)]."""
    programs = (PASS_ONE, PASS_TWO) if parameter == SAMPLES else (PASS_TWO,)
    return [(program, threads, by_value(bench.of(NAME, case=case, series=series(program, threads),
                                                 parameter=parameter)))
            for program in programs for threads in settings.threads]


def plot_of(settings, bench, case, parameter, quantity):
    points = [p for _, _, line in lines_of(settings, bench, case, parameter) for p in line]
    words_of = "Time of the whole process" if quantity == "seconds" else "Largest resident memory"
    stem = {SAMPLES: "samples", RESOLUTION: "resolution", RAYS: "rays"}[parameter]
    return Plot(f"{NAME}-{stem}-{quantity}-{case}".replace("_", "-"),
                plots.against(points, "value", quantity, fit=True, parameter=parameter,
                              title=f"{case}: {parameter}"),
                f"{words_of} against {parameter}, {case}; bars from least to most of "
                f"{bench.repeat} runs, exponents fitted.", points[0].command)


def fitted(points, quantity):
    """The exponent's words, or nothing where the quantity was not measured everywhere."""
    if any(quantity not in p.quantities or p.median(quantity) <= 0 for p in points):
        return ""
    law = fits.fit_of(points, "value", quantity)
    return law.words() if law else ""


def exponent_table(settings, bench):
    quantity_names = ["seconds", "peak_mib", *(f"seconds_{phase}" for phase in PHASES)]
    rows = []
    for case in settings.cases:
        for parameter in (SAMPLES, RESOLUTION, RAYS):
            for program, threads, points in lines_of(settings, bench, case, parameter):
                rows.append([case, parameter, series(program, threads),
                             *(fitted(points, q) for q in quantity_names)])
    used = [i for i in range(3 + len(quantity_names)) if any(row[i] for row in rows)]
    columns = ["case", "against", "program", "time", "memory", *PHASES]
    return Table([columns[i] for i in used], [[row[i] for i in used] for row in rows],
                 "Exponents b of y = a x^b, least squares of the logarithms of medians, with the "
                 "standard error of b: whole process, peak memory, and phases from --stats. Large "
                 "standard errors mean that it is no power: a constant part shows at small x.")


def growth_words(settings, bench, case):
    """What more samples cost, each pass, with the most threads."""
    sentences = []
    for program, threads, points in lines_of(settings, bench, case, SAMPLES):
        if threads != max(settings.threads) or len(points) < 2:
            continue
        least, most = points[0], points[-1]
        samples = most.median("samples") - least.median("samples")
        memory = (most.median("peak_mib") - least.median("peak_mib")) * MIB / samples
        sentences.append(
            f"From {words.count(least.median('samples'))} to {words.count(most.median('samples'))} "
            f"samples {program} goes from {words.seconds(least.median('seconds'))} and "
            f"{words.memory(least.median('peak_mib'))} to {words.seconds(most.median('seconds'))} "
            f"and {words.memory(most.median('peak_mib'))}: {words.significant(memory, 3)} bytes "
            f"for each sample more, time to the power {fitted(points, 'seconds')}"
            + (f", of which the sum itself {fitted(points, 'seconds_exitance')}."
               if program == PASS_TWO else "."))
    return sentences


def pixel_words(settings, bench, case):
    sentences = []
    for parameter in (RESOLUTION, RAYS):
        _, _, points = lines_of(settings, bench, case, parameter)[-1]
        if len(points) > 1:
            ratio = points[-1].median("seconds") / points[0].median("seconds")
            sentences.append(
                f"From {points[0].value} to {points[-1].value} {parameter} pass two takes "
                f"{words.times(ratio)} the time (power {fitted(points, 'seconds')}; the sum "
                f"{fitted(points, 'seconds_exitance')}).")
    return sentences


def thread_words(settings, bench, case):
    """How much the most threads help at the largest number of samples."""
    few, many = min(settings.threads), max(settings.threads)
    if few == many:
        return []
    ratios = []
    for program in (PASS_ONE, PASS_TWO):
        slow, fast = (by_value(bench.of(NAME, case=case, series=series(program, threads),
                                        parameter=SAMPLES))[-1].median("seconds")
                      for threads in (few, many))
        ratios.append(f"{program} {words.times(slow / fast)}")
    return [f"At the most samples {many} threads make {words.listed(ratios)} as fast as {few}."]


def section(settings, bench):
    text = ("Time and memory of the programs as a user runs them, everything else automatic: whole "
            "processes, from start to end, and their largest resident set; the table holds the "
            f"phases, too. Where something else varies, pictures have {settings.resolution} x "
            f"{settings.resolution} pixels and {settings.rays} camera rays a pixel.\n\n"
            + "\n\n".join(
                f"{case}. " + " ".join(growth_words(settings, bench, case)
                                       + pixel_words(settings, bench, case)
                                       + thread_words(settings, bench, case))
                for case in settings.cases))
    shown = [(SAMPLES, "seconds"), (SAMPLES, "peak_mib"), (RESOLUTION, "seconds"),
             (RESOLUTION, "peak_mib"), (RAYS, "seconds")]
    return Section("Scaling", text,
                   plots=[plot_of(settings, bench, case, *what) for case in settings.cases
                          for what in shown],
                   tables=[exponent_table(settings, bench)])
