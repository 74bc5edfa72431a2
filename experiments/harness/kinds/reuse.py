# SPDX-License-Identifier: Apache-2.0
"""What a cache saves: a turntable, other lights and another material from one pass one."""
import dataclasses
import functools
import json
import statistics

from .. import plots, programs, words
from ..caches import CacheOnDemand
from ..cases import Case, case_named
from ..images import read_image
from ..metrics import body_mask, compare
from ..section import Plot, Section, Table
from ..suite import require, require_each

NAME = "reuse"

# Ways to a frame of the turntable.
TOGETHER = "one cache, one process"
APART = "one cache, a process a frame"
FROM_NOTHING = "both passes for each frame"
# What changes in a scene while its cache stays.
CHANGES = {"colour": "colour of the light", "material": "material"}
KEPT, ANEW = "pass two alone", "both passes"
FRAME = "frame"


@dataclasses.dataclass
class Settings:
    cases: list[str] = dataclasses.field(default_factory=lambda: ["sphere-marble"])
    frames: int = 36
    resolution: int = 128
    camera_samples: int = 4
    alone: int = 3  # frames, spread over the turn, that are also rendered each by itself
    light_group: str = "key"
    light_scale: list[float] = dataclasses.field(default_factory=lambda: [1, 0.5, 0.2])
    medium: str = "skimmilk"  # whose coefficients the body is given

    def __post_init__(self):
        for name in self.cases:
            case_named(name), case_named(f"{case_named(name).figure}-{self.medium}")
        require(self, "frames", "an integer in [2, 10000]", lambda n: 2 <= n <= 10_000)
        require(self, "resolution", "an integer in [8, 4096]", lambda n: 8 <= n <= 4096)
        require(self, "camera_samples", "an integer in [1, 65536]", lambda n: 1 <= n <= 65536)
        require(self, "alone", "an integer from 1 to the number of frames",
                lambda n: 1 <= n <= self.frames)
        require_each(self, "three numbers >= 0", lambda x: x >= 0, "light_scale")
        require(self, "light_scale", "three numbers >= 0", lambda scale: len(scale) == 3)


# --- measuring -----------------------------------------------------------------------------------

