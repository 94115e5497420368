#!/usr/bin/env python3
"""Writes docs/results.md and the pages behind it from what ./dev results has measured: numbers, without judgement.

usage: experiments/publish/write_results.py MEASURED RESULTS.md [--measured-only] [--readme README.md]

MEASURED is a folder with the files that experiments/publish/result_sections.py names. RESULTS.md gets the headline
numbers; a page for each topic goes into results/ beside it, plots into images/. A section whose file is missing
keeps its numbers, and is marked as older if others are of a later day. Sections of earlier versions, which were
all in RESULTS.md, are kept. --measured-only leaves out what was never measured and ignores what was written
before. --readme renews the lines of README.md between <!-- results --> and <!-- /results -->.
"""
import argparse
import os
import platform
import re

from headlines import headline_table, link, readme_lines
from result_pages import earlier_sections, is_older, measured_sections, newest_day, write_page
from result_sections import PAGES


def machine():
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        model = next(line.split(":")[1].strip() for line in file if line.startswith("model name"))
    return f"{model}, {os.cpu_count()} cores, {platform.system()} {platform.machine()}"


def contents(page, measured, measured_only):
    """One line for each section of a page: when it was measured."""
    newest = newest_day(measured)
    lines = [f"**[{page.title}](results/{page.name}.md)**: {page.words}", ""]
    for section in page.sections:
        state = measured.get(section.title)
        if state is None and measured_only:
            continue
        when = "not measured yet" if state is None else \
            state.brief() + (" (older)" if is_older(state, newest) else "")
        lines.append(f"- [{section.title}]({link(section.title)}): {when}")
    return [*lines, ""]


def write_index(results, pages, measured, measured_only):
    plot = next((section for page in pages for section in page.sections
                 if section.plot and section.title in measured), None)
    text = ["# Results", "",
            f"Written by `./dev results` on {machine()}. *of input*: the error as a share of that of the "
            "unchanged input; below 1 the method improves on it. *Older* numbers were not measured again since then; the simulator or "
            "a network may have changed. Each number links to its section, with the command that "
            "measures it.", "", *headline_table(measured), ""]
    if plot:
        text += [f"![{plot.title}: errors as ratios to the input's](images/{plot.plot.name}.svg)", "",
                 f"*[{plot.title}]({link(plot.title)}). Oracles, in grey, are given part of the answer.*", ""]
    text += ["## Pages", ""]
    for page in pages:
        text += contents(page, measured, measured_only)
    with open(results, "w", encoding="utf-8") as file:
        file.write("\n".join(text))


def renew_readme(path, measured):
    with open(path, encoding="utf-8") as file:
        text = file.read()
    lines = "\n".join(readme_lines(measured))
    with open(path, "w", encoding="utf-8") as file:
        file.write(re.sub(r"(<!-- results -->\n).*?(<!-- /results -->)", lambda m: f"{m[1]}{lines}\n{m[2]}", text,
                          flags=re.S))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("measured")
    parser.add_argument("results")
    parser.add_argument("--measured-only", action="store_true")
    parser.add_argument("--readme")
    arguments = parser.parse_args()
    earlier = {} if arguments.measured_only else earlier_sections(arguments.results)
    measured = measured_sections(arguments.measured, earlier)
    pages = [page for page in PAGES if write_page(page, measured, arguments.results, arguments.measured_only)]
    write_index(arguments.results, pages, measured, arguments.measured_only)
    if arguments.readme:
        renew_readme(arguments.readme, measured)


if __name__ == "__main__":
    main()
