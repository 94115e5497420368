#!/usr/bin/env python3
"""Draws which module includes which, for docs/tour.md. ./dev lint checks the picture against the sources.

A module stands above all that it includes; an arrow that follows from others is left out. Blue ships, orange is the lab.

usage: module_graph.py ROOT [--check]     writes or checks docs/images/modules.svg
"""

import html
import sys
from pathlib import Path

from check_modules import FRONT_DOOR, INCLUDE, is_test, owner, read_modules

PICTURE = "docs/images/modules.svg"
WIDTH, ROW, BOX = 1060, 92, (112, 34)
COLOURS = {"src": ("#dbe9f7", "#0072b2"), "lab": ("#fbe6d5", "#d55e00")}


def included(root, modules):
    """{module: the modules that its files include}, without tests and test support."""
    found = {name: set() for name in modules if not name.endswith("_testing")}
    for folder in ("src", "lab"):
        for path in sorted((root / folder).rglob("*")):
            if path.suffix not in (".h", ".cpp") or is_test(path):
                continue
            module = owner(modules, path)
            if module is None or module.name not in found:
                continue
            for bracket, name in INCLUDE.findall(path.read_text()):
                parts = name.split("/")
                if bracket != "<" or parts[0] != "earpoint":
                    continue
                other = parts[1] if len(parts) > 2 else FRONT_DOOR.get(parts[1], "core")
                if other in found:
                    found[module.name].add(other)
    return {name: others - {name} for name, others in found.items()}


def reachable(graph, name):
    """All that a module includes, directly or by way of others."""
    found, todo = set(), list(graph[name])
    while todo:
        other = todo.pop()
        if other not in found:
            found.add(other)
            todo += graph[other]
    return found


def reduced(graph):
    """The graph without arrows that follow from others."""
    return {name: {other for other in others
                   if not any(other in reachable(graph, between) for between in others - {other})}
            for name, others in graph.items()}


def rows_of(graph, arrows):
    """Modules by the longest way down to core, each row sorted to stand above what it includes."""
    level = {}

    def depth(name):
        if name not in level:
            level[name] = 1 + max((depth(other) for other in graph[name]), default=-1)
        return level[name]

    rows = [[] for _ in range(1 + max(depth(name) for name in graph))]
    for name in sorted(graph):
        rows[level[name]].append(name)
    place = {}
    for row in rows:
        row.sort(key=lambda name: (sum(place[o] for o in sorted(arrows[name])) / len(arrows[name]) if arrows[name] else 0.5, name))
        place |= {name: (i + 0.5) / len(row) for i, name in enumerate(row)}
    return rows, place


def draw(root):
    modules = {name: module for name, module in read_modules(root).items()
               if not module.folder.is_relative_to(root / "bindings")}
    graph = included(root, modules)
    arrows = reduced(graph)
    rows, place = rows_of(graph, arrows)
    height = ROW * len(rows) + 30
    x = {name: WIDTH * place[name] for name in graph}
    y = {name: height - 60 - ROW * i for i, row in enumerate(rows) for name in row}
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" height="{height}" '
             'font-family="sans-serif" font-size="14" text-anchor="middle"><rect width="100%" height="100%" fill="#fff"/>']
    for name in sorted(arrows):
        for other in sorted(arrows[name]):
            x1, y1, x2, y2 = x[name], y[name] + BOX[1] / 2, x[other], y[other] - BOX[1] / 2
            parts.append(f'<path d="M{x1:.0f} {y1:.0f} C{x1:.0f} {y1 + 35:.0f} {x2:.0f} {y2 - 35:.0f} {x2:.0f} {y2:.0f}" '
                         'fill="none" stroke="#8a93a0" stroke-width="1.2"/>')
    for name in sorted(graph):
        fill, stroke = COLOURS[modules[name].folder.relative_to(root).parts[0]]
        folder = modules[name].folder.relative_to(root).as_posix()
        parts.append(f'<g><title>{html.escape(folder)}</title><rect x="{x[name] - BOX[0] / 2:.0f}" y="{y[name] - BOX[1] / 2:.0f}" '
                     f'width="{BOX[0]}" height="{BOX[1]}" rx="5" fill="{fill}" stroke="{stroke}"/>'
                     f'<text x="{x[name]:.0f}" y="{y[name] + 5:.0f}" fill="#1d2430" '
                     f'font-size="{12 if len(name) > 13 else 14}">{name}</text></g>')
    return "\n".join([*parts, "</svg>", ""])


def main():
    if len(sys.argv) not in (2, 3) or sys.argv[2:] not in ([], ["--check"]):
        sys.exit(__doc__)
    root = Path(sys.argv[1]).resolve()
    picture, drawing = root / PICTURE, draw(root)
    if sys.argv[2:]:
        if not picture.exists() or picture.read_text() != drawing:
            sys.exit(f"{PICTURE} is not the picture of the sources; run python3 cmake/module_graph.py .")
        return
    picture.write_text(drawing)


if __name__ == "__main__":
    main()
