# SPDX-License-Identifier: Apache-2.0
"""Caches that are made only if something is measured with them."""
import functools


class CacheOnDemand:
    """A case's cache, made when it is first asked for.

    The journal may know already everything that would be measured with it. `name` tells caches of
    one case apart that are used at the same time.
    """

    def __init__(self, bench, case, *flags, name=None, material=None):
        self.bench, self.case, self.flags = bench, case, flags
        self.name, self.material = name, material

    @functools.cached_property
    def path(self):
        return self.bench.cache(self.case, *self.flags, name=self.name, material=self.material)[0]
