# SPDX-License-Identifier: Apache-2.0
"""Error of the samples: kinds of point sets, then spacing and light samples, against time.

Point sets by sampling-sweep: exitance under parallel light. Spacing and light samples through the
programs: the layer `multiple` of an image against that of samples 16 times as many, or of many more
light rays.
"""
import dataclasses
import functools

from .. import fits, plots, programs, words
from ..cases import case_named
from ..images import read_image
from ..metrics import body_mask, compare
from ..points import by_value
from ..section import Plot, Section, Table
from ..suite import read_yaml, require, require_each
from ..sweeps import sampling_sweep

NAME = "sampling"

# How a line is called in plots, by the sweep's method.
SERIES = {"cells": "ours", "bands": "ours, of a true sphere",
          "voronoi": "blue noise, Voronoi areas", "blue-noise": "blue noise", "random": "random"}
SPACING, LIGHT, AUTOMATIC = "spacing", "light samples", "automatic"
EXTENT_MM = 40  # largest side of a mesh's box, as the standard cases have them
SUM_TOLERANCE = 1e-4  # of the hierarchy, so that its error does not count here


@dataclasses.dataclass
class Settings:
    cases: list[str] = dataclasses.field(default_factory=lambda: ["sphere-marble"])
    methods: list[str] = dataclasses.field(
        default_factory=lambda: ["cells", "bands", "voronoi", "blue-noise", "random"])
    point_sets: list[int] = dataclasses.field(default_factory=lambda: [1000, 4000, 16_000])
    spacings: list[float] = dataclasses.field(default_factory=lambda: [8, 4, 2, 1])  # automatic
    many_light_samples: int = 32  # while the spacing varies
    light_samples: list[int] = dataclasses.field(default_factory=lambda: [1, 4, 16, 64])
    light_spacing: float = 2      # of the automatic one, while light samples vary
    reference_light_samples: int = 1024
    resolution: int = 128
    camera_samples: int = 4

    def __post_init__(self):
        for name in self.cases:
            case_named(name)
        require_each(self, f"{', '.join(SERIES)}", lambda m: m in SERIES, "methods")
        require_each(self, "integers >= 100", lambda n: n >= 100, "point_sets")
        require_each(self, "numbers in [0.1, 100]", lambda h: 0.1 <= h <= 100, "spacings")
        require_each(self, "integers in [1, 65536]", lambda n: 1 <= n <= 65536, "light_samples")
        require(self, "light_spacing", "a number in [0.1, 100]", lambda h: 0.1 <= h <= 100)
        for key in ("many_light_samples", "camera_samples"):
            require(self, key, "an integer in [1, 65536]", lambda n: 1 <= n <= 65536)
        require(self, "reference_light_samples", "more than light_samples, up to 65536",
                lambda n: max(self.light_samples) < n <= 65536)
        require(self, "resolution", "an integer in [8, 4096]", lambda n: 8 <= n <= 4096)

    def methods_of(self, case):
        """Bands are of a sphere only."""
        return [m for m in self.methods if m != "bands" or body_of(case) == "sphere"]


# --- point sets ----------------------------------------------------------------------------------

def first_object(case):
    return read_yaml(case.scene)["objects"][0]


def body_of(case):
    """What sampling-sweep calls the figure."""
    thing = first_object(case)
    return "sphere" if thing["shape"] == "sphere" else (case.scene.parent / thing["file"]).resolve()


class PointSets:
    """The sweep over methods and numbers of samples, run once a seed when it is asked for."""

    def __init__(self, settings, case):
        self.settings, self.case = settings, case

    @functools.cache
    def rows(self, seed):
        thing = first_object(self.case)
        extent = 2 * thing["radius"] if thing["shape"] == "sphere" else EXTENT_MM
        rows, run = sampling_sweep(
            body_of(self.case), "--extent", extent, "--samples",
            ",".join(map(str, self.settings.point_sets)), "--densities", 1, "--methods",
            ",".join(self.settings.methods_of(self.case)), "--material", self.case.material(),
            "--seed", seed)
        return {(row["method"], float(row["wished"])): row for row in rows}, run.command

    def quantities(self, method, number, repeat):
        """A number a seed."""
        runs = [self.rows(seed + 1)[0][method, number] for seed in range(repeat)]
        return {"seconds": [float(r["seconds_sample"]) + float(r["seconds_light"]) for r in runs],
                "relRMSE": [float(r["rel_rmse"]) for r in runs],
                "p99": [float(r["p99"]) for r in runs],
                "samples": [int(r["samples"]) for r in runs]}, self.rows(1)[1]


