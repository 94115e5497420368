#!/usr/bin/env python3
"""Runs clang-tidy on many sources, several to a translation unit. Run by ./dev lint.

Nearly all of clang-tidy's time goes into the headers that a source includes, and a unit reads each header once for all
of its sources. Where clang does not compile a unit, its sources are checked one by one.

usage: tidy.py BUILD_FOLDER < NAMES_OF_SOURCES
"""

import json
import os
import re
import shlex
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

import units

ROOT = Path(__file__).resolve().parent.parent
# A unit of this many sources takes some 0.7 GB of memory; more would gain little.
MOST_IN_UNIT = 12
# All our headers but the C interface's, which is C.
OURS = (rf"^{re.escape(str(ROOT))}/((apps|bindings/(python|plugin)|cmake|examples|experiments|include|lab|src|web)/"
        r"|bindings/c/[^/]*$)")
# These change neither what a source means nor what clang-tidy finds in it.
WITHOUT_MEANING = re.compile(r"-(O\d?|g\d?|fPIC|fPIE|fvisibility.*)$")
SUMMARIES = re.compile(r"(warnings?|errors?) generated|^Error while processing|warnings? treated as|Suppressed"
                       r"|Use -header-filter|^$")


class Source:
    """A source, what it defines at the outermost level, and how it is compiled."""

    def __init__(self, entry):
        self.path, self.folder = entry["file"], entry["directory"]
        self.outermost = units.Outermost(self.path)
        self.includes, self.defines, self.others = [], {}, []
        flags = iter(shlex.split(entry["command"])[1:])
        for flag in flags:
            if flag in ("-o", "-c"):
                next(flags)
            elif flag == "-isystem":
                self.includes.append((flag, next(flags)))
            elif flag.startswith("-I"):
                self.includes.append((flag,))
            elif flag.startswith("-D"):
                name, _, value = flag[2:].partition("=")
                self.defines[name] = value
            elif flag.startswith("-") and not WITHOUT_MEANING.match(flag):
                self.others.append(flag)


class Unit(units.Unit):
    """Sources that are also compiled alike: with the same flags, and without macros of different values."""

    def __init__(self, first):
        super().__init__(first)
        self.defines = dict(first.defines)

    def takes(self, source, most):
        return (source.others == self.sources[0].others and units.agree(self.defines, source.defines)
                and super().takes(source, most))

    def add(self, source):
        super().add(source)
        self.defines.update(source.defines)

    def write(self, path):
        """Writes the unit as a source of its own; returns its compile command."""
        path.write_text("".join(f'#include "{source.path}"  // NOLINT\n' for source in self.sources))
        includes = dict.fromkeys(flag for source in self.sources for flag in source.includes)
        # A local name may be one that another source has at its outermost level; GCC sees what it hides in its own.
        command = ["clang++", *self.sources[0].others, "-Wno-shadow"]
        command += [f"-D{name}={value}" if value else f"-D{name}" for name, value in self.defines.items()]
        command += [part for flag in includes for part in flag]
        return {"directory": self.sources[0].folder, "file": str(path),
                "command": shlex.join([*command, "-c", str(path)])}


def findings(database, path):
    """clang-tidy's exit code and findings in a file, and whether clang compiled it."""
    done = subprocess.run(["clang-tidy", "-p", str(database), "--quiet", f"--header-filter={OURS}", str(path)],
                          capture_output=True, text=True)
    said = "".join(line for line in (done.stdout + done.stderr).splitlines(True) if not SUMMARIES.search(line.rstrip()))
    return done.returncode, said, "clang-diagnostic-error" not in said


def check(build, unit, path):
    """Exit codes and findings of a unit's sources."""
    code, said, compiled = findings(path.parent, path)
    if compiled or len(unit.sources) == 1:
        return [(code, said)]
    return [findings(build, source.path)[:2] for source in unit.sources]


def main():
    build = Path(sys.argv[1]).resolve()
    wanted = {str(ROOT / name.strip()) for name in sys.stdin if name.strip()}
    entries = {entry["file"]: entry for entry in reversed(json.loads((build / "compile_commands.json").read_text()))}
    failed = False
    for name in sorted(wanted - set(entries)):
        failed = True
        print(f"{os.path.relpath(name, ROOT)}: no target compiles it")
    sources = [Source(entries[name]) for name in sorted(wanted & set(entries))]
    found = units.units_of(sources, MOST_IN_UNIT, Unit)
    folder = build / "tidy"
    folder.mkdir(exist_ok=True)
    paths = [folder / f"unit_{number}.cpp" for number in range(len(found))]
    (folder / "compile_commands.json").write_text(
        json.dumps([unit.write(path) for unit, path in zip(found, paths)], indent=1))
    printed, singly = set(), 0
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for future in as_completed([pool.submit(check, build, unit, path) for unit, path in zip(found, paths)]):
            singly += len(future.result()) if len(future.result()) > 1 else 0
            for code, said in future.result():
                failed = failed or code != 0
                if said not in printed:
                    print(said, end="", flush=True)
                printed.add(said)
    print(f"clang-tidy: {len(sources)} sources in {len(found)} units, {singly} sources one by one", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
