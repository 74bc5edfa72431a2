# SPDX-License-Identifier: Apache-2.0
"""What a kind of experiment measures with."""
import hashlib
import os
import pathlib
import platform
import subprocess

from . import programs
from .cases import ROOT, Case
from .journal import Journal
from .points import Point


class Bench:
    """One run of a suite: its folder, its journal, the points measured so far.

    A kind calls measure() for each setting; what the journal has already is not measured again.
    """

    def __init__(self, folder: pathlib.Path, repeat: int, say=print):
        self.folder, self.repeat, self.say = folder, repeat, say
        folder.mkdir(parents=True, exist_ok=True)
        self.work = folder / "work"  # caches and images; may be deleted
        self.work.mkdir(exist_ok=True)
        self.journal = Journal(folder / "journal.jsonl")
        self.points: list[Point] = []
        self.programs = programs_fingerprint()

    def measure(self, experiment, case, series, parameter, value, how, **identity):
        """The Point of a setting; how() -> (quantities, command) is called if it is not known.

        `identity` is what else decides the result: everything how() uses that is not in the names.
        """
        of = {"experiment": experiment, "case": case, "series": series, "parameter": parameter,
              "value": value, "repeat": self.repeat, "programs": self.programs, **identity}

        def noted():
            self.say(f"{experiment}: {case} {series} {parameter}={value}")
            quantities, command = how()
            return {"quantities": quantities, "command": command}

        result = self.journal.get_or_measure(of, noted)
        point = Point(experiment, case, series, parameter, value, result["quantities"],
                      result["command"])
        self.points.append(point)
        return point

    def of(self, experiment, **wanted):
        """The points of an experiment whose fields are as wanted."""
        return [p for p in self.points if p.experiment == experiment
                and all(getattr(p, name) == value for name, value in wanted.items())]

    def cache(self, case: Case, *flags, name=None,
              material=None) -> tuple[pathlib.Path, programs.Run]:
        """Pass one of a case: its cache file and the run that made it; made anew each time."""
        path = self.work / f"{name or case.name}.tallow"
        return path, programs.run("tallow-precompute", case.scene, "-o", path,
                                  *case.flags(**(material or {})), *flags)

    def image(self, case: Case, cache, name, *flags, material=None, layers="all"):
        """Pass two of a case: its image (with such layers) and the run that made it."""
        path = self.work / f"{name}.exr"
        return path, programs.run("tallow-render", case.scene, "--cache", cache, "-o", path,
                                  "--aovs", layers, *case.flags(**(material or {})), *flags)


def programs_fingerprint():
    """Changes whenever one of the programs does."""
    digest = hashlib.sha256()
    build = ROOT / "build/release"
    for path in sorted([*build.glob("bin/*"), *build.glob("experiments/*/*-sweep")]):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def machine():
    """What times depend on, a line to print under a plot."""
    model = next((line.split(":", 1)[1].strip() for line in open("/proc/cpuinfo", encoding="utf-8")
                  if line.startswith("model name")), platform.machine())
    return f"{model}, {os.cpu_count()} threads, {platform.system()}"


def commit():
    """The commit measured, with a + if files differ from it; empty outside a checkout."""
    try:
        def git(*words):
            return subprocess.run(["git", "-C", ROOT, *words], capture_output=True, text=True,
                                  check=True).stdout.strip()
        return git("rev-parse", "--short", "HEAD") + ("+" if git("status", "--porcelain") else "")
    except (OSError, subprocess.CalledProcessError):
        return ""