def measure_point_sets(settings, bench, case):
    sets = PointSets(settings, case)
    for method in settings.methods_of(case):
        for number in settings.point_sets:
            bench.measure(NAME, case.name, SERIES[method], "samples", number,
                          lambda: sets.quantities(method, number, bench.repeat),
                          settings=[settings.point_sets, settings.methods],
                          inputs=case.fingerprint())


# --- images --------------------------------------------------------------------------------------

class Images:
    """Images of a case from caches of chosen spacing and light samples."""

    def __init__(self, settings, bench, case):
        self.settings, self.bench, self.case = settings, bench, case

    @functools.cached_property
    def automatic_spacing(self):
        """mm, at the scene's tolerance."""
        run = programs.run("tallow-precompute", self.case.scene, "--plan", *self.case.flags())
        return run.stats["plan"]["numbers"]["objects[0].spacing_mm"]

    def render(self, *flags):
        """The image and pass one's run."""
        cache, run = self.bench.cache(self.case, *flags, name=f"{self.case.name}-sampling")
        size = self.settings.resolution
        path, _ = self.bench.image(
            self.case, cache, f"{self.case.name}-sampling", "--tolerance", SUM_TOLERANCE,
            "--samples", self.settings.camera_samples, "--set",
            f"cameras.main.resolution=[{size},{size}]", "--set",
            "settings.single_scattering_depths=1", "--set", "settings.bounces=0")
        return read_image(path), run

    def flags(self, spacing, light_samples):
        """spacing in automatic ones."""
        return ["--spacing", f"{spacing * self.automatic_spacing:.6g}", "--light-samples",
                light_samples, "--set", "settings.bounces=0"]

    @functools.cache
    def reference(self, spacing, light_samples):
        return self.render(*self.flags(spacing, light_samples))[0]

    def quantities(self, flags, reference):
        """Time of samples, light and tree in each of some runs, and the error of the last image."""
        runs = [self.bench.cache(self.case, *flags)[1] for _ in range(self.bench.repeat - 1)]
        image, run = self.render(*flags)
        runs.append(run)
        errors = compare(image["multiple"], reference["multiple"], body_mask(reference))
        phases = [[r.stats["seconds"][p] for p in ("sample", "irradiance", "octree")] for r in runs]
        return {"seconds": [sum(p) for p in phases],
                "samples": [run.stats["counts"]["samples"]],
                **{name: [value] for name, value in errors.items()}}, run.command


def measure_images(settings, bench, case):
    images = Images(settings, bench, case)
    finest = min(1, *settings.spacings) / 4  # also of the automatic spacing
    common = {"settings": dataclasses.asdict(settings), "inputs": case.fingerprint()}
    for spacing in settings.spacings:
        bench.measure(NAME, case.name, SPACING, "spacing / automatic", spacing,
                      lambda: images.quantities(
                          images.flags(spacing, settings.many_light_samples),
                          images.reference(finest, settings.many_light_samples)), **common)
    for number in settings.light_samples:
        bench.measure(NAME, case.name, LIGHT, "light samples", number,
                      lambda: images.quantities(
                          images.flags(settings.light_spacing, number),
                          images.reference(settings.light_spacing,
                                           settings.reference_light_samples)), **common)
    bench.measure(NAME, case.name, AUTOMATIC, "spacing / automatic", 1,
                  lambda: images.quantities(
                      ["--set", "settings.bounces=0"],
                      images.reference(finest, settings.many_light_samples)), **common)


def measure(settings, bench):
    for name in settings.cases:
        case = case_named(name)
        measure_point_sets(settings, bench, case)
        measure_images(settings, bench, case)


# --- telling -------------------------------------------------------------------------------------

def set_points(settings, bench, case):
    return [p for method in settings.methods_of(case_named(case))
            for p in bench.of(NAME, case=case, series=SERIES[method])]


