"""Sections of the pages behind docs/results.md: read back, renewed where they were measured, written."""
import datetime
import os
import re
import shutil
import subprocess
from typing import NamedTuple

from markdown_tables import ratio_table
from ratio_plot import ratio_plot
from result_sections import FORMER_TITLES, FORMER_WORDS, OLDER, PAGES

STAMP = re.compile(r"^\*(?:Older: m|M)easured (.*?)(?:; not measured again since)?\.\*$", re.M)
FOLD = "<details><summary>Tables</summary>"
UNFOLD = "</details>"
NOT_MEASURED = "*Not measured yet.*"


class Measured(NamedTuple):
    """What a section shows besides its introduction."""
    when: str       # "on 2026-11-28 at 4c06d99"
    content: str    # Markdown, tables
    now: bool       # from a file of this run
    words: str = ""  # of a section that is only kept

    def day(self):
        found = re.search(r"\d{4}-\d\d-\d\d", self.when)
        return found.group() if found else ""

    def brief(self):
        """Day and commit, for a table."""
        return self.when.removeprefix("on ").replace("or before ", "by ").replace("written by", "at").replace(", at", " at")


def stamp(path):
    """When a file was measured, and the last commit before that if this is a checkout."""
    seconds = os.path.getmtime(path)
    commit = ""
    if shutil.which("git"):
        commit = subprocess.run(["git", "log", "-1", f"--before={int(seconds)}", "--format=%h"],
                                capture_output=True, text=True, check=False,
                                cwd=os.path.dirname(os.path.abspath(__file__))).stdout.strip()
    day = datetime.datetime.fromtimestamp(seconds, datetime.timezone.utc).date()
    return f"on {day}{' at ' + commit if commit else ''}"


def read(folder, name):
    path = os.path.join(folder, name)
    if not os.path.exists(path) or os.path.getsize(path) == 0:
        return None
    with open(path, encoding="utf-8") as file:
        return file.read().strip()


def sections_of(path):
    """The measured sections that a page has, by title."""
    if not os.path.exists(path):
        return {}
    with open(path, encoding="utf-8") as file:
        text = file.read()
    if os.path.basename(os.path.dirname(path)) != "results":  # One page for all, as it was: links are one folder off.
        text = re.sub(r"\]\((?=images/|adr/)", "](../", text)
    found = {}
    for part in text.split("\n## ")[1:]:
        title, body = part.split("\n", 1)
        stamped = STAMP.search(body)
        if stamped:
            content = body[stamped.end():]
            if FOLD in content:
                content = content.split(FOLD, 1)[1].rsplit(UNFOLD, 1)[0]
            for former, words in FORMER_WORDS.items():
                content = content.replace(former, words)
            found[FORMER_TITLES.get(title, title)] = Measured(stamped.group(1), content.strip(), False,
                                                              body[:stamped.start()].strip())
    return found


def earlier_sections(results):
    """What an earlier run wrote, into one page or several."""
    found = sections_of(results)
    for page in PAGES:
        found |= sections_of(page_path(results, page))
    return found


def page_path(results, page):
    return os.path.join(os.path.dirname(results), "results", f"{page.name}.md")


def measured_sections(folder, earlier):
    """The newest state of every section that has ever been measured, by title."""
    found = dict(earlier)
    for page in PAGES:
        for section in page.sections:
            text = read(folder, section.file)
            if text is not None:
                content = section.table(text) if section.table else text
                found[section.title] = Measured(stamp(os.path.join(folder, section.file)), content, True)
    return found


def newest_day(measured):
    return max((state.day() for state in measured.values()), default="")


def is_older(state, newest):
    return not state.now and state.day() < newest


def stamp_line(state, newest):
    if is_older(state, newest):
        return f"*Older: measured {state.when}; not measured again since.*"
    return f"*Measured {state.when}.*"


def plotted(section, state, results):
    """A section's content with its plot above the folded tables, where it has a plot."""
    drawing = ratio_plot(ratio_table(state.content), section.plot) if section.plot else None
    if drawing is None:
        return [state.content]
    images = os.path.join(os.path.dirname(results), "images")
    os.makedirs(images, exist_ok=True)
    with open(os.path.join(images, f"{section.plot.name}.svg"), "w", encoding="utf-8") as file:
        file.write(drawing)
    return [f"![{section.title}: errors as ratios to the input's](../images/{section.plot.name}.svg)", "",
            FOLD, "", state.content, "", UNFOLD]


def section_text(section, state, newest, results):
    if state is None:
        return [f"## {section.title}", "", section.words, "", NOT_MEASURED, ""]
    return [f"## {section.title}", "", section.words, "", stamp_line(state, newest), "",
            *plotted(section, state, results), ""]


def dropped_sections(measured):
    """Sections of earlier pages that no page lists any more."""
    known = {section.title for page in PAGES for section in page.sections}
    return {title: state for title, state in measured.items() if title not in known}


def write_page(page, measured, results, measured_only):
    """Writes one page; returns whether it has anything."""
    newest = newest_day(measured)
    text = []
    for section in page.sections:
        state = measured.get(section.title)
        if state is not None or not measured_only:
            text += section_text(section, state, newest, results)
    if page is OLDER:
        for title, state in dropped_sections(measured).items():
            text += [f"## {title}", "", state.words, "", stamp_line(state, newest), "", state.content, ""]
    if not text:
        return False
    path = page_path(results, page)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join([f"# {page.title}", "", page.words + " Back to [the headline numbers](../"
                              f"{os.path.basename(results)}).", "", *text]))
    return True
