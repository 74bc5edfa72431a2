# SPDX-License-Identifier: Apache-2.0
"""launch.py RESULT COMMAND...: runs a command and writes what it took to the file RESULT, as JSON.

A process of its own, and a small one: Linux counts the memory of the process that forked as the
child's peak (ru_maxrss), and one that has loaded numpy is larger than many a run of a program.
"""
import json
import os
import sys
import time


def main():
    result, command = sys.argv[1], sys.argv[2:]
    start = time.monotonic()
    try:
        pid = os.posix_spawn(command[0], command, os.environ)
    except OSError as error:
        sys.stderr.write(f"{command[0]}: {error.strerror}\n")
        return 127
    _, status, usage = os.wait4(pid, 0)
    seconds = time.monotonic() - start
    with open(result, "w", encoding="utf-8") as file:
        json.dump({"status": os.waitstatus_to_exitcode(status), "seconds": seconds,
                   "cpu_seconds": usage.ru_utime + usage.ru_stime,
                   "peak_mib": usage.ru_maxrss / 1024}, file)
    return 0


if __name__ == "__main__":
    sys.exit(main())
