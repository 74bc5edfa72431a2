#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs a suite of experiments and writes its report.

    experiments/run.py SUITE [--output DIR] [--only KIND ...] [--fresh]
    experiments/run.py SUITE --needs       what must be there first: fetch, mitsuba
    experiments/run.py --check-published   whether generated numbers in README.md and docs are fresh

SUITE is a name in experiments/suites or a YAML file. Writes into experiments/out/SUITE:
report.html (self-contained), results.csv, the plots as PNG, and journal.jsonl, from which an
interrupted suite goes on. A suite with `publish: true` is copied to docs/results/SUITE when it is
done as a whole, and the numbers in the documentation are generated from it. `./run experiment
SUITE` builds the programs and installs what this needs first.
"""
import argparse
import dataclasses
import importlib
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "experiments"))

try:
    from harness import published, report
    from harness.bench import Bench
    from harness.cases import cases_named
    from harness.points import write_csv
    from harness.programs import ProgramFailed
    from harness.suite import InputError, Mapping, checked, read_suite
except ModuleNotFoundError as missing:
    if missing.name.partition(".")[0] == "harness":  # ours: no other Python would have it
        raise
    print(f"run.py: error: {sys.executable}: expected a Python with the packages of "
          f"experiments/requirements.txt, got none called {missing.name}; "
          "experiments/python experiments/run.py has them", file=sys.stderr)
    sys.exit(2)

KINDS = ["hierarchy", "sampling", "model", "total", "scaling", "reuse", "single"]


@dataclasses.dataclass
class Experiment:
    module: object    # harness.kinds.KIND
    settings: object  # its Settings


def experiments_of(suite, only):
    """The suite's experiments with their settings checked, before any of them runs."""
    result = []
    for mapping in suite.experiments:
        kind = mapping["kind"]
        if kind not in KINDS:
            raise InputError(f"{mapping.where('kind')}: kind: expected one of {', '.join(KINDS)}, "
                             f"got '{kind}'")
        if only and kind not in only:
            continue
        module = importlib.import_module(f"harness.kinds.{kind}")
        rest = Mapping(mapping.file, mapping.line, mapping.column)
        rest.places = mapping.places
        rest.update((key, value) for key, value in mapping.items() if key != "kind")
        result.append(Experiment(module, checked(module.Settings, rest)))
    return result


def suite_file(name):
    """The suite of that name or in that file. Throws InputError for a name that is none."""
    path = pathlib.Path(name)
    if path.suffix == ".yaml":
        return path
    suites = {path.stem: path for path in sorted((ROOT / "experiments/suites").glob("*.yaml"))}
    if name not in suites:
        raise InputError(f"suite: expected a file *.yaml or one of {', '.join(suites)}, "
                         f"got '{name}'")
    return suites[name]


def run_suite(path, output, only, fresh):
    suite = read_suite(path)
    experiments = experiments_of(suite, only)
    output = output or ROOT / "experiments/out" / path.stem
    if fresh:
        (output / "journal.jsonl").unlink(missing_ok=True)
    bench = Bench(output, suite.repeat, say=lambda words: print(words, file=sys.stderr))
    for experiment in experiments:
        experiment.module.measure(experiment.settings, bench)
    write_csv(bench.points, output / "results.csv")
    sections = [e.module.section(e.settings, bench) for e in experiments]
    command = " ".join(["./run experiment", path.stem, *(["--only", *only] if only else [])])
    print(report.write(suite, sections, bench, command))
    if suite.publish and not only:
        for changed in published.publish(path.stem, output):
            print(changed)


def needs(path):
    """What a suite needs besides the programs: "fetch" (scanned meshes), "mitsuba"."""
    suite = read_suite(path)
    result = {"mitsuba" for mapping in suite.experiments
              if mapping["kind"] == "total" and "mitsuba" in mapping.get("renderers", ["mitsuba"])}
    for mapping in suite.experiments:
        names = mapping.get("cases", [])
        names = [mapping["case"]] if "case" in mapping else names
        if any(case.needs_fetched_mesh() for case in cases_named(names)):
            result.add("fetch")
    return sorted(result)


def check_published():
    """0 if all generated parts of the documentation are fresh, 1 if not."""
    stale = published.stale()
    for path in stale:
        print(f"{path}: numbers are not those of docs/results; publish a suite again",
              file=sys.stderr)
    return 1 if stale else 0


def main(words):
    """Exit code for these command-line words."""
    parser = argparse.ArgumentParser(prog="run.py", description=__doc__, allow_abbrev=False,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("suite", nargs="?")
    parser.add_argument("--output", type=pathlib.Path)
    parser.add_argument("--only", nargs="+", choices=KINDS)
    parser.add_argument("--fresh", action="store_true", help="measure everything again")
    parser.add_argument("--needs", action="store_true")
    parser.add_argument("--check-published", action="store_true")
    arguments = parser.parse_args(list(words))
    if not arguments.suite and not arguments.check_published:
        parser.error("expected a suite")
    try:
        return act(arguments)
    except InputError as error:
        print(f"run.py: error: {error}", file=sys.stderr)
        return 3
    except ProgramFailed as error:
        print(f"run.py: error: {error}", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"run.py: error: {error.filename}: {error.strerror}", file=sys.stderr)
        return 4
    except KeyboardInterrupt:
        print("run.py: interrupted; the same command goes on from here", file=sys.stderr)
        return 130


def act(arguments):
    """Does what was asked for; returns the exit code."""
    if arguments.check_published:
        return check_published()
    path = suite_file(arguments.suite)
    if arguments.needs:
        print("\n".join(needs(path)))
        return 0
    run_suite(path, arguments.output, arguments.only, arguments.fresh)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
