# SPDX-License-Identifier: Apache-2.0
"""Made-up EXR images, and where experiments/ is."""
import contextlib
import importlib
import io
import pathlib
import subprocess
import sys

import numpy
import OpenEXR

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "experiments"))


def flat(value, height=16, width=20):
    """(h, w, 3) of one colour."""
    return numpy.broadcast_to(numpy.float32(value), (height, width, 3)).copy()


def write_exr(path, layers, coverage=None):
    """Layers by name: (h, w, 3) become name.R, .G, .B, (h, w) the channel of that name."""
    channels = {}
    for name, pixels in layers.items():
        if pixels.ndim == 2:
            channels[name] = numpy.ascontiguousarray(pixels, dtype=numpy.float32)
            continue
        for k, component in enumerate("RGB"):
            full = f"{name}.{component}" if name else component
            channels[full] = numpy.ascontiguousarray(pixels[..., k], dtype=numpy.float32)
    if coverage is not None:
        channels["A"] = numpy.ascontiguousarray(coverage, dtype=numpy.float32)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, channels).write(str(path))
    return path


def run(program, *arguments):
    """A program of experiments/ as a user runs it, in this process: exit code, stdout, stderr."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = importlib.import_module(program.removesuffix(".py")).main(map(str, arguments))
        except SystemExit as end:  # argparse's
            code = end.code
    return code, out.getvalue(), err.getvalue()


def run_process(program, *arguments):
    """The same as a process of its own."""
    done = subprocess.run([sys.executable, ROOT / "experiments" / program, *map(str, arguments)],
                          capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr
