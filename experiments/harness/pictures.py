# SPDX-License-Identifier: Apache-2.0
"""Pictures of two images beside one another: ours, reference, signed difference, FLIP; as PNG."""
import math

import matplotlib
import numpy
from PIL import Image, ImageDraw, ImageFont

from . import metrics
from .section import Picture

ENLARGED = 2  # a pixel of the image is so many of the PNG: 128 x 128 is small on a screen
OUTSIDE = (200, 200, 200)
DIVERGING = matplotlib.colormaps["RdBu_r"]  # blue: darker than the reference; red: brighter
FLIP_COLOURS = matplotlib.colormaps["magma"]


def exposure_for(reference, mask):
    """Stops that show the reference well: its 98th percentile inside the mask becomes white."""
    level = numpy.percentile(reference[mask], 98)
    return -math.log2(level) if level > 0 else 0.0


def save(pixels, path, bar=None):
    """Writes colours (h, w, 3) in [0, 255] as PNG, enlarged, a scale bar under them."""
    picture = Image.fromarray(numpy.asarray(pixels, dtype=numpy.uint8))
    picture = picture.resize((picture.width * ENLARGED, picture.height * ENLARGED), Image.NEAREST)
    if bar is not None:
        scale = _scale_bar(picture.width, *bar)
        both = Image.new("RGB", (picture.width, picture.height + scale.height), "white")
        both.paste(picture, (0, 0))
        both.paste(scale, (0, picture.height))
        picture = both
    path.parent.mkdir(parents=True, exist_ok=True)
    if bar is not None:  # few colours: a palette makes a third of the bytes, and hides nothing
        picture = picture.quantize(256, dither=Image.Dither.NONE)
    picture.save(path, optimize=True)


def _scale_bar(width, colours, numbers):
    """Colours from left to right and the numbers beneath them."""
    bar, text = 8, 16
    picture = Image.new("RGB", (width, bar + text), "white")
    ramp = (255 * colours(numpy.linspace(0, 1, width))[:, :3]).round().astype(numpy.uint8)
    picture.paste(Image.fromarray(numpy.repeat(ramp[None], bar, axis=0)), (0, 0))
    draw, font = ImageDraw.Draw(picture), ImageFont.load_default(size=12)
    for place, (number, anchor) in enumerate(zip(numbers, ("la", "ma", "ra"))):
        draw.text((place * (width - 1) / 2, bar + 1), number, fill="black", font=font,
                  anchor=anchor)
    return picture


def save_linear(pixels, path, exposure):
    """Writes linear radiance as PNG: times 2^exposure, clipped, sRGB."""
    save(255 * metrics.srgb(pixels, exposure), path)


def relative_difference(image, reference, mask):
    """(I - R) / mean R, averaged over channels; (h, w), 0 outside the mask."""
    difference = (image.astype(numpy.float64) - reference) / numpy.mean(reference[mask])
    if difference.ndim == 3:
        difference = difference.mean(axis=2)
    return numpy.where(mask, difference, 0)


def common_limit(differences):
    """A round number that 99 % of all these differences' pixels stay within, for a common scale."""
    sizes = numpy.abs(numpy.concatenate([d[d != 0] for d in differences] or [[0.0]]))
    level = numpy.percentile(sizes, 99) if sizes.size else 0.0
    steps = [s * 10.0 ** e for e in range(-6, 4) for s in (1, 2, 5)]
    return next((step for step in steps if step >= level), steps[-1])


def save_difference(difference, mask, path, limit):
    """Writes a signed difference in -limit .. limit (of the reference's mean), its scale below."""
    colours = 255 * DIVERGING(numpy.clip(difference / limit, -1, 1) / 2 + 0.5)[..., :3]
    colours[~mask] = OUTSIDE
    percent = f"{100 * limit:g} %"
    save(colours.round(), path, (DIVERGING, (f"-{percent}", "0", f"+{percent}")))


def save_flip(errors, mask, path):
    """Writes a FLIP map, 0 .. 1, its scale below."""
    colours = 255 * FLIP_COLOURS(numpy.clip(errors, 0, 1))[..., :3]
    colours[~mask] = OUTSIDE
    save(colours.round(), path, (FLIP_COLOURS, ("FLIP 0", "0.5", "1")))


PARTS = {"ours": "ours", "reference": "reference", "difference": "(ours - reference) / mean",
         "flip": "FLIP"}


def strip(folder, name, image, reference, mask, flip, limit):
    """Writes four pictures of (h, w, 3) as FOLDER/NAME-PART.png, a PART of PARTS each.

    Ours and the reference at the exposure that suits the reference; the signed difference in
    +-limit times the reference's mean, so that strips with one limit share a scale; the map `flip`
    of metrics.flip().
    """
    paths = {part: folder / f"{name}-{part}.png" for part in PARTS}
    exposure = exposure_for(reference, mask)
    save_linear(image, paths["ours"], exposure)
    save_linear(reference, paths["reference"], exposure)
    save_difference(relative_difference(image, reference, mask), mask, paths["difference"], limit)
    save_flip(flip, mask, paths["flip"])


def row(folder, name, title):
    """The Pictures that strip() wrote, for a report; `title` says what "ours" is."""
    return [Picture(folder / f"{name}-{part}.png", title if part == "ours" else words)
            for part, words in PARTS.items()]
