# SPDX-License-Identifier: Apache-2.0
"""Measured settings, and results.csv."""
import csv
import dataclasses
import statistics

# Phases of the programs' --stats that are written down, one quantity seconds_PHASE each.
PHASES = ["sample", "irradiance", "indirect", "octree", "primary", "exitance", "single"]

# What is measured: unit and the words beside an axis.
QUANTITIES = {
    "seconds": ("s", "time"),
    "relRMSE": ("1", "relRMSE"),
    "relRMSE_picture": ("1", "RMSE of a layer / mean of all scattered light"),
    "bias": ("1", "mean difference / mean"),
    "p99": ("1", "99th percentile of the relative error"),
    "max": ("1", "largest relative error"),
    "flip": ("1", "mean FLIP"),
    "noise": ("1", "relRMSE of the reference's own noise"),
    "noise_p99": ("1", "99th percentile of the relative error by the reference's own noise"),
    "own_noise": ("1", "relRMSE of the renderer's own noise"),
    "floor": ("1", "error that no time takes away"),
    "startup_seconds": ("s", "start-up, not part of the time"),
    "peak_mib": ("MiB", "peak memory"),
    "samples": ("1", "samples on the surface"),
    "evaluations": ("1", "kernel evaluations a point, all channels"),
    **{f"seconds_{phase}": ("s", f"time of the phase {phase}") for phase in PHASES},
}


@dataclasses.dataclass
class Point:
    """One setting of one experiment, and everything that was measured there.

    quantities[name] holds a number a run (or one, where runs cannot differ); see QUANTITIES.
    """
    experiment: str  # the section it belongs to: hierarchy, model ...
    case: str        # FIGURE-MEDIUM, or "" where it is none
    series: str      # the line in a plot: the method
    parameter: str   # what is varied along the line
    value: float | str
    quantities: dict
    command: str = ""

    def median(self, quantity):
        return statistics.median(self.quantities[quantity])

    def range(self, quantity):
        return min(self.quantities[quantity]), max(self.quantities[quantity])


def by_value(points):
    """Points along their line, by the value that is varied."""
    return sorted(points, key=lambda point: point.value)


COLUMNS = ["experiment", "case", "series", "parameter", "value", "quantity", "unit", "median",
           "least", "most", "runs", "command"]


def write_csv(points, path):
    """A row a point and quantity; numbers with six digits."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for point in points:
            for quantity, numbers in point.quantities.items():
                least, most = point.range(quantity)
                writer.writerow([point.experiment, point.case, point.series, point.parameter,
                                 point.value, quantity, QUANTITIES[quantity][0],
                                 f"{point.median(quantity):.6g}", f"{least:.6g}", f"{most:.6g}",
                                 len(numbers), point.command])
