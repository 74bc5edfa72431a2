# SPDX-License-Identifier: Apache-2.0
"""Numbers in the documentation, generated from published results and never typed.

A document says where: `<!-- results: NAME -->` ... `<!-- /results -->`, each on a line of its own;
experiments/published.yaml says what stands between, from docs/results/SUITE/results.csv:

    NAME:
      suite: full
      text: "{fast} against {slow}, {ratio} times faster."
      numbers:
        fast: {of: {experiment: total, case: bunny-marble, series: tallow}, quantity: seconds,
               at: {relRMSE: 0.1}, format: seconds}     # interpolated along the series
        slow: {of: {experiment: total, series: other}, quantity: seconds, format: seconds}
        ratio: {quotient: [slow, fast], format: number}
    OTHER:
      suite: full
      table: {of: {experiment: model, value: everything}, rows: case, columns: series,
              quantity: relRMSE, format: percent}

`of` are columns of results.csv and what they must hold; a number must meet exactly one row.
"""
import csv
import dataclasses
import math
import re
import shutil
import typing

from . import words
from .cases import ROOT
from .suite import InputError, checked, read_yaml

BEGIN = re.compile(r"<!-- results: ([\w-]+) -->\s*$")
END = "<!-- /results -->"


FORMATS = {"percent": words.percent, "seconds": words.seconds, "number": words.significant,
           "memory": words.memory, "count": words.count}
Format = typing.Literal[tuple(FORMATS)]


@dataclasses.dataclass
class Number:
    """A number of results.csv, or the quotient of two others of the same text."""
    of: dict = dataclasses.field(default_factory=dict)
    quantity: str = ""
    at: dict = dataclasses.field(default_factory=dict)
    quotient: list[str] = dataclasses.field(default_factory=list)
    format: Format = "number"


@dataclasses.dataclass
class Table:
    of: dict
    rows: str
    columns: str
    quantity: str
    format: Format = "number"
    corner: str = ""  # what stands above the first column


@dataclasses.dataclass
class Template:
    suite: str
    text: str = ""
    numbers: dict = dataclasses.field(default_factory=dict)
    table: dict = dataclasses.field(default_factory=dict)


class Results:
    """The rows of a results.csv."""

    def __init__(self, path):
        try:
            with open(path, newline="", encoding="utf-8") as file:
                self.rows = list(csv.DictReader(file))
        except OSError as error:
            raise InputError(f"{path}: {error.strerror}; publish the suite first") from None

    def select(self, of):
        return [row for row in self.rows
                if all(_same(row.get(key), value) for key, value in of.items())]

    def at(self, of, quantity, level):
        """`quantity` where another one has a value, between neighbours on logarithmic axes."""
        (other, value), = level.items()
        pairs = {}
        for row in self.select(of):
            if row["quantity"] in (quantity, other):
                pairs.setdefault(row["value"], {})[row["quantity"]] = float(row["median"])
        curve = sorted((p[other], p[quantity]) for p in pairs.values() if len(p) == 2)
        for (x0, y0), (x1, y1) in zip(curve, curve[1:]):
            if x0 <= value <= x1:
                part = math.log(value / x0) / math.log(x1 / x0) if x1 > x0 else 0.0
                return y0 * (y1 / y0) ** part
        raise InputError(f"{of}: no {quantity} measured on both sides of {other} = {value:g}")


def _same(text, value):
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        try:
            return math.isclose(float(text), value)
        except (TypeError, ValueError):
            return False
    return text == value


def _value(results, numbers, name):
    if name not in numbers:
        raise InputError(f"no number called {name}, expected one of {', '.join(numbers)}")
    number = numbers[name]
    if number.quotient:
        over, under = (_value(results, numbers, part) for part in number.quotient)
        return over / under
    if number.at:
        return results.at(number.of, number.quantity, number.at)
    rows = results.select({**number.of, "quantity": number.quantity})
    if len(rows) != 1:
        raise InputError(f"{name}: {number.of} {number.quantity}: expected one row, "
                         f"got {len(rows)}")
    return float(rows[0]["median"])


def _filled(template, results):
    numbers = {name: checked(Number, mapping) for name, mapping in template.numbers.items()}

    def fill(match):
        name = match.group(1)
        return FORMATS[numbers[name].format if name in numbers else "number"](
            _value(results, numbers, name))
    return re.sub(r"\{(\w+)\}", fill, template.text.strip())


def _markdown(table, results):
    """A Markdown table; cells that were not measured stay empty."""
    rows = results.select({**table.of, "quantity": table.quantity})
    if not rows:
        raise InputError(f"table: {table.of} {table.quantity}: no such row")
    names, columns = (list(dict.fromkeys(row[key] for row in rows))
                      for key in (table.rows, table.columns))
    cells = {}
    for row in rows:
        place = row[table.rows], row[table.columns]
        if place in cells:
            raise InputError(f"table: {place[0]}, {place[1]}: expected one row, got two")
        cells[place] = FORMATS[table.format](float(row["median"]))
    lines = [[table.corner or table.rows, *columns], ["---"] * (len(columns) + 1)]
    lines += [[name, *(cells.get((name, column), "") for column in columns)] for name in names]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def text_of(name, root):
    """What stands between the markers of NAME."""
    path = root / "experiments/published.yaml"
    templates = read_yaml(path) or {}
    if name not in templates:
        raise InputError(f"{path}: no entry {name}")
    try:
        template = checked(Template, templates[name])
        results = Results(root / "docs/results" / template.suite / "results.csv")
        if template.table:
            return _markdown(checked(Table, template.table), results)
        return _filled(template, results)
    except InputError as error:
        where = "" if str(path) in str(error) else f"{templates.where(name)}: "
        raise InputError(f"{where}{name}: {error}") from None


def documents(root):
    return [root / "README.md", *sorted((root / "docs").rglob("*.md"))]


def regenerated(path, root):
    """The document's text with every marked part as it should be. Throws InputError."""
    result, inside = [], None
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        begin = BEGIN.match(line)
        if begin and inside:
            raise InputError(f"{path}:{inside}: no {END} before line {number}")
        if begin:
            inside = number
            result += [line, *text_of(begin.group(1), root).splitlines()]
        elif line.strip() == END:
            if not inside:
                raise InputError(f"{path}:{number}: {END} without a beginning")
            inside = None
        if not inside and not begin or line.strip() == END:
            result.append(line)
    if inside:
        raise InputError(f"{path}:{inside}: no {END}")
    return "\n".join(result) + "\n"


def stale(root=ROOT):
    """Documents whose marked parts are not what published results give."""
    return [path for path in documents(root) if _has_markers(path)
            and path.read_text(encoding="utf-8") != regenerated(path, root)]


def _has_markers(path):
    text = path.read_text(encoding="utf-8")
    return "<!-- results:" in text or END in text


def rewrite(root=ROOT):
    """Brings every document up to date; returns those that changed."""
    changed = stale(root)
    for path in changed:
        path.write_text(regenerated(path, root), encoding="utf-8")
    return changed


def publish(suite_name, folder, root=ROOT):
    """Copies a suite's report, results and plots to docs/results/SUITE and rewrites documents."""
    to = root / "docs/results" / suite_name
    shutil.rmtree(to / "plots", ignore_errors=True)
    to.mkdir(parents=True, exist_ok=True)
    for name in ("report.html", "results.csv"):
        shutil.copy(folder / name, to / name)
    shutil.copytree(folder / "plots", to / "plots")
    return rewrite(root)
