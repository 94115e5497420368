#!/usr/bin/env python3
"""The effect of a change of the simulator on the tables of methods: the means of an earlier page beside new ones.

usage: experiments/publish/change_of_results.py EARLIER.md evaluate-single.json METHODS evaluate-novel.json METHODS
         >out/bench/change_of_results.md

EARLIER.md is docs/results/methods.md of an earlier commit (git show COMMIT:docs/results/methods.md). METHODS, separated by
commas, are those that are the same in both; networks only if their files are the same.
"""
import json
import re
import sys

from evaluation_tables import METRICS, extent

SECTIONS = ("Methods in one home", "Methods in unseen homes")


def earlier_means(page, section):
    """{method: {heading: (mean, low, high)}} of the first table below a section's heading."""
    text = page.split(f"\n## {section}\n", 1)[1].split("\n## ", 1)[0]
    lines = [line for line in text.split("\n") if line.startswith("|")]
    headings = [cell.strip() for cell in lines[0].strip("|").split("|")]
    means = {}
    for line in lines[2:]:
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if cells[0] in means or cells[0] == "method":
            break
        numbers = [tuple(float(n) for n in re.findall(r"-?[\d.]+", cell)) for cell in cells[1:]]
        means[cells[0]] = dict(zip(headings[1:], numbers))
    return means


def change_table(before, run, methods):
    """Before -> after of every metric; bold where the intervals do not overlap."""
    metrics = [m for m in METRICS if any(m[0] in row for row in run["rows"])]
    lines = ["| method | " + " | ".join(heading for _, heading, _ in metrics) + " |",
             "|---" * (len(metrics) + 1) + "|"]
    for row in run["rows"]:
        name = row["method"]
        if name not in methods or name not in before:
            continue
        cells = []
        for key, heading, decimals in metrics:
            old, new = before[name].get(heading), row.get(key)
            if not old or not new or new["mean"] is None:
                cells.append("–")
                continue
            apart = new["low"] > old[2] or new["high"] < old[1]
            text = f"{old[0]:.{decimals}f} → {new['mean']:.{decimals}f}"
            cells.append(f"**{text}**" if apart else text)
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main():
    if len(sys.argv) != 6:
        sys.exit(__doc__)
    with open(sys.argv[1]) as file:
        page = file.read()
    parts = []
    for section, path, methods in zip(SECTIONS, sys.argv[2::2], sys.argv[3::2]):
        with open(path) as file:
            run = json.load(file)
        parts += [f"{section.removeprefix('Methods in ').capitalize()}, {extent(run)}:", "",
                  change_table(earlier_means(page, section), run, methods.split(",")), ""]
    print("\n".join(parts + ["Bold: the intervals of before and after do not overlap."]))


if __name__ == "__main__":
    main()
