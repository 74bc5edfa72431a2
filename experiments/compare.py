#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How far is an EXR image from another? The metrics of all our experiments, for any two images.

    experiments/compare.py A.exr B.exr [--layers L,..] [--mask L[>V]] [--variance L|auto] ...

B is the reference. Compares every colour layer that both have, as a whole and per channel, over the
pixels of the mask, and prints a table:

  relRMSE  sqrt(mean((A - B)^2)) / mean(B)
  bias     mean(A - B) / mean(B)
  p99 max  of |A - B| / max(B, 0.01 mean(B)); with --block 2 of 2 x 2 averaged pixels
  noise    sqrt(mean(variance of B)) / mean(B); its square has been taken off relRMSE's, not off
           p99, max or FLIP
  FLIP     mean over the mask of HDR-FLIP, which suits linear radiance as it needs no exposure; with
           --exposure of LDR-FLIP at that exposure, clipped, in sRGB

A layer is named as in the EXR file; RGB is the picture itself. SUM=OTHER compares a layer, or a sum
of layers, of A with one of other name of B: --layers multiple+single=RGB.

Exit codes: 0 ok, 1 a relRMSE is above --fail-above, 2 usage, 3 bad input.
"""
import argparse
import json
import pathlib
import sys

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from harness import metrics, pictures  # noqa: E402
from harness.images import read_image  # noqa: E402
from harness.suite import InputError  # noqa: E402

PICTURE = "RGB"  # how a user writes the layer ""


def layer(image, path, name):
    """A layer, or the sum of several joined by "+", all pixels finite."""
    return sum(one_layer(image, path, one) for one in name.split("+"))


def one_layer(image, path, name):
    key = "" if name == PICTURE else name
    if key not in image:
        raise InputError(f"{path}: no layer {name}, expected one of "
                         + ", ".join(n or PICTURE for n in sorted(image.layers)))
    pixels = image[key]
    if not numpy.isfinite(pixels).all():
        y, x = numpy.argwhere(~numpy.isfinite(pixels))[0][:2]
        raise InputError(f"{path}: layer {name} is not finite at pixel {x},{y}")
    return pixels


def pairs_of_layers(wanted, a, b):
    """What to compare: pairs of a layer of A and one of B; unasked, none that is black in both."""
    if wanted:
        return [tuple((text.split("=", 1) * 2)[:2]) for text in wanted.split(",")]
    common = [name or PICTURE for name in sorted(a.layers)
              if name in b and a[name].ndim == 3 and b[name].ndim == 3
              and not name.endswith("variance") and name not in ("N", "P")
              and (a[name].any() or b[name].any())]
    if not common:
        raise InputError("the images have no colour layer in common, name some with --layers")
    return [(name, name) for name in common]


def mask_of(text, images):
    """LAYER (pixels where it is not 0) or LAYER>VALUE, of B or else of A; without text B's body."""
    if text is None:
        return metrics.body_mask(images["b"][1])
    name, _, value = text.partition(">")
    for path, image in reversed(images.values()):
        if name == "A" or (name if name != PICTURE else "") in image:
            break
    pixels = image.coverage if name == "A" else one_layer(image, path, name)
    pixels = pixels.max(axis=2) if pixels.ndim == 3 else pixels
    try:
        return pixels > float(value) if value else pixels != 0
    except ValueError:
        raise InputError(f"--mask: expected a number after >, got '{value}'") from None


def variance_of(text, path, image, name):
    """Variance of a layer of B: a given layer, or the one that its name leads to."""
    if text is None:
        return None
    if text != "auto":
        return one_layer(image, path, text)
    return image.variance("+".join("" if n == PICTURE else n for n in name.split("+")))


def rows_of(arguments, images, mask):
    """A dict of numbers for each layer and channel."""
    (path_a, a), (path_b, b) = images["a"], images["b"]
    rows = []
    for name_a, name_b in pairs_of_layers(arguments.layers, a, b):
        i, r = layer(a, path_a, name_a), layer(b, path_b, name_b)
        if i.shape != r.shape:
            raise InputError(f"layer {name_a} of {path_a} has another number of channels than "
                             f"{name_b} of {path_b}")
        variance = variance_of(arguments.variance, path_b, b, name_b)
        if variance is not None and variance.shape != r.shape:
            raise InputError(f"{path_b}: the variance of layer {name_b} has another number of "
                             "channels")
        title = name_a if name_a == name_b else f"{name_a}={name_b}"
        for channel, part in channels_of(i):
            v = None if variance is None else variance[part]
            numbers = metrics.compare(i[part], r[part], mask, v, arguments.block)
            if channel == "all" and i.ndim == 3:
                numbers["flip"], _ = metrics.flip(i, r, mask, arguments.exposure)
            rows.append({"layer": title, "channel": channel, **numbers})
    return rows


