# SPDX-License-Identifier: Apache-2.0
"""Model error: the methods' pictures, hierarchy and sampling tight, against volumetric truth."""
import dataclasses
import functools
import typing

from .. import metrics, pictures, plots
from ..cases import Case, cases_named
from ..images import read_image
from ..section import Plot, Section, Table
from ..suite import require, require_each

EXACT = {"single_scattering": "exact"}

# What a material says to be of a model. "classic" is what Jensen & Buhler published; all others have
# single scattering along refracted paths, which on meshes has to be asked for.
MODELS = {
    "body-aware": {"model": "body-aware", **EXACT},
    "body-aware-no-shifts": {"model": "body-aware", "shifts": "off", **EXACT},
    "body-aware-no-elements": {"model": "body-aware", "boundary_elements": "off", **EXACT},
    "body-aware-no-re-entry": {"model": "body-aware", "re_entry": "off", **EXACT},
    "body-aware-normalized-exit": {"model": "body-aware", "exit": "normalized", **EXACT},
    "transport": {"model": "transport", **EXACT},
    "photon-beam-diffusion": {"model": "photon-beam-diffusion", **EXACT},
    "classic": {"model": "dipole", "exit": "classic", "single_scattering": "straight"},
    "dipole": {"model": "dipole", **EXACT},
    "better-dipole": {"model": "better-dipole", **EXACT},
    "normalized-diffusion": {"model": "normalized-diffusion", **EXACT},
}

# Layers of ours and what of the reference they are compared with, indirect light on and off. The
# reference's `multi` is light that scattered twice or more without leaving the body, `ext` light
# that left it and came back; our `multiple` holds what indirect light adds.
LAYERS = {
    "everything": ("scattered", {"on": "", "off": ""}),
    "single": ("single", {"on": "single", "off": "single"}),
    "multiple": ("multiple", {"on": "multi+ext", "off": "multi"}),
}

BLOCK = 2  # pixels a side averaged for p99, so that it is not the reference's noise


@dataclasses.dataclass
class Settings:
    cases: list[str] | typing.Literal["all"]
    models: list[typing.Literal[tuple(MODELS)]] = dataclasses.field(
        default_factory=lambda: ["transport", "classic"])
    indirect: list[typing.Literal["on", "off"]] = dataclasses.field(default_factory=lambda: ["on"])
    # Models measured without indirect light besides, where `indirect` does not say it of all.
    no_indirect: list[typing.Literal[tuple(MODELS)]] = dataclasses.field(default_factory=list)
    tolerance: float = 0.005      # of the hierarchy and of the sampling, each
    samples: int = 64             # camera rays a pixel
    # Of indirect light where it is on, which takes most of the time on meshes; auto: the program's.
    bounces: int | typing.Literal["auto"] = "auto"
    indirect_samples: int | typing.Literal["auto"] = "auto"
    difference_limit: float = 0.5  # end of the scale of difference pictures, of the mean

    def __post_init__(self):
        cases_named(self.cases)
        require_each(self, "models", lambda _: True, "models")
        require_each(self, "on and off", lambda _: True, "indirect")
        require(self, "tolerance", "a number in (0, 1)", lambda t: 0 < t < 1)
        require(self, "samples", "an integer in [1, 65536]", lambda n: 1 <= n <= 65536)
        require(self, "bounces", "auto or an integer in [1, 64]", _auto_or_up_to(64))
        require(self, "indirect_samples", "auto or an integer in [1, 65536]",
                _auto_or_up_to(65536))
        require(self, "difference_limit", "a number above 0", lambda x: x > 0)


def _auto_or_up_to(most):
    return lambda value: value == "auto" or 1 <= value <= most


def series_of(model, indirect):
    return model if indirect == "on" else f"{model}, no indirect light"


def pairs_of(settings):
    pairs = [(model, indirect) for model in settings.models for indirect in settings.indirect]
    return list(dict.fromkeys(pairs + [(model, "off") for model in settings.no_indirect]))


def all_series(settings):
    return [series_of(model, indirect) for model, indirect in pairs_of(settings)]


def measure(settings, bench):
    for case in cases_named(settings.cases):
        if not case.reference.exists():
            bench.say(f"model: {case.name}: no reference {case.reference}")
            continue
        reference = read_image(case.reference)
        for model, indirect in pairs_of(settings):
            _Comparison(settings, bench, case, reference, model, indirect).measure()


@dataclasses.dataclass
class _Comparison:
    """One case under one model: rendered once, when the first number of it is asked for."""
    settings: Settings
    bench: object
    case: Case
    reference: object
    model: str
    indirect: str

    @property
    def name(self):
        return f"{self.case.name}-{self.model}-indirect-{self.indirect}"

    @functools.cached_property
    def rendered(self):
        """Our image and the command that made it."""
        one, two = self._flags()
        cache, _ = self.bench.cache(self.case, *one, material=MODELS[self.model])
        path, run = self.bench.image(self.case, cache, self.name, *two,
                                     material=MODELS[self.model])
        return read_image(path), run.command

    @functools.cached_property
    def flip(self):
        """Mean and map of FLIP of everything that scattered."""
        return metrics.flip(self.rendered[0].sum("scattered"), self.reference[""],
                            metrics.body_mask(self.reference))

    def _flags(self):
        """Flags of pass one and of pass two."""
        tolerance = ["--tolerance", str(self.settings.tolerance)]
        light = [word for key, value in self._indirect_light().items() if value != "auto"
                 for word in ("--set", f"settings.{key}={value}")]
        return tolerance + light, tolerance + light + ["--samples", str(self.settings.samples)]

    def _indirect_light(self):
        """What the scene is told of it."""
        if self.indirect == "off":
            return {"bounces": 0}
        return {"bounces": self.settings.bounces,
                "indirect_samples": self.settings.indirect_samples}

    def measure(self):
        for layer in LAYERS:
            self.bench.measure("model", self.case.name, series_of(self.model, self.indirect),
                               "layer", layer, lambda layer=layer: self._numbers(layer),
                               tolerance=self.settings.tolerance, samples=self.settings.samples,
                               inputs=self.case.fingerprint(), **self._indirect_light())
        paths = [self.bench.folder / f"pictures/{self.name}-{part}.png" for part in pictures.PARTS]
        if "rendered" in vars(self) or not all(path.exists() for path in paths):
            self._draw()

    def _numbers(self, layer):
        image, command = self.rendered
        ours, theirs = LAYERS[layer][0], LAYERS[layer][1][self.indirect]
        i, r = image.sum(ours), self.reference.sum(theirs)
        mask = metrics.body_mask(self.reference)
        numbers = metrics.compare(i, r, mask, self.reference.variance(theirs), BLOCK)
        if layer == "everything":
            numbers["flip"] = self.flip[0]
        return {name: [number] for name, number in numbers.items()}, command

    def _draw(self):
        image, _ = self.rendered
        pictures.strip(self.bench.folder / "pictures", self.name, image.sum("scattered"),
                       self.reference[""], metrics.body_mask(self.reference),
                       self.flip[1], self.settings.difference_limit)


TEXT = """
Each case is rendered with a tolerance of {tolerance:g} for the hierarchy and for the sampling, \
and compared with volumetric path tracing of the same scene: a homogeneous medium behind a \
smooth dielectric boundary (experiments/reference). What is compared is everything that \
scattered inside the body: our layer `scattered` against the reference's picture, which \
holds neither mirror images of lamps nor the lamps themselves. The mean square of the \
reference's own noise has been taken off every relRMSE; p99 is over averages of 2 x 2 pixels and \
holds what noise these have left.

"classic" is Jensen & Buhler as published: the dipole, the papers' exit term, single scattering.\
"""


def section(settings, bench):
    cases = cases_named(settings.cases)
    points = bench.of("model")
    known = [case for case in cases if bench.of("model", case=case.name)]
    missing = [case.name for case in cases if case not in known]
    text = TEXT.format(tolerance=settings.tolerance)
    if missing:
        text += (f"\n\nNot measured, because experiments/references holds no truth for them: "
                 f"{', '.join(missing)}.")
    return Section("Model error against volumetric truth", text, _plots(settings, known, points),
                   [_pictures(bench, case, *pair) for case in known
                    for pair in pairs_of(settings)],
                   [_table(points, layer) for layer in LAYERS if points])


def _plots(settings, cases, points):
    series = all_series(settings)
    everything = [p for p in points if p.value == "everything"]
    result = []
    if len(cases) > 1:
        result.append(Plot("model-all-cases",
                           plots.bars(everything, "relRMSE", "Model error", series=series),
                           "relRMSE of everything that scattered, the reference's noise taken off.",
                           everything[0].command))
    for case in cases:
        own = [p for p in everything if p.case == case.name]
        quantities = {"relRMSE": "relRMSE", "p99": "p99 (2 x 2)", "bias": "bias"}
        result.append(Plot(f"model-{case.name}",
                           plots.bars_of(own, quantities, case.name, series),
                           f"{case.name}: errors of everything that scattered.", own[0].command))
    return result


def _table(points, layer):
    """All cases and series in one layer; errors in per cent."""
    def percent(point, quantity):
        return 100 * point.median(quantity) if quantity in point.quantities else None

    quantities = ("relRMSE", "bias", "p99", "noise_p99", "max", "noise")
    rows = [[p.case, p.series, *(percent(p, q) for q in quantities),
             p.median("flip") if "flip" in p.quantities else None]
            for p in points if p.value == layer]
    return Table(["case", "model", "relRMSE %", "bias %", "p99 (2 x 2) %", "of noise %",
                  "max (2 x 2) %", "reference's noise %", "FLIP"], rows,
                 f"{layer}: our {LAYERS[layer][0]} against the reference")


def _pictures(bench, case, model, indirect):
    return pictures.row(bench.folder / "pictures", f"{case.name}-{model}-indirect-{indirect}",
                        f"{case.name}: {series_of(model, indirect)}")
