#!/usr/bin/env python3
"""Compares the ways to separate ambient sound: SI-SDR of the primary sound, and the errors of methods.

usage: ambient_separation.py EARPOINT DATA METHODS [--levels -60,-40,-20] [--limit N] [--context S]

{kind} in METHODS stands for the separation: gtf=runs/{kind}/gtf/best.safetensors measures networks that were each
trained on one. Prints a Markdown table: for room noise of each level and each separation the SI-SDR of the primary
sound, and the Mag of every method.
"""
import argparse
import json
import subprocess

KINDS = ("bandpass", "subtract", "mmse")


def evaluate(arguments, level, kind):
    methods = arguments.methods.replace("{kind}", kind)
    command = [arguments.earpoint, "evaluate", "--data", arguments.data, "--methods", methods, "--ambient",
               f"{level},{kind}", "--context", str(arguments.context), "--json", "--quiet"]
    if arguments.limit:
        command += ["--limit", str(arguments.limit)]
    return json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)


def interval(cell, decimals):
    if cell["low"] is None:
        return f"{cell['mean']:.{decimals}f}"
    return f"{cell['mean']:.{decimals}f} [{cell['low']:.{decimals}f}, {cell['high']:.{decimals}f}]"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("earpoint")
    parser.add_argument("data")
    parser.add_argument("methods", help="as --methods of earpoint evaluate, e.g. input,gtf,vigas")
    parser.add_argument("--levels", default="-60,-40,-20", help="of the noise, dB re full scale")
    parser.add_argument("--limit", type=int)
    parser.add_argument("--context", type=float, default=0.0)
    arguments = parser.parse_args()
    names = [word.split("=")[0] for word in arguments.methods.split(",")]
    print("| noise (dB) | separation | SI-SDR of the primary sound (dB) | " +
          " | ".join(f"Mag of {name}" for name in names) + " |")
    print("|---" * (3 + len(names)) + "|")
    for level in arguments.levels.split(","):
        for kind in KINDS:
            run = evaluate(arguments, level, kind)
            rows = {row["method"]: row for row in run["rows"]}
            cells = [interval(rows[name]["mag"], 4) for name in names]
            print(f"| {level} | {kind} | {interval(run['primary_si_sdr_db'], 1)} | " + " | ".join(cells) + " |",
                  flush=True)


if __name__ == "__main__":
    main()