class Scene:
    """A case on its turntable; `flags` are for both passes."""

    def __init__(self, settings, bench, case, name, *flags):
        self.settings, self.bench, self.case = settings, bench, case
        self.flags = ["--set", f"cameras.main.turntable={{frames: {settings.frames}, "
                               "axis: [0, 1, 0], degrees: 360}", *flags]
        self.cache = CacheOnDemand(bench, case, *self.flags, name=name)

    def pass_one(self):
        return self.bench.cache(self.case, *self.flags, name=f"{self.case.name}-anew")

    def pass_two(self, cache, first, last, *flags, case=None, material=None):
        """Renders frames; returns the pictures' name, with #### for the frame, and the run."""
        size = self.settings.resolution
        return self.bench.image(
            case or self.case, cache, f"{self.case.name}-turn-####", "--frames", f"{first}-{last}",
            "--samples", self.settings.camera_samples, "--set",
            f"cameras.main.resolution=[{size},{size}]", *self.flags, *flags,
            layers="multiple", material=material)

    def frames_alone(self):
        count = self.settings.alone
        return [i * self.settings.frames // count for i in range(count)]

    @functools.cached_property
    def turns(self):
        """All frames by one process, some times."""
        last = self.settings.frames - 1
        return [self.pass_two(self.cache.path, 0, last)[1] for _ in range(self.bench.repeat)]

    def together(self):
        return ({"seconds": [turn.seconds / self.settings.frames for turn in self.turns]},
                self.turns[0].command)

    def frame(self, index):
        """A frame of the turn by the program's own clock."""
        return ({"seconds": [frame_seconds(turn.stats)[index] for turn in self.turns]},
                self.turns[0].command)

    def apart(self):
        runs = [self.pass_two(self.cache.path, k, k)[1] for k in self.frames_alone()]
        return {"seconds": [run.seconds for run in runs]}, runs[0].command

    def from_nothing(self):
        seconds, commands = [], []
        for k in self.frames_alone():
            cache, first = self.pass_one()
            second = self.pass_two(cache, k, k)[1]
            seconds.append(first.seconds + second.seconds)
            commands = [first.command, second.command]
        return {"seconds": seconds}, " && ".join(commands)


def frame_seconds(stats):
    """Seconds of each frame of a --frames run."""
    return [frame["seconds"] for frame in stats["frames"]]


def index_of(case):
    """The medium's index of refraction: light that has entered depends on it, a cache keeps it."""
    material = json.loads(case.material())
    if "eta" in material:
        return material["eta"]
    run = programs.run("tallow-material", material["preset"], "--json", stats=False)
    return json.loads(run.stdout)["eta"]


class Change:
    """A changed scene: rendered from the old cache, and from a new one."""

    def __init__(self, scene, kind):
        self.scene = scene
        settings = scene.settings
        self.kind, self.case, self.flags = kind, scene.case, []
        if kind == "material":
            self.case = Case(scene.case.figure, settings.medium)
        else:
            self.flags = ["--set", f"groups.{settings.light_group}.scale="
                                   f"{[float(x) for x in settings.light_scale]}"]

    @functools.cached_property
    def material(self):
        return {"eta": index_of(self.scene.case)} if self.kind == "material" else {}

    def image(self, cache):
        path, run = self.scene.pass_two(cache, 0, 0, *self.flags, case=self.case,
                                        material=self.material)
        return read_image(str(path).replace("####", "0000")), run

    @functools.cached_property
    def anew_runs(self):
        """Both passes, some times: the seconds of each time, the command, the last image."""
        seconds, image, command = [], None, ""
        for _ in range(self.scene.bench.repeat):
            cache, first = self.scene.bench.cache(
                self.case, *self.scene.flags, *self.flags, name=f"{self.scene.case.name}-anew",
                material=self.material)
            image, second = self.image(cache)
            seconds.append(first.seconds + second.seconds)
            command = f"{first.command} && {second.command}"
        return seconds, command, image

    def anew(self):
        return {"seconds": self.anew_runs[0]}, self.anew_runs[1]

    def kept(self):
        """Time from the old cache, and how far its picture is from that of a new one."""
        runs = [self.image(self.scene.cache.path) for _ in range(self.scene.bench.repeat)]
        image, fresh = runs[0][0], self.anew_runs[2]
        errors = compare(image["multiple"], fresh["multiple"], body_mask(fresh))
        return {"seconds": [run.seconds for _, run in runs],
                **{name: [value] for name, value in errors.items()}}, runs[0][1].command


def measure(settings, bench):
    for name in settings.cases:
        case = case_named(name)
        scene = Scene(settings, bench, case, f"{name}-turn")
        # Indirect light would tie the cache to the medium.
        direct = Scene(settings, bench, case, f"{name}-direct", "--set", "settings.bounces=0")
        common = {"settings": dataclasses.asdict(settings), "inputs": case.fingerprint()}
        for series, how in ((TOGETHER, scene.together), (APART, scene.apart),
                            (FROM_NOTHING, scene.from_nothing)):
            bench.measure(NAME, name, series, "frames", settings.frames, how, **common)
        for k in range(settings.frames):
            bench.measure(NAME, name, TOGETHER, FRAME, k, lambda: scene.frame(k), **common)
        for kind, parameter in CHANGES.items():
            change = Change(direct if kind == "material" else scene, kind)
            value = settings.medium if kind == "material" else str(settings.light_scale)
            for series, how in ((ANEW, change.anew), (KEPT, change.kept)):
                bench.measure(NAME, name, series, parameter, value, how, **common)


# --- telling -------------------------------------------------------------------------------------

def point(bench, case, series, parameter):
    return bench.of(NAME, case=case, series=series, parameter=parameter)[0]


def plots_of(bench, settings):
    turns = [point(bench, case, series, "frames") for case in settings.cases
             for series in (TOGETHER, APART, FROM_NOTHING)]
    lone = len(settings.cases) == 1
    changes = [dataclasses.replace(point(bench, case, series, parameter),
                                   case=parameter if lone else f"{case}: {parameter}")
               for case in settings.cases for parameter in CHANGES.values()
               for series in (KEPT, ANEW)]
    frames = [dataclasses.replace(p, series=case) for case in settings.cases
              for p in bench.of(NAME, case=case, series=TOGETHER, parameter=FRAME)]
    return [
        Plot(f"{NAME}-turntable", plots.bars(turns, "seconds", "A frame of a turntable"),
             f"Time for each of {settings.frames} frames; bars from least to most of "
             f"{bench.repeat} turns, or of {settings.alone} frames.", turns[0].command),
        Plot(f"{NAME}-frames",
             plots.against(frames, "value", "seconds", log="", title="Frames of the turn"),
             "Time of each frame by the program's own clock, all in one process.",
             frames[0].command),
        Plot(f"{NAME}-changes", plots.bars(changes, "seconds", "A changed scene"),
             "Time to a picture after a change, from the cache that is there and from a new one.",
             changes[0].command)]


def turn_words(settings, bench, case):
    together, apart, nothing = (point(bench, case, series, "frames").median("seconds")
                                for series in (TOGETHER, APART, FROM_NOTHING))
    own = statistics.median(p.median("seconds") for p in
                            bench.of(NAME, case=case, series=TOGETHER, parameter=FRAME))
    return (f"{case}: a frame of the turntable takes {words.seconds(together)} in one process (its "
            f"own clock says {words.seconds(own)}, the rest is loading, shared by all), "
            f"{words.seconds(apart)} with a process a frame, {words.times(apart / together)} as "
            f"long, and {words.seconds(nothing)} if pass one is run for each, "
            f"{words.times(nothing / together)} as long.")


def change_words(settings, bench, case, parameter):
    kept, anew = (point(bench, case, series, parameter) for series in (KEPT, ANEW))
    return (f"After a change of the {parameter} the next picture takes "
            f"{words.seconds(kept.median('seconds'))} from the cache that is there and "
            f"{words.seconds(anew.median('seconds'))} with both passes, "
            f"{words.times(anew.median('seconds') / kept.median('seconds'))} as long; the two "
            f"pictures differ by {words.percent(kept.median('relRMSE'))} (relRMSE of the layer "
            "`multiple`).")


def table_of(settings, bench):
    rows = [[case, series, parameter, words.seconds(p.median("seconds")),
             words.percent(p.median("relRMSE")) if "relRMSE" in p.quantities else ""]
            for case in settings.cases
            for series, parameter in [(s, "frames") for s in (TOGETHER, APART, FROM_NOTHING)]
            + [(s, c) for c in CHANGES.values() for s in (KEPT, ANEW)]
            for p in [point(bench, case, series, parameter)]]
    return Table(["case", "how", "what", "time", "difference"], rows,
                 "All that was measured; medians.")


def section(settings, bench):
    size = settings.resolution
    text = ("One cache serves every camera, light colour and medium of the same index of "
            f"refraction. A turntable of {settings.frames} frames is rendered with {size} x {size} "
            f"pixels and {settings.camera_samples} camera rays a pixel: by one process, by a "
            "process a frame, and with both passes for each frame (the last two on "
            f"{settings.alone} of them). Then the light's colour is scaled by "
            f"{settings.light_scale}, and the body given the coefficients of {settings.medium}, "
            "while the cache stays. Times are of whole processes. For another medium indirect "
            "light is left out: where it is computed, it belongs to the medium. A cache made for "
            "another medium has that one's spacing; what this costs is the difference from a new "
            "one.\n\n"
            + "\n\n".join(" ".join([turn_words(settings, bench, case),
                                    *(change_words(settings, bench, case, parameter)
                                      for parameter in CHANGES.values())])
                          for case in settings.cases))
    return Section("What a cache saves", text, plots=plots_of(bench, settings),
                   tables=[table_of(settings, bench)])
