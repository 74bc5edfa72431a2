#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes the reference pictures of the standard and of the unseen cases with tallow-reference.

experiments/references.py BIN --noise 0.04         adds to experiments/references/FIGURE-MEDIUM.exr
experiments/references.py BIN --add 2 --seconds 150
                                                   makes pictures of another seed in build/references
                                                   and averages the references with them
experiments/references.py --table                  writes the table of experiments/references/README.md
"""
import argparse
import pathlib
import subprocess
import sys

import numpy as np

from harness import merging
from harness.suite import InputError

HERE = pathlib.Path(__file__).resolve().parent
FOLDER = HERE / "references"
OTHERS = HERE.parent / "build" / "references"  # pictures of other seeds
# In the order in which they are wanted.
CASES = [
    "sphere-marble", "bunny-marble", "armadillo-marble", "bunny-skimmilk", "sphere-skimmilk",
    "leaf-marble", "armadillo-skimmilk", "leaf-skimmilk", "bunny-skin1", "sphere-skin1",
    "armadillo-skin1", "leaf-skin1", "sphere-dim", "bunny-dim", "armadillo-dim", "leaf-dim",
    "elephant-wholemilk", "elephant-skin2", "elephant-chicken1", "bunny_lamp-potato", "cup_sky-apple",
    "cup_lamp-cream", "armadillo_sky-potato", "leaf_front-chicken2",
]


def folder_of(figure: str) -> pathlib.Path:
    """Where the figure's scene and its media are."""
    standard = HERE / "cases"
    return standard if (standard / f"{figure}.yaml").exists() else standard / "unseen"


def read_media(folder: pathlib.Path) -> dict[str, str]:
    """Name -> what stands behind it in the folder's media.yaml, without its comment."""
    media = {}
    for line in (folder / "media.yaml").read_text().splitlines():
        if line and not line.startswith("#"):
            name, value = line.split(": ", 1)
            media[name] = value.split("  #")[0]
    return media


def command(program: pathlib.Path, case: str, picture: pathlib.Path, stop: list[str]) -> list[str]:
    figure, medium = case.split("-")
    folder = folder_of(figure)
    return [str(program), str((folder / f"{figure}.yaml").relative_to(HERE.parent)),
            "-o", str(picture.relative_to(HERE.parent)),
            "--set", f"materials.body={read_media(folder)[medium]}", *stop, "--resume"]


def make(program: pathlib.Path, case: str, picture: pathlib.Path, stop: list[str]) -> None:
    line = command(program, case, picture, stop)
    print(" ".join(line), flush=True)
    subprocess.run(line, check=True, cwd=HERE.parent)


def add(program: pathlib.Path, case: str, seed: int, stop: list[str]) -> None:
    """Averages the case's reference with a picture of another seed."""
    OTHERS.mkdir(parents=True, exist_ok=True)
    picture = OTHERS / f"{case}.{seed}.exr"
    merging.require_new_seed(FOLDER / f"{case}.exr", seed)
    make(program, case, picture, ["--seed", str(seed), *stop])
    noise = merging.merge(FOLDER / f"{case}.exr", picture)
    print(f"{case}: noise {100 * noise:.2f} %", flush=True)


def mean_colour(channels: dict, layer: str, body: np.ndarray) -> np.ndarray:
    prefix = layer + "." if layer else ""
    return np.array([channels[prefix + c][body].mean() for c in "RGB"])


def table_row(path: pathlib.Path) -> str:
    channels, header = merging.read_channels(path)
    body = channels["A"] > 0.5
    mean = mean_colour(channels, "", body)
    parts = [mean_colour(channels, layer, body).mean() / mean.mean() for layer in
             ("single", "multi", "ext")]
    noise = merging.noise(channels)
    shares = " | ".join(f"{100 * part:.1f}" for part in parts)
    return (f"| `{path.name}` | {100 * noise:.1f} | {' '.join(f'{m:.4f}' for m in mean)} | {shares} "
            f"| {float(header['tallow/paths']) / 1e6:.0f} | {path.stat().st_size // 1000} |")


def table() -> str:
    rows = ["| file | noise, % | mean R G B | single, % | multi, % | ext, % | walks, M | kB |",
            "|---|---|---|---|---|---|---|---|"]
    rows += [table_row(FOLDER / f"{case}.exr") for case in CASES
             if (FOLDER / f"{case}.exr").exists()]
    return "\n".join(rows) + "\n"


def write_table() -> None:
    """Puts the table between the two marks of references/README.md."""
    readme = FOLDER / "README.md"
    before, rest = readme.read_text().split("--table -->\n", 1)
    _, after = rest.split("<!-- end -->", 1)
    readme.write_text(before + "--table -->\n" + table() + "<!-- end -->" + after)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", nargs="?", type=pathlib.Path, help="folder of tallow-reference")
    parser.add_argument("--noise", type=float, default=0.04,
                        help="of the pixels; with --add, of those of the new picture [default: 0.04]")
    parser.add_argument("--seconds", type=float,
                        help="stop each picture after so long, noisy or not")
    parser.add_argument("--cases", nargs="+", choices=CASES, default=CASES, metavar="CASE")
    parser.add_argument("--add", type=int, metavar="SEED",
                        help="make pictures of this seed and average the references with them")
    parser.add_argument("--threads", type=int, help="threads of tallow-reference [default: all]")
    parser.add_argument("--table", action="store_true",
                        help="write the table of references/README.md and stop")
    arguments = parser.parse_args()
    if arguments.table:
        write_table()
    elif arguments.bin is None:
        parser.error("expected the folder of tallow-reference")
    else:
        stop = ["--noise", str(arguments.noise)]
        stop += ["--seconds", str(arguments.seconds)] if arguments.seconds else []
        stop += ["--threads", str(arguments.threads)] if arguments.threads else []
        program = arguments.bin.resolve() / "tallow-reference"
        for case in arguments.cases:
            if arguments.add is None:
                make(program, case, FOLDER / f"{case}.exr", stop)
            else:
                add(program, case, arguments.add, stop)
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(130)
    except InputError as error:
        sys.exit(f"references.py: error: {error}")
    except subprocess.CalledProcessError as error:  # the program has said why
        sys.exit(error.returncode)
