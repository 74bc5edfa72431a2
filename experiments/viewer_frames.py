# SPDX-License-Identifier: Apache-2.0
"""How long frames of tallow-view take while the camera moves, by its own frame log.

    python3 experiments/viewer_frames.py [--write]

The marble armadillo, 200k samples, an orbit around it: first drafts of fixed resolutions, without a
window; then the window of 512 x 512 on a virtual display (Xvfb, xdotool), which chooses the
resolution itself. Prints tables in Markdown; --write puts them into docs/VIEWER.md. Wants a quiet
machine and ./run fetch.
"""

import argparse
import csv
import os
import pathlib
import re
import statistics
import subprocess
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROGRAMS = ROOT / "build/release/bin"
SCENE = ROOT / "scenes/armadillo.yaml"
DOCUMENT = ROOT / "docs/VIEWER.md"
MODELS = ("transport", "body-aware")
RESOLUTIONS = (512, 384, 256)
FRAMES = 60  # of an orbit
SKIPPED = 5  # while memory is still being touched for the first time
PHASES = ("primary_ms", "exitance_ms", "surface_ms")


def orbit_script(resolution):
    middle = resolution // 2
    lines = [f"- {{frame: 0, button: left, down: true, at: [{middle}, {middle}]}}"]
    lines += [f"- {{frame: {k}, move: [{middle + 3 * k}, {middle}]}}" for k in range(1, FRAMES)]
    return "\n".join(lines)


def read_drafts(log):
    with open(log, newline="") as stream:
        return [row for row in csv.DictReader(stream) if row["kind"] == "draft"]


def median(rows, column):
    return statistics.median(float(row[column]) for row in rows)


def measure_drafts(folder, cache, model, resolution):
    log, script = folder / "log.csv", folder / "orbit.yaml"
    script.write_text(orbit_script(resolution))
    subprocess.run([PROGRAMS / "tallow-view", SCENE, "--cache", cache, "--quiet", "--log", log,
                    "--frames", str(FRAMES), "--script", script,
                    "--set", f"cameras.main.resolution=[{resolution},{resolution}]",
                    "--set", f"materials.marble.model={model}", "--set", "settings.bounces=0"],
                   check=True)
    rows = read_drafts(log)[SKIPPED:]
    return [median(rows, column) for column in ("milliseconds", *PHASES, "shading_points")]


def draft_table(folder, cache):
    lines = ["| model | pixels | median, ms | camera rays | sums | surfaces | shading points |",
             "|---|---|---|---|---|---|---|"]
    for model in MODELS:
        for resolution in RESOLUTIONS:
            total, primary, exitance, surface, points = measure_drafts(folder, cache, model,
                                                                       resolution)
            lines.append(f"| {model} | {resolution} x {resolution} | {total:.0f} | {primary:.0f} | "
                         f"{exitance:.0f} | {surface:.0f} | {points:.0f} |")
    return lines


def start_display():
    read, write = os.pipe()
    server = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "800x600x24"],
                              pass_fds=[write], stderr=subprocess.DEVNULL)
    os.close(write)
    with os.fdopen(read) as pipe:
        return server, ":" + pipe.readline().strip()


def wait_for(condition):
    while not condition():
        time.sleep(0.05)


def drag(do, log):
    """Waits for the first frames, then drags around the figure for some seconds."""
    wait_for(lambda: log.exists() and "pass" in log.read_text())
    window = do("search", "--name", "^tallow").split()[0]
    do("mousemove", "--window", window, "256", "256")
    do("mousedown", "1")
    end = time.monotonic() + 6
    while time.monotonic() < end:
        do("mousemove_relative", "--", "1", "0")
        time.sleep(0.005)
    do("mouseup", "1")
    do("key", "Escape")


def window_line(folder, cache, model):
    server, display = start_display()
    environment = dict(os.environ, DISPLAY=display, SDL_VIDEODRIVER="x11",
                       SDL_RENDER_DRIVER="software")

    def do(*words):
        return subprocess.run(["xdotool", *words], env=environment, capture_output=True,
                              text=True).stdout

    log = folder / f"window-{model}.csv"
    try:
        viewer = subprocess.Popen(
            [PROGRAMS / "tallow-view", SCENE, "--cache", cache, "--quiet", "--log", log, "--set",
             f"materials.marble.model={model}", "--set", "settings.bounces=0"], env=environment)
        drag(do, log)
        viewer.wait()
    finally:
        server.terminate()
        server.wait()
    rows = read_drafts(log)
    start = next(i for i, row in enumerate(rows) if float(row["x_mm"]) != float(rows[0]["x_mm"]))
    rows = rows[start + SKIPPED:]
    rows = [row for row in rows if float(row["time_s"]) < float(rows[0]["time_s"]) + 5]
    seconds = float(rows[-1]["time_s"]) - float(rows[0]["time_s"])
    return (f"| {model} | {(len(rows) - 1) / seconds:.1f} | {median(rows, 'width'):.0f} x "
            f"{median(rows, 'height'):.0f} | {median(rows, 'milliseconds'):.0f} | "
            f"{median(rows, 'latency_ms'):.0f} |")


def window_table(folder, cache):
    return ["| model | frames a second | median size | median, ms | event to screen, ms |",
            "|---|---|---|---|---|", *(window_line(folder, cache, model) for model in MODELS)]


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="put the tables into docs/VIEWER.md")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        cache = folder / "armadillo.tallow"
        subprocess.run([PROGRAMS / "tallow-precompute", SCENE, "--points", "200000", "-o", cache,
                        "--quiet"], check=True)
        text = "\n".join([*draft_table(folder, cache), "", *window_table(folder, cache)])
    print(text)
    if arguments.write:
        old = DOCUMENT.read_text()
        new = re.sub(r"(<!-- frames -->\n).*?(<!-- /frames -->)",
                     lambda match: match[1] + text + "\n" + match[2], old, flags=re.DOTALL)
        DOCUMENT.write_text(new)


if __name__ == "__main__":
    main()
