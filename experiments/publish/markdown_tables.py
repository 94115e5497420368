"""Reads tables back from a page, so that plots and headlines need no measured file."""
import re
from typing import NamedTuple, Optional


class Estimate(NamedTuple):
    value: float
    low: Optional[float] = None
    high: Optional[float] = None


def cells_of(line):
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def tables_of(text):
    """Every table of a section: a list of rows, each a dict by heading."""
    tables, lines = [], []
    for line in [*text.splitlines(), ""]:
        if line.startswith("|"):
            lines.append(line)
            continue
        if len(lines) > 2:
            headings = cells_of(lines[0])
            tables.append([dict(zip(headings, cells_of(row))) for row in lines[2:]])
        lines = []
    return tables


def estimate(cell):
    """`0.86 [0.84, 0.88]` or a bare number; None if it was not measured."""
    found = re.match(r"\**(-?[\d.]+)(?: \[(-?[\d.]+), (-?[\d.]+)\])?", cell)
    return Estimate(*(None if text is None else float(text) for text in found.groups())) if found else None


def ratio_table(text):
    """The table of ratios to `input` in a section's content, or its first one."""
    after = re.search(r"^As ratio to `input`[^\n]*\n(.*)", text, re.M | re.S)
    tables = tables_of(after.group(1) if after else text)
    return tables[0] if tables else []
