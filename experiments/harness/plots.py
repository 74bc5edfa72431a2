# SPDX-License-Identifier: Apache-2.0
"""One look for all plots: the size of a phone's screen, axes with units, measured points solid.

A plot draws Points (points.py). `x` and `y` name a quantity of points.QUANTITIES, or "value", the
parameter that is varied. Error bars run from the least to the most of the runs behind a point. A
series keeps its colour and marker wherever it is drawn. What was not measured is dashed.

Every function that returns a Figure has drawn it completely; those that take Axes add to one.
"""
import dataclasses
import math

import matplotlib
import numpy

matplotlib.use("Agg")
from matplotlib import figure as mpl_figure  # noqa: E402
from matplotlib import lines, rc_context, ticker  # noqa: E402

from .points import QUANTITIES  # noqa: E402

INCHES = 4.8, 4.0  # at 390 pixels' width a letter of 10 points is still 11 pixels tall
LOOK = {
    "font.family": "DejaVu Sans", "font.size": 10, "axes.labelsize": 10, "axes.titlesize": 11,
    "xtick.labelsize": 9, "ytick.labelsize": 9, "legend.fontsize": 9, "legend.frameon": False,
    "axes.spines.top": False, "axes.spines.right": False, "axes.axisbelow": True,
    "axes.grid": True, "grid.color": "#dddddd", "grid.linewidth": 0.6, "lines.linewidth": 1.6,
    "lines.markersize": 5.5, "figure.facecolor": "white", "svg.hashsalt": "tallow",
    "svg.fonttype": "path",
}

# Okabe and Ito's palette, told apart by colour-blind readers; yellow is too pale for lines.
PALETTE = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#000000", "#56B4E9", "#E69F00"]
MARKERS = "osD^vPX"

# Errors are fractions in results.csv and per cent on axes.
IN_PERCENT = {"relRMSE", "bias", "p99", "max", "noise", "noise_p99", "own_noise", "floor"}


@dataclasses.dataclass(frozen=True)
class Style:
    color: str
    marker: str


