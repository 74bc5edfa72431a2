# SPDX-License-Identifier: Apache-2.0
"""Running tallow's programs and reading what they say of themselves."""
import dataclasses
import json
import os
import pathlib
import shlex
import signal
import subprocess
import sys
import tempfile

from .cases import ROOT

LAUNCH = pathlib.Path(__file__).with_name("launch.py")


class ProgramFailed(Exception):
    """A program ended with another code than 0; the message holds its last words."""


@dataclasses.dataclass
class Run:
    command: str      # as a reader would type it at the repository's top
    seconds: float    # wall time of the process, start to end
    cpu_seconds: float
    peak_mib: float   # largest resident set
    stats: dict       # --stats, empty if the program has none
    stdout: str


def shown(command):
    """The command as documentation prints it: paths relative to the repository."""
    words = [str(word) for word in command]
    return shlex.join(w.removeprefix(str(ROOT) + "/").removeprefix("build/release/bin/")
                      for w in words)


def run(program, *arguments, stats=True, bin=ROOT / "build/release/bin", timeout=None):
    """Runs a program of `bin` to its end. Throws ProgramFailed, also after `timeout` seconds."""
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        plain = [pathlib.Path(bin) / program, *arguments]
        file = folder / "stats.json"
        command = [str(word) for word in plain + (["--quiet", "--stats", file] if stats else [])]
        with open(folder / "out", "w+", encoding="utf-8") as out, \
                open(folder / "err", "w+", encoding="utf-8") as err:
            taken = _launch(command, folder / "taken.json", out, err, timeout)
            out.seek(0), err.seek(0)
            if taken["status"] != 0:
                raise ProgramFailed(f"{shown(plain)}: exit code {taken['status']}: "
                                    f"{err.read()[-500:]}")
            return Run(shown(plain), taken["seconds"], taken["cpu_seconds"], taken["peak_mib"],
                       json.loads(file.read_text()) if stats else {}, out.read())


def _launch(command, result, out, err, timeout):
    """What launch.py says of the command; its exit code alone if it could not be run to its end."""
    process = subprocess.Popen([sys.executable, "-I", "-S", LAUNCH, result, *command], stdout=out,
                               stderr=err, start_new_session=True)
    try:
        process.wait(timeout)
    except BaseException as stopped:  # too slow, or interrupted: the program has to go, too
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        if not isinstance(stopped, subprocess.TimeoutExpired):
            raise
    if not result.exists():
        return {"status": process.returncode}
    return json.loads(result.read_text())
