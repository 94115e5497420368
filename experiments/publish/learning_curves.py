#!/usr/bin/env python3
"""Learning curves of training runs on one data set, as a Markdown table on standard output and a picture.

usage: experiments/publish/learning_curves.py RUNS PICTURE.svg

RUNS has a folder of `earpoint train --out` for each method, and is named after the data. The table's forecast
extends the line through the later half of a curve, on logarithmic axes, to ten times the clips.
"""
import csv
import json
import math
import os
import sys

HEIGHT, LEFT, TOP, PLOT = 330, 60, 40, (330, 230)
COLOURS = {"gtf-begun": "#56b4e9", "gtf": "#0072b2", "gtf-adapted": "#0072b2", "vigas": "#d55e00",
           "vigas-adapted": "#d55e00", "vigas-blind": "#e69f00", "vam": "#009e73"}
TITLES = {"single": "one home", "novel": "unseen homes"}  # by the folder of the data


def curve_of(folder):
    """(clips, error) pairs of the validations, and seconds of the whole run.

    Steps that produced no sound are not counted, nor are validations before the end of these steps.
    """
    with open(os.path.join(folder, "validation.csv"), encoding="utf-8") as file:
        rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
    with open(os.path.join(folder, "config.json"), encoding="utf-8") as file:
        config = json.load(file)
    silent = config["network"].get("place_steps", 0) * config["training"]["batch"]
    return [(row["clips"] - silent, row["error"]) for row in rows
            if row["clips"] >= silent], rows[-1]["seconds"]


def forecast(curve, clips):
    """The error at so many clips if the later half of the curve goes on as a power of the clips."""
    later = [(math.log(n), math.log(error)) for n, error in curve if 0 < curve[-1][0] <= 2 * n]
    if len(later) < 3:
        return None
    mean_x = sum(x for x, _ in later) / len(later)
    mean_y = sum(y for _, y in later) / len(later)
    slope = (sum((x - mean_x) * (y - mean_y) for x, y in later)
             / sum((x - mean_x) ** 2 for x, _ in later))
    return math.exp(mean_y + slope * (math.log(clips) - mean_x))


def runs_of(folder):
    for method in sorted(os.listdir(folder)):
        run = os.path.join(folder, method)
        if method in COLOURS and os.path.exists(os.path.join(run, "validation.csv")):
            yield method, *curve_of(run)


def polyline(curve, x_of, y_of, colour):
    points = " ".join(f"{x_of(n):.1f},{y_of(error):.1f}" for n, error in curve)
    return f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="2"/>'


def text(x, y, words, anchor="middle"):
    return f'<text x="{x:.0f}" y="{y:.0f}" text-anchor="{anchor}">{words}</text>'


def picture(data, runs):
    """Error over thousands of clips."""
    width, height = PLOT
    left = LEFT
    most = max(curve[-1][0] for _, curve, _ in runs)
    errors = [error for _, curve, _ in runs for _, error in curve]
    # Networks start as a copy of their input: larger errors are cut off.
    low, high = 0.98 * min(errors), 1.02 * max(curve[0][1] for _, curve, _ in runs)
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width + 2 * LEFT}" height="{HEIGHT}" '
             'font-family="sans-serif" font-size="12"><rect width="100%" height="100%" fill="#fff"/>',
             f'<rect x="{left}" y="{TOP}" width="{width}" height="{height}" fill="none" '
             'stroke="#888"/>', text(left + width / 2, TOP - 12, f"Mag of validation pairs, {data}")]
    x_of = lambda n: left + width * n / most
    y_of = lambda error: TOP + height * (high - min(error, high)) / (high - low)
    for i in range(5):
        value = low + (high - low) * i / 4
        parts.append(text(left - 6, y_of(value) + 4, f"{value:.3f}", "end"))
        parts.append(text(x_of(most * i / 4), TOP + height + 18, f"{most * i / 4000:.0f}k"))
    parts.append(text(left + width / 2, TOP + height + 38, "clips seen"))
    for i, (name, curve, _) in enumerate(runs):
        parts.append(polyline(curve, x_of, y_of, COLOURS[name]))
        parts.append(f'<g fill="{COLOURS[name]}">'
                     + text(left + width - 8, TOP + 18 + 16 * i, name, "end") + "</g>")
    return "\n".join(parts + ["</svg>", ""])


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    runs = list(runs_of(sys.argv[1]))
    if not runs:
        sys.exit(f"learning_curves: {sys.argv[1]}: holds no run; train first (earpoint train)")
    print("| network | clips seen | minutes | Mag before | at half | at the end | "
          "forecast for ten times the clips |\n|---|---|---|---|---|---|---|")
    for method, curve, seconds in runs:
        half = min(curve, key=lambda point: abs(point[0] - curve[-1][0] / 2))
        later = forecast(curve, 10 * curve[-1][0])
        print(f"| {method} | {curve[-1][0]:.0f} | {seconds / 60:.0f} | {curve[0][1]:.4f} | "
              f"{half[1]:.4f} | {curve[-1][1]:.4f} | {f'{later:.4f}' if later else ''} |")
    with open(sys.argv[2], "w", encoding="utf-8") as file:
        data = os.path.basename(os.path.normpath(sys.argv[1]))
        file.write(picture(TITLES.get(data, data), runs))


main()