def channels_of(pixels):
    """Names and index expressions: all channels together, then each."""
    if pixels.ndim == 2:
        return [("all", numpy.s_[:, :])]
    return [("all", numpy.s_[:, :, :])] + [(c, numpy.s_[:, :, k]) for k, c in enumerate("RGB")]


COLUMNS = {"layer": "layer", "channel": "channel", "relRMSE": "relRMSE", "bias": "bias",
           "p99": "p99", "max": "max", "noise": "noise", "flip": "FLIP"}


def table(rows):
    """The rows as aligned text; a number that does not exist is a dash."""
    def text(value):
        return value if isinstance(value, str) else "-" if value is None else f"{value:.4g}"

    cells = [list(COLUMNS.values())] + [[text(row.get(c)) for c in COLUMNS] for row in rows]
    widths = [max(map(len, column)) for column in zip(*cells)]
    return "\n".join("  ".join(cell.ljust(width) for cell, width in zip(line, widths)).rstrip()
                     for line in cells)


def write_pictures(arguments, images, mask):
    """The pictures asked for, of the first pair of layers."""
    (path_a, a), (path_b, b) = images["a"], images["b"]
    name_a, name_b = pairs_of_layers(arguments.layers, a, b)[0]
    i, r = layer(a, path_a, name_a), layer(b, path_b, name_b)
    if arguments.difference:
        difference = pictures.relative_difference(i, r, mask)
        limit = arguments.difference_limit or pictures.common_limit([difference])
        pictures.save_difference(difference, mask, arguments.difference, limit)
    if arguments.flip_map:
        if i.ndim != 3:
            raise InputError(f"FLIP needs three channels, layer {name_a} has one")
        _, errors = metrics.flip(i, r, mask, arguments.exposure)
        pictures.save_flip(errors, mask, arguments.flip_map)


def parse(words):
    parser = argparse.ArgumentParser(description=__doc__, allow_abbrev=False,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("a", metavar="A.exr", type=pathlib.Path)
    parser.add_argument("b", metavar="B.exr", type=pathlib.Path, help="the reference")
    parser.add_argument("--layers", metavar="L,L=M,L+L=M", help="default: all that both have")
    parser.add_argument("--mask", metavar="LAYER[>VALUE]",
                        help="pixels that count; default: B's coverage A is at least 0.5")
    parser.add_argument("--variance", metavar="LAYER|auto",
                        help="variance of B's pixels, to take off relRMSE; auto: variance for RGB, "
                             "LAYER_variance for others, where there")
    parser.add_argument("--block", type=positive_int, default=1, metavar="PIXELS",
                        help="average so many pixels a side before p99 and max; default: 1")
    parser.add_argument("--exposure", type=float, metavar="STOPS", help="for LDR-FLIP")
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")
    parser.add_argument("--difference", type=pathlib.Path, metavar="OUT.png",
                        help="write (A - B) / mean(B) of the first layer, with its scale")
    parser.add_argument("--difference-limit", type=float, metavar="FRACTION",
                        help="end of that scale; default: covers 99 %% of the pixels")
    parser.add_argument("--flip-map", type=pathlib.Path, metavar="OUT.png",
                        help="write the FLIP map of the first layer")
    parser.add_argument("--fail-above", type=float, metavar="RELRMSE",
                        help="exit with 1 if a layer's relRMSE over all channels is above this")
    return parser.parse_args(list(words))


def positive_int(text):
    number = int(text)
    if number < 1:
        raise ValueError(text)
    return number


def run(arguments):
    images = {key: (path, read_image(path))
              for key, path in (("a", arguments.a), ("b", arguments.b))}
    (path_a, a), (path_b, b) = images["a"], images["b"]
    if a.size != b.size:
        raise InputError("the images differ in size: " + ", ".join(
            f"{path} has {image.size[0]} x {image.size[1]}" for path, image in images.values()))
    mask = mask_of(arguments.mask, images)
    rows = rows_of(arguments, images, mask)
    write_pictures(arguments, images, mask)
    print(json.dumps({"a": str(path_a), "b": str(path_b), "pixels": int(mask.sum()),
                      "rows": rows}, indent=1) if arguments.json else table(rows))
    if arguments.fail_above is not None:
        above = [r for r in rows if r["channel"] == "all" and r["relRMSE"] > arguments.fail_above]
        for row in above:
            print(f"compare.py: layer {row['layer']}: relRMSE {row['relRMSE']:.4g} is above "
                  f"{arguments.fail_above:g}", file=sys.stderr)
        return 1 if above else 0
    return 0


def main(words):
    """Exit code for these command-line words."""
    arguments = parse(words)
    try:
        return run(arguments)
    except InputError as error:
        print(f"compare.py: error: {error}", file=sys.stderr)
        return 3
    except OSError as error:
        print(f"compare.py: error: {error.filename}: {error.strerror}", file=sys.stderr)
        return 4


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
