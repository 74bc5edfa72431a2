# SPDX-License-Identifier: Apache-2.0
"""Light in a plane slab, without approximation but the grid's: isotropic scattering, Fresnel at both
surfaces. The integral equation of transport for the collisions q(z), order by order or all at once.

Lengths in mean free paths. Light enters the top (z = 0) at the cosine mu_0 inside, with the
transmitted irradiance 1. Radiance is per unit of cosine: L / (2 pi) is per steradian.
"""
import numpy


def reflectance_inside(mu, eta):
    """Fresnel, unpolarized, from inside; 1 beyond the critical angle."""
    sin2 = (1 - mu * mu) * eta * eta
    result = numpy.ones_like(mu)
    out = sin2 < 1
    cos_t, cos_i = numpy.sqrt(1 - sin2[out]), mu[out]
    s = (eta * cos_i - cos_t) / (eta * cos_i + cos_t)
    p = (eta * cos_t - cos_i) / (eta * cos_t + cos_i)
    result[out] = (s * s + p * p) / 2
    return result


def cosines(eta, n=24):
    """Nodes and weights over (0, 1), the critical angle being a border of two rules."""
    x, w = numpy.polynomial.legendre.leggauss(n)
    x, w = (x + 1) / 2, w / 2
    critical = numpy.sqrt(1 - 1 / eta ** 2)
    # Quadratic above it, where the reflectance has a vertical tangent.
    return (numpy.concatenate([critical * x, critical + (1 - critical) * x * x]),
            numpy.concatenate([critical * w, (1 - critical) * 2 * x * w]))


class Slab:
    def __init__(self, thickness, albedo, eta):
        self.thickness, self.albedo, self.eta = thickness, albedo, eta
        cells = int(numpy.clip(25 * thickness, 60, 400))
        # Cells get smaller towards both surfaces.
        self.edges = (1 - numpy.cos(numpy.pi * numpy.arange(cells + 1) / cells)) / 2 * thickness
        self.widths = numpy.diff(self.edges)
        self.mu, self.weights = cosines(eta)
        self.reflectance = reflectance_inside(self.mu, eta)
        self._trace()

    def _trace(self):
        """kernel[i, j]: mean fluence in cell i by collisions 1 in cell j. top, bottom [mu, j]:
        radiance that arrives at the surfaces from inside."""
        e, n = self.edges, len(self.widths)
        self.kernel, top, bottom = numpy.zeros((n, n)), [], []
        for mu, weight, R in zip(self.mu, self.weights, self.reflectance):
            depth = self.widths / mu
            emitted = -numpy.expm1(-depth)
            mean = emitted / depth
            to_top, to_bottom = numpy.exp(-e[:-1] / mu), numpy.exp(-(self.thickness - e[1:]) / mu)
            through = numpy.exp(-self.thickness / mu)
            back_and_forth = 1 - (R * through) ** 2
            at_top = emitted * (to_top + through * R * to_bottom) / back_and_forth
            at_bottom = emitted * (to_bottom + through * R * to_top) / back_and_forth
            top.append(at_top / 2)
            bottom.append(at_bottom / 2)
            mirrored = R * (numpy.outer(to_top * mean, at_top) +
                            numpy.outer(to_bottom * mean, at_bottom))
            gap = numpy.exp(-numpy.abs(e[:-1, None] - e[None, 1:]) / mu)
            down = numpy.tril(numpy.outer(mean, emitted) * gap, -1)
            up = numpy.triu(numpy.outer(mean, emitted) * gap.T, 1)
            self.kernel += weight / 2 * (mirrored + down + up + numpy.diag(2 * (1 - mean)))
        self.top, self.bottom = numpy.array(top), numpy.array(bottom)

    def first_collisions(self, mu_0):
        """Density of what scatters once, by cell."""
        R = reflectance_inside(numpy.array([mu_0]), self.eta)[0]
        through = numpy.exp(-self.thickness / mu_0)
        e = self.edges
        down = (numpy.exp(-e[:-1] / mu_0) - numpy.exp(-e[1:] / mu_0)) / self.widths
        up = (numpy.exp(-(self.thickness - e[1:]) / mu_0) -
              numpy.exp(-(self.thickness - e[:-1]) / mu_0)) / self.widths
        return self.albedo * (down + R * through * up) / (1 - (R * through) ** 2)

    def later_collisions(self, mu_0):
        """Density of what scatters for the second time or a later one."""
        second = self.albedo * self.kernel @ self.first_collisions(mu_0)
        unit = numpy.eye(len(self.widths))
        return numpy.linalg.solve(unit - self.albedo * self.kernel, second)

    def leaving(self, collisions, mu):
        """Radiance outside, per steradian, at cosines mu outside: of the top, of the bottom."""
        mu = numpy.asarray(mu, dtype=float)
        inside = numpy.sqrt(1 - (1 - mu ** 2) / self.eta ** 2)
        T = (1 - reflectance_inside(inside, self.eta)) / self.eta ** 2 / (2 * numpy.pi)
        order = numpy.argsort(self.mu)
        return tuple(T * numpy.interp(inside, self.mu[order], (side @ collisions)[order])
                     for side in (self.top, self.bottom))
