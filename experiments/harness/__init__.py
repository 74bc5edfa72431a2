# SPDX-License-Identifier: Apache-2.0
"""Drives tallow's programs, measures error and time, and writes reports. Entry: experiments/run.py.

suite.py     what to measure, from YAML                 journal.py  what has been measured already
bench.py     what a kind of experiment measures with    programs.py running tallow's programs
points.py    one measured setting; results.csv          cases.py    the standard cases
fits.py      powers, reading between points             words.py    numbers in sentences
sweeps.py    running the C++ sweeps                     caches.py   caches made only if needed
launch.py    a small process that runs and measures another one
kinds/       one module a kind of experiment: measure(settings, bench) and section(settings, bench)
"""