def plots_of(settings, bench, case):
    sets = set_points(settings, bench, case)
    images = [p for series in (SPACING, LIGHT, AUTOMATIC)
              for p in bench.of(NAME, case=case, series=series)]
    by_spacing, by_light = ([p for p in images if p.series == s] for s in (SPACING, LIGHT))
    runs = f"bars from least to most of {bench.repeat} seeds"
    return [
        Plot(f"{NAME}-points-{case}",
             plots.against(sets, "samples", "relRMSE", fit=True, title=f"{case}: kinds of samples"),
             f"Error of the exitance against the number of samples, {case}; {runs}.",
             sets[0].command),
        Plot(f"{NAME}-points-time-{case}",
             plots.error_against_time(sets, title=f"{case}: kinds of samples"),
             f"The same errors against the time that placing the samples and lighting them takes; "
             f"{runs}.", sets[0].command),
        Plot(f"{NAME}-time-{case}",
             plots.error_against_time(images, title=f"{case}: pass one", show_values=True),
             "Error of the image against the time of pass one (its phases sample, irradiance, "
             f"octree), {case}. Beside the points: spacing in automatic ones, light samples.",
             images[0].command),
        Plot(f"{NAME}-spacing-{case}",
             plots.against(by_spacing, "value", "relRMSE", fit=True,
                           parameter="spacing / automatic spacing", title=f"{case}: spacing"),
             f"Error of the image against the spacing of its samples, {case}.",
             by_spacing[0].command),
        Plot(f"{NAME}-light-{case}",
             plots.against(by_light, "value", "relRMSE", fit=True, parameter="rays to each light",
                           title=f"{case}: light samples"),
             f"Error of the image against the rays from each sample to each light, {case}.",
             by_light[0].command)]


def set_words(settings, bench, case):
    """How the kinds compare at the most samples, and how each falls."""
    most = max(settings.point_sets)
    sets = set_points(settings, bench, case)
    last = {p.series: p for p in sets if p.value == most}
    sentences = [f"{case}: with {words.count(most)} samples asked for, the error is "
                 + words.listed(f"{words.percent(p.median('relRMSE'))} ({series})"
                                for series, p in last.items()) + "."]
    falls = []
    for series in last:
        law = fits.fit_of([p for p in sets if p.series == series], "samples", "relRMSE")
        if law:
            falls.append(f"{law.words()} ({series})")
    if falls:
        sentences.append("Fitted, it goes with the number of samples to the power "
                         + words.listed(falls) + ".")
    return " ".join(sentences)


def image_words(bench, case):
    sentences = []
    for series, words_of in ((SPACING, "the spacing"), (LIGHT, "the number of light samples")):
        points = by_value(bench.of(NAME, case=case, series=series))
        law = fits.fit_of(points, "value", "relRMSE")
        if law:
            sentences.append(f"In images of {case} the error goes with {words_of} to the power "
                             f"{law.words()}, from {words.percent(points[0].median('relRMSE'))} to "
                             f"{words.percent(points[-1].median('relRMSE'))}.")
    auto = bench.of(NAME, case=case, series=AUTOMATIC)[0]
    sentences.append(f"With everything automatic, {words.count(auto.median('samples'))} samples "
                     f"take {words.seconds(auto.median('seconds'))} for an error of "
                     f"{words.percent(auto.median('relRMSE'))}, light noise included.")
    return " ".join(sentences)


def table_of(settings, bench):
    rows = [[case, p.series, f"{p.value:g}" if p.series in (SPACING, LIGHT) else "",
             words.count(p.median("samples")), words.percent(p.median("relRMSE")),
             words.percent(p.median("p99")), words.seconds(p.median("seconds"))]
            for case in settings.cases for p in bench.of(NAME, case=case)]
    return Table(["case", "samples or what varies", "value", "samples", "relRMSE", "p99", "time"],
                 rows, "All that was measured; medians.")


def section(settings, bench):
    text = ("The error that the samples alone make. Kinds of point sets are compared on the "
            "exitance under parallel light, which has no noise of its own, against samples of ours "
            f"16 times as many as the most; meshes are scaled to {EXTENT_MM} mm; times are of "
            "placing samples and lighting them, by the sweep's own clock, and dart throwing is "
            "written plainly: a good one would be some times faster. Spacing and light samples are "
            "varied through the programs: the error is of the layer `multiple` over the pixels "
            "that see the body, against samples of a quarter of the finest spacing shown (16 times "
            f"as many) with as many light samples ({settings.many_light_samples}), or against "
            f"{settings.reference_light_samples} light samples at the same spacing "
            f"({settings.light_spacing:g} automatic ones); there the time is that of pass one's "
            "phases sample, irradiance and octree. Indirect light is left out.\n\n"
            + "\n\n".join(f"{set_words(settings, bench, case)} {image_words(bench, case)}"
                          for case in settings.cases))
    return Section("Error of the samples against time", text,
                   plots=[plot for case in settings.cases
                          for plot in plots_of(settings, bench, case)],
                   tables=[table_of(settings, bench)])
