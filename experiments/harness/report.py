# SPDX-License-Identifier: Apache-2.0
"""Turns sections into one page that needs nothing else: pictures and plots are inside it.

report.html opens offline and on a phone, without scripts. Beside it, and linked from it, stand
results.csv and every plot as PNG in plots/.
"""
import base64
import html
import io
import pathlib
import re

from matplotlib import rc_context

from . import plots
from .bench import commit, machine
from .metrics import SEES_BODY

STYLE = (pathlib.Path(__file__).parent / "report.css").read_text(encoding="utf-8")

METHODS = f"""
relRMSE is the square root of the mean square difference, divided by the mean of the reference. \
Bias is the mean difference, divided by the same mean: negative where we are too dark. p99 and \
max are the 99th percentile and the largest of the relative error |I - R| / max(R, 0.01 mean R). \
All are over all three channels and over the pixels of which at least {SEES_BODY * 100:g} % \
shows the body (the reference's coverage A).

A reference that was made by chance has noise of its own. It comes with the variance of each \
pixel; the mean of that is taken off the mean square difference before the root is drawn. What \
is left is never below zero. p99, max and FLIP keep the noise, as no rule takes it off them; \
where a report says 2 x 2, they are measured on averages of 2 x 2 pixels, which halves it \
at best: a walk lights neighbouring pixels together. Where a table says "of noise", it is what \
p99 would be of independent noise alone. Bias needs no correction.

FLIP is HDR-FLIP [Andersson et al. 2021], the mean over the same pixels, everything else black \
in both images; its exposures follow the reference's luminance inside the body.

Times are wall time of whole processes unless a plot says otherwise. A point is the median of \
several runs, its bars go from the least to the most. Solid lines join what was measured; what \
was not measured is dashed. `experiments/compare.py` measures the same for any two EXR files.
"""


def write(suite, sections, bench, command):
    """Writes report.html, whose path it returns, and plots/*.png; `command` made them."""
    origin = _origin(command)
    names = [plot.name for section in sections for plot in section.plots]
    if len(set(names)) < len(names):
        raise ValueError(f"two plots share a name: {sorted(names)}")
    body = [_head(suite, bench, origin), _contents(sections)]
    body += [_section(number, section, bench.folder, origin)
             for number, section in enumerate(sections, 1)]
    body.append(_methods())
    page = _page(suite.title, "\n".join(body))
    path = bench.folder / "report.html"
    temporary = path.with_suffix(".tmp")
    temporary.write_text(page, encoding="utf-8")
    temporary.replace(path)
    return path


def _page(title, body):
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{html.escape(title)}</title>
<style>
{STYLE}</style>
</head>
<body>
<main>
{body}
</main>
</body>
</html>
"""


def _origin(command):
    """Machine, commit and command: the line that stands under every plot."""
    measured = commit()
    parts = [html.escape(machine())]
    parts += [f"commit {html.escape(measured)}"] if measured else []
    return " · ".join(parts + [f"<code>{html.escape(command)}</code>"])


def _head(suite, bench, origin):
    files = f'<a href="results.csv">results.csv</a>: all {len(bench.points)} measured points'
    runs = f"median of {bench.repeat} runs" if bench.repeat > 1 else "one run a point"
    return (f"<header>\n<h1>{html.escape(suite.title)}</h1>\n{_paragraphs(suite.about)}"
            f'<p class="origin">{origin}</p>\n<p>{files}, times as {runs}.</p>\n</header>')


def _contents(sections):
    items = [f'<li><a href="#section-{number}">{html.escape(section.title)}</a></li>'
             for number, section in enumerate(sections, 1)]
    items.append('<li><a href="#methods">Methods</a></li>')
    return "<nav>\n<ol>\n" + "\n".join(items) + "\n</ol>\n</nav>"


def _section(number, section, folder, origin):
    parts = [f'<section id="section-{number}">', f"<h2>{html.escape(section.title)}</h2>",
             _paragraphs(section.text)]
    parts += [_plot(plot, folder, origin) for plot in section.plots]
    parts += [_table(table) for table in section.tables]
    parts += [_pictures(row) for row in section.pictures]
    return "\n".join(parts + ["</section>"])


def _paragraphs(text):
    return "".join(f"<p>{_prose(part)}</p>\n" for part in text.split("\n\n") if part.strip())


def _prose(text):
    """Escaped text; what stands between backticks is code."""
    return re.sub("`([^`]+)`", r"<code>\1</code>", html.escape(" ".join(text.split())))


def _plot(plot, folder, origin):
    """The plot as an SVG picture, its PNG written beside the page and linked."""
    (folder / "plots").mkdir(exist_ok=True)
    png = f"plots/{plot.name}.png"
    drawing = io.BytesIO()
    with rc_context(plots.LOOK):
        plot.figure.savefig(folder / png, dpi=150)
        plot.figure.savefig(drawing, format="svg", metadata={"Date": None})
    measured = (f"<details><summary>command of a point</summary>"
                f"<code>{html.escape(plot.command)}</code></details>" if plot.command else "")
    return (f'<figure class="plot" id="{html.escape(plot.name)}">\n'
            f'<img alt="{html.escape(plot.caption)}" '
            f'src="{_data_uri("image/svg+xml", drawing.getvalue())}">\n'
            f'<figcaption>{_prose(plot.caption)} (<a href="{html.escape(png)}">PNG</a>)'
            f'<div class="origin">{origin}{measured}</div></figcaption>\n</figure>')


def _pictures(row):
    return '<div class="pictures">\n' + "\n".join(
        f'<figure><img alt="{html.escape(picture.caption)}" '
        f'src="{_data_uri("image/png", picture.path.read_bytes())}">'
        f"<figcaption>{html.escape(picture.caption)}</figcaption></figure>"
        for picture in row) + "\n</div>"


def _table(table):
    head = "".join(f"<th>{html.escape(str(column))}</th>" for column in table.columns)
    rows = "\n".join("<tr>" + "".join(map(_cell, row)) + "</tr>" for row in table.rows)
    return (f'<figure class="table"><figcaption>{_prose(table.caption)}</figcaption>\n'
            f'<div class="scrolls"><table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}\n'
            "</tbody>\n</table></div></figure>")


def _cell(value):
    if isinstance(value, str):
        kind = ' class="short"' if len(value) < 14 else ""
        return f"<td{kind}>{html.escape(value)}</td>"
    return f'<td class="number">{"–" if value is None else f"{value:.4g}"}</td>'


def _methods():
    return f'<section id="methods">\n<h2>Methods</h2>\n{_paragraphs(METHODS)}</section>'


def _data_uri(kind, content):
    return f"data:{kind};base64,{base64.b64encode(content).decode('ascii')}"
