# SPDX-License-Identifier: Apache-2.0
"""Averages reference pictures of one scene that were made with different seeds.

Both are unbiased, so any weights that do not depend on the pictures keep the average so; those of
least variance go with the inverse of the variances:

    m = w_1 m_1 + w_2 m_2,    var m = w_1^2 var m_1 + w_2^2 var m_2,    w_i ~ 1 / median var m_i

One weight serves all pixels and layers. Weights of each pixel would favour what happened to miss the
rare bright walks, and be biased; the median over the pixels hardly knows of them. Numbers of walks
would do as well if all pictures were made by one version of the program, which they are not.
"""
import os
import pathlib

import numpy
import OpenEXR

from .suite import InputError

SAME = ("scene", "set", "camera", "estimator")  # metadata in which both must agree
SUMMED = ("paths", "camera_rays", "batches", "seconds")
MEAN_BITS, VARIANCE_BITS = 11, 5  # of mantissa that are stored, as by tallow-reference


def read_channels(path: pathlib.Path) -> tuple[dict, dict]:
    """Channel name -> pixels in double precision, and the header."""
    try:
        with OpenEXR.File(str(path), separate_channels=True) as file:
            channels = {name: c.pixels.astype(float) for name, c in file.channels().items()}
            return channels, dict(file.header())
    except Exception as error:  # the library raises what it likes
        raise InputError(f"{path}: not a readable EXR file: {error}") from None


def noise(channels: dict) -> float:
    """sqrt(mean variance) / mean over the pixels that the body mostly covers, and R, G and B."""
    body = channels["A"] > 0.5
    mean = numpy.mean([channels[c][body].mean() for c in "RGB"])
    return float(numpy.sqrt(numpy.mean([channels[f"variance.{c}"][body].mean() for c in "RGB"]))
                 / mean)


def typical_variance(channels: dict) -> float:
    """The median over the same pixels and channels."""
    body = channels["A"] > 0.5
    return float(numpy.median([channels[f"variance.{c}"][body] for c in "RGB"]))


def is_variance(name: str) -> bool:
    return name.rpartition(".")[0].endswith("variance")


def round_mantissa(values: numpy.ndarray, bits: int) -> numpy.ndarray:
    """The nearest float32 of `bits` bits of mantissa: noise compresses badly."""
    drop = 23 - bits
    raw = values.astype(numpy.float32).view(numpy.uint32)
    return ((raw + numpy.uint32(1 << (drop - 1))) & ~numpy.uint32((1 << drop) - 1)).view(numpy.float32)


def seeds(header: dict) -> list[str]:
    return header["tallow/seed"].split()


def require_new_seed(path: pathlib.Path, seed: int) -> None:
    if str(seed) in seeds(read_channels(path)[1]):
        raise InputError(f"{path}: seed {seed} is in it already")


def average(a: dict, b: dict, weight: float) -> dict:
    """Channels of the average, `weight` being that of `a`."""
    channels = {}
    for name, pixels in a.items():
        if name == "A":
            channels[name] = pixels.astype(numpy.float32)
        elif is_variance(name):
            variance = weight ** 2 * pixels + (1 - weight) ** 2 * b[name]
            channels[name] = round_mantissa(variance, VARIANCE_BITS)
        else:
            channels[name] = round_mantissa(weight * pixels + (1 - weight) * b[name], MEAN_BITS)
    return channels


def merge(path: pathlib.Path, other: pathlib.Path) -> float:
    """Averages the picture `path` with `other`; its noise then. `path` is replaced whole or not at
    all. Throws InputError for pictures of different things, and for a seed that is in both.
    """
    (a, header), (b, header_b) = read_channels(path), read_channels(other)
    for key in SAME:
        if header[f"tallow/{key}"] != header_b[f"tallow/{key}"]:
            raise InputError(f"{other}: {key} is not that of {path}: "
                             f"{header_b[f'tallow/{key}']!r}, not {header[f'tallow/{key}']!r}")
    if a.keys() != b.keys() or not numpy.array_equal(a["A"], b["A"]):
        raise InputError(f"{other}: not of the same channels and coverage as {path}")
    if common := sorted(set(seeds(header)) & set(seeds(header_b))):
        raise InputError(f"{other}: seed {common[0]} is in {path} already")

    variances = typical_variance(a), typical_variance(b)
    channels = average(a, b, variances[1] / sum(variances))
    for key in SUMMED:
        name = f"tallow/{key}"
        header[name] = str(int(header[name]) + int(header_b[name]))
    header["tallow/seed"] = " ".join(seeds(header) + seeds(header_b))
    merged_noise = noise({name: pixels.astype(float) for name, pixels in channels.items()})
    header["tallow/noise"] = f"{merged_noise:.5f}"
    write(path, header, channels)
    return merged_noise


def write(path: pathlib.Path, header: dict, channels: dict) -> None:
    part = path.with_suffix(".part.exr")
    del header["channels"]  # made anew from the pixels
    OpenEXR.File(header, channels).write(str(part))
    os.replace(part, path)
