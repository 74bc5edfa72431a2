# SPDX-License-Identifier: Apache-2.0
"""Images in linear radiance, read from EXR: an array a layer."""
import numpy
import OpenEXR

from .suite import InputError


class LayeredImage:
    """Layers by name ("" is the picture itself, "multiple", "single" ...): float32, (h, w, 3).

    One-channel layers are (h, w); `coverage` is the channel A, or ones.
    """

    def __init__(self, layers, coverage, header):
        self.layers, self.coverage, self.header = layers, coverage, header

    def __getitem__(self, name):
        return self.layers[name]

    def __contains__(self, name):
        return name in self.layers

    def sum(self, names):
        """The sum of layers whose names are joined by "+"."""
        return sum(self.layers[name] for name in names.split("+"))

    def variance(self, names):
        """Variance of sum(names), or None if the file does not have it for each layer.

        It stands in "variance" for "" and in "NAME_variance" for others. A sum's is the sum of
        variances: the covariance of two layers, whose paths may share a walk, is not in the file.
        """
        keys = [f"{name}_variance" if name else "variance" for name in names.split("+")]
        return sum(self.layers[k] for k in keys) if all(k in self.layers for k in keys) else None

    @property
    def size(self):
        """Width and height."""
        return self.coverage.shape[::-1]


def read_image(path):
    """All layers of an EXR file. Throws InputError for a file that is none."""
    _require_exr(path)
    try:
        with OpenEXR.File(str(path), separate_channels=True) as file:
            channels = {name: numpy.array(channel.pixels, dtype=numpy.float32)
                        for name, channel in file.channels().items()}
            header = dict(file.header())
    except Exception as error:  # the library raises what it likes
        raise InputError(f"{path}: not a readable EXR file: {error}") from None
    if not channels:
        raise InputError(f"{path}: no channels")
    coverage = channels.get("A", numpy.ones(next(iter(channels.values())).shape, numpy.float32))
    return LayeredImage(_layers(channels), coverage, header)


def _require_exr(path):
    """Throws before the library does, which would print words of its own."""
    try:
        with open(path, "rb") as file:
            magic = file.read(4)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    if magic != b"\x76\x2f\x31\x01":
        raise InputError(f"{path}: not an EXR file")


def _layers(channels):
    """Channels grouped by layer: R, G, B or X, Y, Z to one array, single ones alone."""
    layers = {}
    for name, pixels in channels.items():
        layer, _, component = name.rpartition(".")
        if component in ("R", "X"):
            rest = {"R": "GB", "X": "YZ"}[component]
            wanted = [f"{layer}.{c}" if layer else c for c in component + rest]
            if all(w in channels for w in wanted):
                layers[layer] = numpy.stack([channels[w] for w in wanted], axis=-1)
        elif component not in ("G", "B", "Y", "Z", "A"):
            layers[name] = pixels
    return layers
