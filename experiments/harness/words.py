# SPDX-License-Identifier: Apache-2.0
"""Measured numbers as a reader wants them in a sentence or a table."""


def seconds(value):
    """0.32 ms, 21 ms, 1.4 s, 130 s."""
    return f"{significant(1000 * value)} ms" if value < 0.1 else f"{significant(value)} s"


def percent(fraction):
    return f"{significant(100 * fraction)} %"


def times(ratio):
    return f"{significant(ratio)} times"


def memory(mib):
    return f"{significant(mib)} MiB" if mib < 1024 else f"{significant(mib / 1024)} GiB"


def count(number):
    """285 578, as 286k; 1.2M."""
    for size, letter in ((1e6, "M"), (1e3, "k")):
        if number >= size:
            return f"{significant(number / size, 3)}{letter}"
    return f"{number:g}"


def significant(value, digits=2):
    """So many significant digits, without an exponent: 0.00013, 21, 1300."""
    if value == 0:
        return "0"
    rounded = float(f"{value:.{digits}g}")
    text = f"{rounded:.12f}".rstrip("0").rstrip(".")
    return text if text not in ("0", "-0") else f"{rounded:g}"


def listed(items):
    """a, b and c."""
    items = list(items)
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} and {items[-1]}"
