# SPDX-License-Identifier: Apache-2.0
"""Single scattering alone: depths at which light is collected against error against time.

The layer `single` of images with a chosen number of depths a pixel. Light along straight lines and
along all refracted paths is compared with the latter at very many depths, and straight lines also
with themselves, which tells their noise from their error.
"""
import dataclasses
import functools

from .. import fits, plots, words
from ..caches import CacheOnDemand
from ..cases import case_named
from ..images import read_image
from ..metrics import body_mask, compare
from ..points import by_value
from ..section import Plot, Section, Table
from ..suite import require, require_each

NAME = "single"

EXACT, STRAIGHT, STRAIGHT_NOISE = "exact", "straight", "straight, against itself"
TRUTH = {STRAIGHT: "straight, against volumetric truth", EXACT: "exact, against volumetric truth"}
DEPTHS = "depths a pixel"


@dataclasses.dataclass
class Settings:
    cases: list[str] = dataclasses.field(default_factory=lambda: ["sphere-marble"])
    depths: list[int] = dataclasses.field(default_factory=lambda: [1, 2, 4, 8, 16, 32, 64])
    reference_depths: int = 1024
    resolution: int = 64
    exact: bool = True      # on a mesh of 100k triangles it takes some 5 times as long
    truth_samples: int = 16  # camera rays a pixel, against volumetric truth

    def __post_init__(self):
        for name in self.cases:
            case_named(name)
        require_each(self, "integers in [1, 65536]", lambda n: 1 <= n <= 65536, "depths")
        require(self, "reference_depths", "more than depths, up to 65536",
                lambda n: max(self.depths) < n <= 65536)
        require(self, "resolution", "an integer in [8, 4096]", lambda n: 8 <= n <= 4096)
        require(self, "truth_samples", "an integer in [1, 1024]", lambda n: 1 <= n <= 1024)

    def connections(self):
        return [STRAIGHT, EXACT] if self.exact else [STRAIGHT]


# --- measuring -----------------------------------------------------------------------------------

class Layers:
    """Images of the layer `single` of a case."""

    def __init__(self, settings, bench, case):
        self.settings, self.bench, self.case = settings, bench, case
        self.cache = CacheOnDemand(bench, case, "--set", "settings.bounces=0",
                                   name=f"{case.name}-direct")

    def render(self, connection, depths, *flags):
        path, run = self.bench.image(
            self.case, self.cache.path, f"{self.case.name}-single", "--set",
            f"settings.single_scattering_depths={depths}", "--set", "settings.bounces=0", *flags,
            material={"single_scattering": connection})
        return read_image(path), run

    def small(self, connection, depths):
        """One camera ray a pixel, so that depths can be few."""
        size = self.settings.resolution
        return self.render(connection, depths, "--samples", 1, "--set",
                           f"cameras.main.resolution=[{size},{size}]")

    @functools.cache
    def reference(self, connection):
        return self.small(connection, self.settings.reference_depths)[0]

    def quantities(self, connection, depths, against):
        image = None
        seconds = []
        for _ in range(self.bench.repeat):
            image, run = self.small(connection, depths)
            seconds.append(run.stats["seconds"]["single"])
        reference = self.reference(against)
        mask = body_mask(reference)
        errors = compare(image["single"], reference["single"], mask)
        errors["relRMSE_picture"] = errors["relRMSE"] * share_of_single(reference, mask)
        return {"seconds": seconds, **as_lists(errors)}, run.command

    def against_truth(self, connection):
        """With as many depths as the other references, at the truth's own resolution."""
        truth = read_image(self.case.reference)
        image, run = self.render(connection, self.settings.reference_depths, "--samples",
                                 self.settings.truth_samples)
        errors = compare(image["single"], truth["single"], body_mask(image),
                         variance_of(truth, "single"))
        return {"seconds": [run.stats["seconds"]["single"]],
                **as_lists(errors)}, run.command


def as_lists(errors):
    """Quantities of something that every run computes alike."""
    return {name: [value] for name, value in errors.items()}


def share_of_single(image, mask):
    """Mean of what was scattered once over the mean of all that was scattered."""
    single, multiple = (float(image[layer][mask].mean()) for layer in ("single", "multiple"))
    return single / (single + multiple)


def variance_of(image, layer):
    """Of each pixel; None if the file has none."""
    name = f"{layer}_variance"
    return image[name] if name in image else None


def has_truth(case):
    return case.reference.exists() and "single" in read_image(case.reference)


def measure(settings, bench):
    for name in settings.cases:
        case = case_named(name)
        common = {"settings": [settings.reference_depths, settings.resolution],
                  "inputs": case.fingerprint()}
        layers = Layers(settings, bench, case)
        lines = [(STRAIGHT_NOISE, STRAIGHT, STRAIGHT)]
        if settings.exact:
            lines += [(STRAIGHT, STRAIGHT, EXACT), (EXACT, EXACT, EXACT)]
        for series, connection, against in lines:
            for depths in settings.depths:
                bench.measure(NAME, name, series, DEPTHS, depths,
                              lambda: layers.quantities(connection, depths, against), **common)
        for connection in settings.connections() if has_truth(case) else []:
            bench.measure(NAME, name, TRUTH[connection], DEPTHS, settings.reference_depths,
                          lambda: layers.against_truth(connection),
                          inputs=case.fingerprint(), samples=settings.truth_samples)


