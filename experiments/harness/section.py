# SPDX-License-Identifier: Apache-2.0
"""What an experiment tells its reader; report.py turns sections into a page."""
import dataclasses
import pathlib


@dataclasses.dataclass
class Plot:
    name: str        # file stem of its PNG, unique in the suite
    figure: object   # matplotlib Figure; its width is that of a page
    caption: str     # what to see in it
    command: str     # how one point of it was measured


@dataclasses.dataclass
class Picture:
    path: pathlib.Path  # PNG
    caption: str


@dataclasses.dataclass
class Table:
    columns: list
    rows: list       # of lists of str or numbers
    caption: str


@dataclasses.dataclass
class Section:
    title: str
    text: str        # paragraphs, parted by empty lines; plain text and `code`, no HTML
    plots: list = dataclasses.field(default_factory=list)
    pictures: list = dataclasses.field(default_factory=list)  # of rows: lists of Picture
    tables: list = dataclasses.field(default_factory=list)
