# SPDX-License-Identifier: Apache-2.0
"""What an error is: one image against another, over the pixels that see a translucent body."""
import numpy

SEES_BODY = 0.5  # of a pixel's area


def body_mask(image):
    """Pixels that count: at least half of the pixel is body."""
    return image.coverage >= SEES_BODY


def relative_noise(variance, reference, mask):
    """relRMSE that an image of `reference`'s expectation would measure against it by noise alone."""
    return float(numpy.sqrt(numpy.mean(variance[mask])) / numpy.mean(reference[mask]))


def compare(image, reference, mask, variance=None):
    """relRMSE, bias, p99 and max of `image` against `reference`, both (h, w, 3) or (h, w).

    relRMSE = sqrt(mean((I - R)^2)) / mean(R), over the pixels of `mask` and all channels; bias is
    mean(I - R) / mean(R); p99 and max are of |I - R| / max(R, 0.01 mean R). `variance` is that of
    the reference's pixels: its mean is taken off the mean square (not below zero), and "noise" says
    how much it was. p99 and max keep the noise: no rule takes it off a quantile.
    """
    i, r = image[mask].astype(numpy.float64), reference[mask].astype(numpy.float64)
    mean = numpy.mean(r)
    square = numpy.mean((i - r) ** 2)
    result = {}
    if variance is not None:
        result["noise"] = relative_noise(variance, reference, mask)
        square = max(0.0, square - numpy.mean(variance[mask]))
    relative = numpy.abs(i - r) / numpy.maximum(r, 0.01 * mean)
    return {"relRMSE": float(numpy.sqrt(square) / mean), "bias": float(numpy.mean(i - r) / mean),
            "p99": float(numpy.percentile(relative, 99)), "max": float(relative.max()), **result}