# --- telling -------------------------------------------------------------------------------------

def line(bench, case, series):
    return by_value(bench.of(NAME, case=case, series=series))


def curves(bench, case):
    return [p for series in (EXACT, STRAIGHT, STRAIGHT_NOISE) for p in line(bench, case, series)]


def plots_of(settings, bench, case):
    points = curves(bench, case)
    truth = {words_of: line(bench, case, words_of)[0].median("relRMSE")
             for words_of in TRUTH.values() if line(bench, case, words_of)}
    about = (f"{case}, {settings.resolution} x {settings.resolution} pixels, one camera ray each; "
             f"reference with {settings.reference_depths} depths.")
    return [
        Plot(f"{NAME}-depths-{case}",
             plots.against(points, "value", "relRMSE", parameter=DEPTHS,
                           title=f"{case}: depths"),
             f"Error of the layer `single` against the depths a pixel: {about}", points[0].command),
        Plot(f"{NAME}-time-{case}",
             plots.error_against_time(points, title=f"{case}: time", floors=truth),
             "The same against the time of the phase `single`; bars from least to most of "
             f"{bench.repeat} runs: {about}", points[0].command)]


def noise_words(bench, case, series):
    points = line(bench, case, series)
    law = fits.fit_of(points, "value", "relRMSE")
    if not law:
        return ""
    return (f"The noise of {series.split(',')[0]} paths goes with depths to the power "
            f"{law.words()}: {words.percent(points[0].median('relRMSE'))} with {points[0].value}, "
            f"{words.percent(points[-1].median('relRMSE'))} with {points[-1].value}.")


def bias_words(bench, case):
    """The straight line's own error: what stays when its noise has gone."""
    straight, exact = line(bench, case, STRAIGHT), line(bench, case, EXACT)
    if not straight or not exact:
        return "Exact paths were not asked for: they take too long on this figure."
    last, best = straight[-1], exact[-1]
    return (f"Against exact paths straight lines stay at {words.percent(last.median('relRMSE'))} "
            f"({last.value} depths; mean difference {100 * last.median('bias'):+.1f} %, 99th "
            f"percentile {words.percent(last.median('p99'))}), however many depths there are, "
            f"which is {words.percent(last.median('relRMSE_picture'))} of the mean of all "
            f"scattered light; exact paths reach {words.percent(best.median('relRMSE'))} and take "
            f"{words.times(best.median('seconds') / last.median('seconds'))} the time "
            f"({words.seconds(best.median('seconds'))} against "
            f"{words.seconds(last.median('seconds'))}).")


def truth_words(settings, bench, case):
    found = [(connection, line(bench, case, TRUTH[connection])[0])
             for connection in settings.connections() if line(bench, case, TRUTH[connection])]
    if not found:
        return (f"No volumetric truth of single scattering to compare with: "
                f"{case_named(case).reference.relative_to(case_named(case).reference.parents[2])} "
                "is not there or has no layer `single`.")
    return "Against the volumetric truth's layer `single` " + words.listed(
        f"{connection} {difference_words(p)}, with a mean difference of "
        f"{100 * p.median('bias'):+.1f} %" for connection, p in found) + "."


def difference_words(p):
    """How far a picture is from the truth, if the truth is good enough to tell."""
    if "noise" not in p.quantities:
        return f"has a relRMSE of {words.percent(p.median('relRMSE'))}, the truth's noise included"
    noise = words.percent(p.median("noise"))
    if p.median("relRMSE") == 0:
        return f"differs by no more than the truth's noise of {noise}"
    return (f"has a relRMSE of {words.percent(p.median('relRMSE'))}, the truth's noise of {noise} "
            "taken off")


def case_words(settings, bench, case):
    parts = [f"{case}.", noise_words(bench, case, STRAIGHT_NOISE), noise_words(bench, case, EXACT),
             bias_words(bench, case), truth_words(settings, bench, case)]
    return " ".join(filter(None, parts))


def table_of(settings, bench):
    def of_picture(p):
        known = "relRMSE_picture" in p.quantities
        return words.percent(p.median("relRMSE_picture")) if known else ""

    rows = [[case, p.series, p.value, words.percent(p.median("relRMSE")), of_picture(p),
             f"{100 * p.median('bias'):+.2f} %", words.percent(p.median("p99")),
             words.seconds(p.median("seconds"))]
            for case in settings.cases for p in bench.of(NAME, case=case)]
    return Table(["case", "paths of light", DEPTHS, "relRMSE", "of all scattered light",
                  "mean difference", "p99", "time"],
                 rows, "All that was measured; medians. Errors are against exact paths with "
                 f"{settings.reference_depths} depths if nothing else is said.")


def section(settings, bench):
    text = ("Light that is scattered once, alone: the layer `single` over the pixels that see the "
            "body. Eye rays are refracted into the body and light is collected at a number of "
            "depths along them (`settings.single_scattering_depths`), from each to one point of "
            "each light: along a `straight` line whose length inside is corrected, or along every "
            "path that is refracted at the surface (`exact`). Times are of the phase `single`.\n\n"
            + "\n\n".join(case_words(settings, bench, case) for case in settings.cases))
    return Section("Single scattering: depths against error against time", text,
                   plots=[plot for case in settings.cases
                          for plot in plots_of(settings, bench, case)],
                   tables=[table_of(settings, bench)])
