# SPDX-License-Identifier: Apache-2.0
"""Running evaluator-sweep and sampling-sweep, which measure many settings at once, as CSV."""
import csv

from . import programs
from .cases import ROOT

BUILD = ROOT / "build" / "release"


def _words(values):
    return ",".join(map(str, values))


def evaluator_sweep(scene, cache, *flags, criterion, accuracy=(), certify=(), samples=1, reference,
                    repeat, budget=None, threads=None, build=BUILD):
    """Error and time of the sums over samples: rows as docs/EVALUATOR.md names them, and the run.

    criterion error takes tolerances as `accuracy` and `certify`; solid-angle and formula take solid
    angles and leave out those that would need more than `budget` seconds. `samples` are camera rays
    a pixel, `reference` the points where the plain sum is computed.
    """
    arguments = [scene, cache, "--criterion", criterion, "--accuracy", _words(accuracy),
                 "--samples", samples, "--reference", reference, "--repeat", repeat, *flags]
    if certify:
        arguments += ["--certify", _words(certify)]
    if budget:
        arguments += ["--budget", budget]
    if threads:
        arguments += ["--threads", threads]
    run = programs.run("evaluator-sweep", *arguments, bin=build / "experiments/evaluator")
    return list(csv.DictReader(run.stdout.splitlines())), run


def sampling_sweep(body, *flags, build=BUILD):
    """Error of the exitance by kinds of samples: rows as experiments/sampling.py says, the run."""
    run = programs.run("sampling-sweep", body, *flags, bin=build / "experiments/sampling")
    return list(csv.DictReader(run.stdout.splitlines())), run
