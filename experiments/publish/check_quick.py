#!/usr/bin/env python3
"""Compares the measurements of ./dev results --quick with the expected numbers.

usage: experiments/publish/check_quick.py MEASURED.json[,MEASURED.json...] EXPECTED.json [--write]

MEASURED is the JSON of `earpoint evaluate`. Every mean of every method must lie within a tolerance: a share of
the expected value or of `input`'s error, whichever is larger, as errors near 0 need an absolute tolerance.
--write makes EXPECTED from what was measured: the mean, of several runs, as of one with and one without AVX-512.

The tolerances: the same program gives the same numbers, but other processors take other instructions, and
rays that graze an edge then hit or miss; training amplifies such differences with each step. With its
libraries limited to AVX2 instead of AVX-512 the trained networks' errors moved by up to a fifth of input's, so EXPECTED
is the mean of both.
"""
import json
import sys

METRICS = ("mag", "lre_db", "rte_s", "level_db", "itd_us", "edt_s", "c50_db")
GIVEN, TRAINED = 0.05, 0.20


def means(text):
    rows = json.loads(text)["rows"]
    return {row["method"]: {name: row[name]["mean"] for name in METRICS
                            if row.get(name) and row[name].get("mean") is not None} for row in rows}


def measured_in(paths):
    """The means of all runs; what one run lacks is missing."""
    runs = []
    for path in paths:
        with open(path, encoding="utf-8") as file:
            runs.append(means(file.read()))
    return {method: {name: sum(run[method][name] for run in runs) / len(runs) for name in row
                     if all(name in run.get(method, {}) for run in runs)} for method, row in runs[0].items()}


def differences(measured, expected):
    """(method, metric, measured, expected) of all numbers out of tolerance, or missing on either side."""
    for method in sorted(measured.keys() | expected.keys()):
        tolerance = TRAINED if method.endswith("-quick") else GIVEN
        ours, theirs = measured.get(method, {}), expected.get(method, {})
        for metric in sorted(ours.keys() | theirs.keys()):
            found, wanted = ours.get(metric), theirs.get(metric)
            if found is None or wanted is None:
                yield method, metric, found, wanted
            elif not abs(found - wanted) <= tolerance * max(wanted, expected["input"][metric]):
                yield method, metric, found, wanted


def main():
    if len(sys.argv) not in (3, 4) or sys.argv[3:] not in ([], ["--write"]):
        sys.exit(__doc__)
    measured = measured_in(sys.argv[1].split(","))
    if sys.argv[3:]:
        with open(sys.argv[2], "w", encoding="utf-8") as file:
            json.dump(measured, file, indent=1)
            file.write("\n")
        return
    with open(sys.argv[2], encoding="utf-8") as file:
        expected = json.load(file)
    wrong = list(differences(measured, expected))
    for method, metric, found, wanted in wrong:
        print(f"{method}: {metric} is {found}, expected {wanted}", file=sys.stderr)
    count = sum(len(row) for row in expected.values())
    if wrong:
        sys.exit(f"check_quick: {len(wrong)} of {count} numbers are not as expected; if they ought to "
                 "be, ./dev results --quick --write")
    print(f"check_quick: all {count} numbers as expected")


if __name__ == "__main__":
    main()
