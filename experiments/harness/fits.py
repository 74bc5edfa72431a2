# SPDX-License-Identifier: Apache-2.0
"""Powers fitted to measurements, and reading between measured points."""
import dataclasses
import math

import numpy


@dataclasses.dataclass(frozen=True)
class PowerLaw:
    """y = factor * x^exponent."""
    exponent: float
    error: float  # standard error of the exponent; nan from two points, which fit exactly
    factor: float

    def __call__(self, x):
        return self.factor * x ** self.exponent

    def words(self):
        """The exponent for a reader: 0.98 +- 0.02."""
        if math.isnan(self.error):
            return f"{self.exponent:.2f} (two points)"
        return f"{self.exponent:.2f} ± {self.error:.2f}"


def power_law(x, y):
    """Least squares on the logarithms; None below two different x. All numbers must be > 0.

    The standard error is that of the slope of a straight line: sqrt(sum r^2 / (n - 2) /
    sum (u - mean u)^2), with r the residuals and u = log x.
    """
    u, v = numpy.log(numpy.asarray(x, float)), numpy.log(numpy.asarray(y, float))
    spread = float(numpy.sum((u - u.mean()) ** 2)) if len(u) else 0
    if len(u) < 2 or spread < 1e-12:
        return None
    slope = float(numpy.sum((u - u.mean()) * (v - v.mean())) / spread)
    residuals = v - v.mean() - slope * (u - u.mean())
    error = math.nan
    if len(u) > 2:
        error = math.sqrt(float(numpy.sum(residuals ** 2)) / (len(u) - 2) / spread)
    return PowerLaw(slope, error, math.exp(float(v.mean() - slope * u.mean())))


def y_at(x, y, at):
    """y where x is `at`, logarithms interpolated; None outside of what was measured.

    Of measurements at the same x, the least y counts. All numbers must be > 0.
    """
    pairs = sorted(zip(x, y))
    unique = {a: b for a, b in reversed(pairs)}  # the first of equal x stays
    xs = sorted(unique)
    if not xs or not xs[0] <= at <= xs[-1]:
        return None
    return math.exp(numpy.interp(math.log(at), numpy.log(xs),
                                 numpy.log([unique[a] for a in xs])))


def fit_of(points, x, y):
    """power_law() through the medians of Points; x and y are quantities, or "value" for x."""
    def number(point, name):
        return point.value if name == "value" else point.median(name)
    return power_law([number(p, x) for p in points], [number(p, y) for p in points])


def median_at(points, error, quantity="seconds", of="relRMSE"):
    """The quantity at an error, between the medians of Points; None outside of them."""
    points = [p for p in points if p.quantities and p.median(of) > 0]
    return y_at([p.median(of) for p in points], [p.median(quantity) for p in points], error)
