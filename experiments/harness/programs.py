# SPDX-License-Identifier: Apache-2.0
"""Running tallow's programs and reading what they say of themselves."""
import dataclasses
import json
import os
import pathlib
import shlex
import subprocess
import tempfile
import time

from .cases import ROOT


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
    """Runs a program of `bin` to its end. Throws ProgramFailed."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "stats.json"
        plain = [pathlib.Path(bin) / program, *arguments]
        command = [str(word) for word in plain + (["--quiet", "--stats", file] if stats else [])]
        with open(pathlib.Path(folder) / "out", "w+", encoding="utf-8") as out, \
                open(pathlib.Path(folder) / "err", "w+", encoding="utf-8") as err:
            start = time.monotonic()
            process = subprocess.Popen(command, stdout=out, stderr=err)
            status, usage = _wait(process, timeout)
            seconds = time.monotonic() - start
            out.seek(0), err.seek(0)
            if status != 0:
                raise ProgramFailed(f"{shown(plain)}: exit code {status}: {err.read()[-500:]}")
            return Run(shown(plain), seconds, usage.ru_utime + usage.ru_stime,
                       usage.ru_maxrss / 1024, json.loads(file.read_text()) if stats else {},
                       out.read())


def _wait(process, timeout):
    """Exit code and resource usage of this one process."""
    end = None if timeout is None else time.monotonic() + timeout
    while True:
        pid, status, usage = os.wait4(process.pid, 0 if end is None else os.WNOHANG)
        if pid:
            process.returncode = os.waitstatus_to_exitcode(status)
            return process.returncode, usage
        if time.monotonic() > end:
            process.kill()
            end = None
        time.sleep(0.002)
