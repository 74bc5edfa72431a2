# SPDX-License-Identifier: Apache-2.0
"""The cases: a figure of experiments/cases in a medium of media.yaml beside it."""
import dataclasses
import hashlib
import json
import pathlib

from .suite import InputError, read_yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
CASES = ROOT / "experiments" / "cases"
REFERENCES = ROOT / "experiments" / "references"
FOLDERS = [CASES, CASES / "unseen"]  # the standard cases, and those that no model was made with


@dataclasses.dataclass(frozen=True)
class Case:
    """A scene file and what makes its body of the medium."""
    figure: str
    medium: str
    folder: pathlib.Path = CASES

    @property
    def name(self):
        return f"{self.figure}-{self.medium}"

    @property
    def scene(self):
        return self.folder / f"{self.figure}.yaml"

    @property
    def reference(self):
        """Volumetric truth; it may not exist."""
        return REFERENCES / f"{self.name}.exr"

    def material(self, **changes):
        """The body's material as a flow mapping, some keys replaced: model="dipole"."""
        return json.dumps({**read_yaml(self.folder / "media.yaml")[self.medium], **changes})

    def flags(self, **changes):
        """What turns the figure's scene into this case."""
        return ["--set", f"materials.body={self.material(**changes)}"]

    def needs_fetched_mesh(self):
        return "data/fetched/" in self.scene.read_text(encoding="utf-8")

    def fingerprint(self):
        """Changes with the scene file, the medium, or the reference."""
        digest = hashlib.sha256(self.scene.read_bytes() + self.material().encode())
        if self.reference.exists():
            digest.update(self.reference.read_bytes())
        return digest.hexdigest()[:16]


def all_cases():
    """Every standard figure in every standard medium, figures one after another."""
    figures = sorted(file.stem for file in CASES.glob("*.yaml") if file.stem != "media")
    media = read_yaml(CASES / "media.yaml")
    return [Case(figure, medium) for figure in figures for medium in media]


def cases_named(names):
    """The cases of a setting: "all", or a list of names. Throws InputError."""
    return all_cases() if names == "all" else [case_named(name) for name in names]


def case_named(name):
    """FIGURE-MEDIUM of one of FOLDERS. Throws InputError for one that is not there."""
    figure, _, medium = name.partition("-")
    for folder in FOLDERS:
        case = Case(figure, medium, folder)
        if case.scene.exists():
            break
    else:
        raise InputError(f"{name}: no figure {Case(figure, medium).scene}")
    media = read_yaml(case.folder / "media.yaml")
    if medium not in media:
        raise InputError(f"{name}: expected a medium of {', '.join(media)}, got '{medium}'")
    return case
