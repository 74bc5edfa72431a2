# SPDX-License-Identifier: Apache-2.0
"""Means, variances and times of repeated renders, and EXR files.

A renderer is an object with

    render(seed, spp) -> (height, width, 3) array of radiance, independent for different seeds
    startup_seconds   -> seconds that it took to be ready: imports, scene, compiled kernels

Pictures are averaged over passes of equal samples a pixel, so that the spread of the passes tells
the variance of their mean without any knowledge of the renderer.
"""
import argparse
import dataclasses
import os
import pathlib
import sys
import time

import numpy as np

from .scene import InputError

PASSES = 32  # chosen: their variance is known to 25 % a pixel, and far better over a picture


@dataclasses.dataclass
class Estimate:
    """A mean of passes. `spread` sums the squared differences from the mean (Welford)."""
    mean: np.ndarray
    spread: np.ndarray
    passes: int = 0
    spp: int = 0           # a pixel, all passes together
    seconds: float = 0.0   # rendering
    startup_seconds: float = 0.0

    def add(self, image, spp, seconds):
        self.passes += 1
        self.spp += spp
        self.seconds += seconds
        difference = image - self.mean
        self.mean = self.mean + difference / self.passes
        self.spread = self.spread + difference * (image - self.mean)

    @property
    def variance(self):
        """Of the mean, in each pixel and channel. Needs two passes."""
        return self.spread / (self.passes * (self.passes - 1))


def pass_size(renderer, seconds, shape):
    """Samples a pixel of a pass such that about PASSES of them take `seconds`, measured."""
    spp = 1
    while True:
        start = time.perf_counter()
        image = renderer.render(0, spp)
        elapsed = time.perf_counter() - start
        assert image.shape == shape, (image.shape, shape)
        if elapsed > seconds / (2 * PASSES) or spp >= 1 << 14:
            return max(1, round(spp * seconds / PASSES / elapsed))
        spp *= 4


def accumulate(renderer, camera, spp=None, seconds=None, on_pass=None):
    """Renders `spp` samples a pixel, or for `seconds`; after each pass calls on_pass(estimate).

    Trial renders that find the size of a pass count as start-up: a user would set it by hand.
    """
    shape = (camera.height, camera.width, 3)
    estimate = Estimate(np.zeros(shape), np.zeros(shape))
    start = time.perf_counter()
    each = max(1, spp // PASSES) if spp else pass_size(renderer, seconds, shape)
    estimate.startup_seconds = renderer.startup_seconds + time.perf_counter() - start
    seed = 0
    while estimate.passes < 2 or (estimate.spp < spp if spp else estimate.seconds < seconds):
        seed += 1  # trials use 0
        start = time.perf_counter()
        image = renderer.render(seed, each)
        estimate.add(image, each, time.perf_counter() - start)
        if on_pass:
            on_pass(estimate)
    return estimate


# ---- files ---------------------------------------------------------------------------------------

def write_exr(path, layers, header=None):
    """Writes {"": (h, w, 3) array, "variance": ...} as channels R, G, B, variance.R, ..."""
    import OpenEXR
    channels = {}
    for layer, image in layers.items():
        for i, name in enumerate("RGB"):
            full = f"{layer}.{name}" if layer else name
            channels[full] = np.ascontiguousarray(image[..., i], np.float32)
    partial = pathlib.Path(f"{path}.tmp.exr")
    attributes = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage,
                  **{key: str(value) for key, value in (header or {}).items()}}
    OpenEXR.File(attributes, channels).write(str(partial))
    os.replace(partial, path)


def read_exr(path):
    """All channels of a file by name, as (height, width) arrays of double."""
    import OpenEXR
    try:
        with OpenEXR.File(str(path), separate_channels=True) as file:
            return {name: channel.pixels.astype(np.float64)
                    for name, channel in file.channels().items()}
    except Exception as error:  # OpenEXR raises bare RuntimeErrors
        raise InputError(f"{path}: expected an OpenEXR file: {error}") from None


def layer(channels, name="", path="image"):
    """The R, G and B of a layer as (height, width, 3). Raises InputError if one is missing."""
    names = [f"{name}.{c}" if name else c for c in "RGB"]
    missing = [n for n in names if n not in channels]
    if missing:
        raise InputError(f"{path}: expected channel '{missing[0]}', got {', '.join(channels)}")
    return np.stack([channels[n] for n in names], axis=-1)


# ---- programs ------------------------------------------------------------------------------------

def positive(kind):
    """An argparse type: a number > 0."""
    def read(text):
        value = kind(text)
        if not value > 0 or value == float("inf"):
            raise ValueError
        return value
    read.__name__ = f"{kind.__name__} > 0"
    return read


def render_parser(description, epilog=None):
    """Arguments that all renderers here share."""
    parser = argparse.ArgumentParser(description=description, epilog=epilog)
    parser.add_argument("case", metavar="CASE", help="a standard case by name, or its file")
    parser.add_argument("medium", metavar="MEDIUM",
                        help="a medium of experiments/cases/media.yaml, or {type: ..}")
    parser.add_argument("-o", "--output", required=True, metavar="OUT.exr",
                        help="R, G, B: mean radiance; variance.R ..: variance of that mean")
    amount = parser.add_mutually_exclusive_group(required=True)
    amount.add_argument("--spp", type=positive(int), help="samples a pixel")
    amount.add_argument("--seconds", type=positive(float), help="rendering time without start-up")
    return parser


def write_estimate(path, estimate, **header):
    """Writes mean and variance, and prints the times."""
    header |= {"spp": estimate.spp, "passes": estimate.passes,
               "seconds": f"{estimate.seconds:.3f}",
               "startup_seconds": f"{estimate.startup_seconds:.3f}"}
    write_exr(path, {"": estimate.mean, "variance": estimate.variance}, header)
    print(f"spp {estimate.spp} in {estimate.passes} passes, {estimate.seconds:.2f} s rendering, "
          f"{estimate.startup_seconds:.2f} s start-up")


def run(main):
    """Calls main() and turns what it refuses into a message and an exit code."""
    try:
        return main() or 0
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 3
    except OSError as error:
        print(f"error: {error}", file=sys.stderr)
        return 4
    except KeyboardInterrupt:
        return 130
