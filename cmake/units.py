#!/usr/bin/env python3
"""Which sources can be compiled as one translation unit, so that their headers are read once for all of them.

Sources that define the same name at the outermost level, or in an anonymous namespace, go into different units. The
sources are formatted: what is outermost starts its line.

usage: units.py MOST SOURCE...      prints a line for each unit of at most MOST sources: their names, spaces between
"""

import re
import sys
from pathlib import Path

# Headers that a source reads more than once, each time in another way.
READ_AGAIN = re.compile(r"#include .*foreach_target\.h")
ALIAS = re.compile(r"^(?:using|namespace) (\w+) = (.*?);", re.M | re.S)
IMPORT = re.compile(r"^using ((?:\w+::)+)(\w+);", re.M)
ENUM = re.compile(r"^using enum (\w+);", re.M)
TYPE = re.compile(r"^(?:struct|class|union|enum(?: class)?) (\w+)", re.M)
MACRO = re.compile(r"^#define (\w+)", re.M)
TEST = re.compile(r"^TEST(?:_\w+)?\((\w+,\s*\w+)\)", re.M)
# A function or a constant: the last name before its parameters or its value.
OTHER = re.compile(r"^(?!using |namespace |return |#|//)[A-Za-z][^\n;={(]*?[\s&*](\w+)(?:\(|\[| =|\{|;)", re.M)


class Outermost:
    """What a source defines at the outermost level: `meanings` of its names. `alone`: it is a unit of its own."""

    def __init__(self, path):
        text = Path(path).read_text()
        self.alone = bool(READ_AGAIN.search(text))
        text = re.sub(r"//.*", "", text)
        self.meanings = {name: "alias of " + meaning for name, meaning in ALIAS.findall(text)}
        self.meanings.update((name, "alias of " + scope + name) for scope, name in IMPORT.findall(text))
        self.meanings.update(("using enum", name) for name in ENUM.findall(text))
        for pattern in (TYPE, MACRO, TEST, OTHER):
            self.meanings.update(dict.fromkeys(pattern.findall(text), str(path)))
        if "BENCHMARK_MAIN" in text:
            self.meanings["main"] = str(path)


def agree(some, others):
    """Whether two dictionaries have the same values where both have one."""
    return all(some.get(key, value) == value for key, value in others.items())


class Unit:
    """Sources that are compiled as one. A source has a `path` and its `outermost`."""

    def __init__(self, first):
        self.sources, self.meanings = [first], dict(first.outermost.meanings)

    def takes(self, source, most):
        if len(self.sources) == most or source.outermost.alone or self.sources[0].outermost.alone:
            return False
        return agree(self.meanings, source.outermost.meanings)

    def add(self, source):
        self.sources.append(source)
        self.meanings.update(source.outermost.meanings)


def units_of(sources, most, unit=Unit):
    """The sources in units: each goes into the first that takes it."""
    units = []
    for source in sources:
        fitting = next((found for found in units if found.takes(source, most)), None)
        if fitting:
            fitting.add(source)
        else:
            units.append(unit(source))
    return units


class Source:
    def __init__(self, path):
        self.path, self.outermost = path, Outermost(path)


if __name__ == "__main__":
    for unit in units_of([Source(path) for path in sys.argv[2:]], int(sys.argv[1])):
        print(" ".join(source.path for source in unit.sources))
