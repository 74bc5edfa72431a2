# SPDX-License-Identifier: Apache-2.0
"""What an error is: one image against another, over the pixels that see a translucent body."""
import math

import flip_evaluator
import numpy

from .suite import InputError

SEES_BODY = 0.5  # of a pixel's area
LUMINANCE = numpy.array([0.2126, 0.7152, 0.0722])  # of linear sRGB


def body_mask(image):
    """Pixels that count: at least half of the pixel is body."""
    return image.coverage >= SEES_BODY


def relative_noise(variance, reference, mask):
    """relRMSE that an image of `reference`'s expectation measures against it by noise alone."""
    return float(numpy.sqrt(numpy.mean(variance[mask])) / numpy.mean(reference[mask]))


def compare(image, reference, mask, variance=None, block=1):
    """relRMSE, bias, p99 and max of `image` against `reference`, both (h, w, 3) or (h, w).

    relRMSE = sqrt(mean((I - R)^2)) / mean(R), over the pixels of `mask` and all channels; bias is
    mean(I - R) / mean(R); p99 and max are of |I - R| / max(R, 0.01 mean R), over averages of
    `block` x `block` pixels that lie in the mask as a whole. `variance` is that of the reference's
    pixels: its mean is taken off the mean square (not below zero), and "noise" says how much it
    was. p99 and max keep the noise: no rule takes it off a quantile; blocks make it smaller, and
    "noise_p99" says what p99 would be of that noise alone.
    Throws InputError if the mask is empty or the reference's mean is not positive.
    """
    i, r = image[mask].astype(numpy.float64), reference[mask].astype(numpy.float64)
    if not i.size:
        raise InputError("no pixel lies in the mask")
    mean = numpy.mean(r)
    if not mean > 0:
        raise InputError(f"the reference's mean over the mask is {mean:g}, expected more than 0")
    square = numpy.mean((i - r) ** 2)
    result = {}
    if variance is not None:
        result["noise"] = relative_noise(variance, reference, mask)
        result["noise_p99"] = _noise_percentile(variance, reference, mask, mean, block)
        square = max(0.0, square - numpy.mean(variance[mask], dtype=numpy.float64))
    relative = _relative_errors(image, reference, mask, mean, block)
    return {"relRMSE": float(numpy.sqrt(square) / mean), "bias": float(numpy.mean(i - r) / mean),
            "p99": float(numpy.percentile(relative, 99)), "max": float(relative.max()), **result}


def _whole_blocks(images, mask, block):
    """Averages over the blocks that lie in the mask as a whole, of each image."""
    whole = averaged(mask.astype(numpy.float64), block) == 1
    if not whole.any():
        raise InputError(f"no block of {block} x {block} pixels lies in the mask")
    return (averaged(pixels.astype(numpy.float64), block)[whole] for pixels in images)


def _relative_errors(image, reference, mask, mean, block):
    i, r = _whole_blocks((image, reference), mask, block)
    return numpy.abs(i - r) / numpy.maximum(r, 0.01 * mean)


def _noise_percentile(variance, reference, mask, mean, block):
    """99th percentile of the relative error by normal, independent noise of the pixels alone."""
    v, r = _whole_blocks((variance, reference), mask, block)
    deviations = numpy.sqrt(v) / block / numpy.maximum(r, 0.01 * mean)
    deviations = deviations[deviations > 0]
    erfc = numpy.vectorize(math.erfc, otypes=[float])
    above = 0.01 * r.size
    if deviations.size <= above:
        return 0.0
    low, high = 0.0, 10 * float(deviations.max())
    for _ in range(40):
        middle = (low + high) / 2
        is_more = erfc(middle / deviations / math.sqrt(2)).sum() > above
        low, high = (middle, high) if is_more else (low, middle)
    return high


def averaged(pixels, block):
    """Averages of block x block pixels; rows and columns that do not fill a block are left out."""
    if block == 1:
        return pixels
    h, w = (size // block for size in pixels.shape[:2])
    blocks = pixels[:h * block, :w * block].reshape(h, block, w, block, *pixels.shape[2:])
    return blocks.mean(axis=(1, 3))


def flip(image, reference, mask, exposure=None):
    """Mean of FLIP over the mask, and its map (h, w), 0 outside; both images linear, (h, w, 3).

    Without `exposure` HDR-FLIP [ANSA21], as a linear image has no exposure of its
    own: the largest error over a range of exposures. The range is that paper's, but from the
    reference's luminance inside the mask: a black background would stretch it by 20 stops. With
    `exposure` in stops LDR-FLIP [ANA+20] of the two pictures, clipped, in sRGB.
    Pixels outside the mask are black in both images. 67 pixels a degree of the viewer's eye.
    """
    inside = mask[..., None]
    i, r = (numpy.where(inside, numpy.maximum(pixels, 0), 0).astype(numpy.float32)
            for pixels in (image, reference))
    if exposure is None:
        errors, _, _ = flip_evaluator.evaluate(r, i, "HDR", applyMagma=False,
                                               parameters=_exposures(reference[mask]))
    else:
        errors, _, _ = flip_evaluator.evaluate(srgb(r, exposure), srgb(i, exposure), "LDR",
                                               applyMagma=False)
    errors = numpy.where(mask, errors[..., 0], 0)
    return float(errors[mask].mean(dtype=numpy.float64)), errors


def _exposures(reference):
    """Stops at which the brightest and the median luminance reach 0.85 of the display."""
    luminance = reference.astype(numpy.float64) @ LUMINANCE
    level = _aces_inverse(0.85)
    darkest = 1e-6 * luminance.max()  # a median of 0 has no exposure
    start = math.log2(level / luminance.max())
    stop = math.log2(level / max(numpy.median(luminance), darkest))
    return {"startExposure": start, "stopExposure": stop,
            "numExposures": max(2, math.ceil(stop - start)), "tonemapper": "ACES"}


def _aces_inverse(display):
    """Radiance that the ACES curve, as fitted in [Nark16], input times 0.6, maps to `display`."""
    a = 0.36 * (2.51 - 2.43 * display)
    b = 0.6 * (0.03 - 0.59 * display)
    c = -0.14 * display
    return (-b + math.sqrt(b * b - 4 * a * c)) / (2 * a)


def srgb(linear, exposure=0.0):
    """A picture in [0, 1]: linear radiance times 2^exposure, clipped, sRGB-encoded."""
    x = numpy.clip(linear * 2.0 ** exposure, 0, 1)
    encoded = numpy.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    return encoded.astype(numpy.float32)