def styles(names):
    """A Style for each name, by its place: first come, first coloured. Up to 49 differ."""
    unique = list(dict.fromkeys(names))
    return {name: Style(PALETTE[i % len(PALETTE)],
                        MARKERS[(i + i // len(PALETTE)) % len(MARKERS)])
            for i, name in enumerate(unique)}


def axis_label(quantity, parameter=""):
    """What stands beside an axis: words and unit. `parameter` names "value"."""
    if quantity == "value":
        return parameter
    unit, words = QUANTITIES[quantity]
    if quantity in IN_PERCENT:
        return f"{words} (%)"
    return words if unit == "1" else f"{words} ({unit})"


def empty(x_label, y_label, log="xy", title=""):
    """A Figure and its Axes; `log` says which axes are logarithmic: "", "x", "y" or "xy"."""
    with rc_context(LOOK):
        figure = mpl_figure.Figure(figsize=INCHES, layout="constrained")
        axes = figure.add_subplot()
        for name, axis in (("x", axes.xaxis), ("y", axes.yaxis)):
            if name in log:
                _make_logarithmic(axes, name, axis)
        axes.set_xlabel(x_label)
        axes.set_ylabel(y_label)
        axes.set_title(title, loc="left", wrap=True)
    return figure, axes


def _make_logarithmic(axes, name, axis):
    getattr(axes, f"set_{name}scale")("log")
    axis.set_major_formatter(ticker.FuncFormatter(_plain))
    axis.set_minor_formatter(ticker.FuncFormatter(lambda value, _: _minor(value, axis)))
    axis.grid(True, which="minor", color="#f0f0f0", linewidth=0.4)


def _plain(value, _=None):
    """0.001, 0.1, 10, 1000, 10k, 1M: numbers as people say them."""
    for factor, letter in ((1e9, "G"), (1e6, "M"), (1e4, "k")):
        if abs(value) >= factor:
            return f"{value / (1e3 if letter == 'k' else factor):g}{letter}"
    return f"{value:g}"


def _minor(value, axis):
    """2 and 5 get numbers where an axis spans little more than a decade."""
    low, high = axis.get_view_interval()
    if low <= 0 or high / low > 60:
        return ""
    lead = round(value / 10 ** math.floor(math.log10(value) + 1e-9))
    return _plain(value) if lead in ((2, 5) if high / low > 5 else (1, 2, 3, 4, 5, 7)) else ""


def numbers_of(point, quantity):
    """Median, least and most of a quantity (or the varied "value"), as plotted: errors in %."""
    if quantity == "value":
        return (float(point.value),) * 3
    scale = 100 if quantity in IN_PERCENT else 1
    least, most = point.range(quantity)
    return scale * point.median(quantity), scale * least, scale * most


def draw_series(axes, points, x, y, style, label, joined=True):
    """Adds the points of one series, in the order of x, with bars from least to most."""
    triples = sorted((numbers_of(p, x), numbers_of(p, y)) for p in points)
    if not triples:
        return
    xs, ys = (numpy.array(column, dtype=float) for column in zip(*triples))
    axes.errorbar(xs[:, 0], ys[:, 0], xerr=_bars(xs), yerr=_bars(ys), label=label,
                  color=style.color, marker=style.marker, linestyle="-" if joined else "none",
                  elinewidth=1, capsize=2)


def _bars(numbers):
    """Distances down and up from the median, or None if every run said the same."""
    below, above = numbers[:, 0] - numbers[:, 1], numbers[:, 2] - numbers[:, 0]
    return numpy.array([below, above]) if (below + above).any() else None


def draw_dashed(axes, xs, ys, style, label=None):
    """Adds a line that was not measured."""
    axes.plot(xs, ys, linestyle=(0, (4, 3)), linewidth=1.3, color=style.color, label=label)


def draw_floor(axes, y, text, color="#666666", right=1.0):
    """Adds a level that a line cannot pass; `y` as plotted, words up to `right` of the width."""
    axes.axhline(y, color=color, linewidth=1, linestyle=":")
    words = axes.annotate(text, (right, y), xycoords=("axes fraction", "data"), ha="right",
                          va="bottom", fontsize=8, color=color, xytext=(0, 2),
                          textcoords="offset points")
    words.set_in_layout(False)  # or a level near the edge takes the axes' room


def draw_values(axes, points, x, y, words="{:g}"):
    """Writes the varied value beside each point."""
    for point in points:
        text = words.format(point.value) if isinstance(point.value, (int, float)) else point.value
        draw_words(axes, point, x, y, text)


def draw_words(axes, point, x, y, text):
    """Writes beside a point."""
    words = axes.annotate(text, (numbers_of(point, x)[0], numbers_of(point, y)[0]), fontsize=7,
                          color="#555555", xytext=(4, 4), textcoords="offset points")
    words.set_in_layout(False)


def finish(figure, axes):
    """Adds the legend under the axes, if there is more than one series or a dashed line."""
    with rc_context(LOOK):
        handles, labels = axes.get_legend_handles_labels()
        dashed = any(line.get_linestyle() == "--" and len(line.get_xdata()) for line in axes.lines)
        if dashed:
            handles.append(lines.Line2D([], [], color="#666666", linestyle=(0, (4, 3))))
            labels.append("extrapolated")
        if len(labels) > 1:
            columns = 1 if max(map(len, labels)) > 24 else 2
            figure.legend(handles, labels, loc="outside lower center", ncols=columns)
    return figure


def against(points, x, y, log="xy", title="", parameter=None, fit=False, show_values=False,
            series=None):
    """One line a series, y over x. With `fit`, the legend says "proportional to x^0.93".

    `series` fixes order (and so colours); series without points there are left out.
    """
    parameter = parameter or (points[0].parameter if points else "")
    figure, axes = empty(axis_label(x, parameter), axis_label(y, parameter), log, title)
    names = series or list(dict.fromkeys(p.series for p in points))
    with rc_context(LOOK):
        for name, style in styles(names).items():
            own = [p for p in points if p.series == name]
            if not own:
                continue
            draw_series(axes, own, x, y, style, name + (_fit_words(own, x, y) if fit else ""))
            if show_values:
                draw_values(axes, own, x, y)
    return finish(figure, axes)


def _fit_words(points, x, y):
    exponent = fitted_exponent(points, x, y)
    return "" if exponent is None else rf"  $\propto x^{{{exponent:.2f}}}$"


def fitted_exponent(points, x, y):
    """b of y = a x^b through the medians, least squares of logarithms; None below two points."""
    pairs = [(numbers_of(p, x)[0], numbers_of(p, y)[0]) for p in points]
    pairs = [(a, b) for a, b in pairs if a > 0 and b > 0]
    if len({a for a, _ in pairs}) < 2:
        return None
    logs = numpy.log(numpy.array(pairs))
    return float(numpy.polyfit(logs[:, 0], logs[:, 1], 1)[0])


def error_against_time(points, error="relRMSE", seconds="seconds", title="", floors=None,
                       extrapolate=None, show_values=False, series=None):
    """Error over time, one line a series, both axes logarithmic.

    `floors` {words: error}: levels that lines end at, drawn dotted. `extrapolate` {series: error}:
    dashed on from that series' last point along time^(-1/2), as noise falls, down to that error.
    """
    figure, axes = empty(axis_label(seconds), axis_label(error), "xy", title)
    names = series or list(dict.fromkeys(p.series for p in points))
    with rc_context(LOOK):
        for name, style in styles(names).items():
            own = [p for p in points if p.series == name]
            draw_series(axes, own, seconds, error, style, name)
            if show_values:
                draw_values(axes, own, seconds, error)
            if own and name in (extrapolate or {}):
                last = max(own, key=lambda p: p.median(seconds))
                target = extrapolate[name] * (100 if error in IN_PERCENT else 1)
                _draw_noise_to(axes, numbers_of(last, seconds)[0], numbers_of(last, error)[0],
                               target, style)
        for words, level in (floors or {}).items():
            draw_floor(axes, level * (100 if error in IN_PERCENT else 1), words)
    return finish(figure, axes)


def _draw_noise_to(axes, seconds, error, target, style):
    if target < error:
        draw_dashed(axes, [seconds, seconds * (error / target) ** 2], [error, target], style)


def bars(points, quantity, title="", group="case", series=None, log=False):
    """Bars beside one another, a colour a series, a group of bars a case (or another field)."""
    groups = {}
    for point in points:
        if quantity in point.quantities:
            own = groups.setdefault(str(getattr(point, group)), {})
            own[point.series] = numbers_of(point, quantity)
    return _grouped_bars(groups, axis_label(quantity), title, series or [p.series for p in points],
                         log)


def bars_of(points, quantities, title="", series=None):
    """Bars as above, a group a quantity; all of them errors in per cent, a point a series."""
    groups = {words: {p.series: numbers_of(p, quantity) for p in points}
              for quantity, words in quantities.items()}
    return _grouped_bars(groups, "%", title, series or [p.series for p in points], False)


def _grouped_bars(groups, label, title, series, log):
    """groups {words: {series: (median, least, most)}}."""
    figure, axes = empty("", label, "y" if log else "", title)
    table = styles(series)
    width = 0.8 / len(table)
    with rc_context(LOOK):
        for place, (name, style) in enumerate(table.items()):
            at = [g for g, own in enumerate(groups.values()) if name in own]
            numbers = [own[name] for own in groups.values() if name in own]
            if not at:
                continue
            numbers = numpy.array(numbers)
            axes.bar(numpy.array(at) + (place - (len(table) - 1) / 2) * width, numbers[:, 0],
                     0.92 * width, color=style.color, label=name, yerr=_bars(numbers),
                     error_kw={"elinewidth": 1, "capsize": 2})
        axes.grid(False, axis="x", which="both")
        axes.axhline(0, color="black", linewidth=0.8)
        slanted = len(groups) > 4 or sum(map(len, groups)) > 40
        axes.set_xticks(range(len(groups)), groups, rotation=40 if slanted else 0,
                        ha="right" if slanted else "center")
    return finish(figure, axes)
