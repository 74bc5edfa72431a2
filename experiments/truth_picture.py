#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""docs/gallery/body_aware.png: the bunny in marble by two models and the truth, and what differs.

    experiments/python experiments/truth_picture.py     # after ./run experiment model-error

Columns: the method as published, the body-aware model, volumetric truth; below the first two, their
signed differences from the truth on one scale.
"""
import pathlib

from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parent.parent
PICTURES = ROOT / "experiments/out/model-error/pictures"
BACKGROUND = (200, 200, 200)


def part(model, name):
    return Image.open(PICTURES / f"bunny-marble-{model}-indirect-on-{name}.png").convert("RGB")


def main():
    above = [part("classic", "ours"), part("body-aware", "ours"), part("body-aware", "reference")]
    below = [part("classic", "difference"), part("body-aware", "difference")]
    width, height = above[0].size
    picture = Image.new("RGB", (3 * width, height + below[0].size[1]), BACKGROUND)
    for column, image in enumerate(above):
        picture.paste(image, (column * width, 0))
    for column, image in enumerate(below):
        picture.paste(image, (column * width, height))
    picture.save(ROOT / "docs/gallery/body_aware.png")


if __name__ == "__main__":
    main()
