#!/usr/bin/env python3
"""Checks that the modules keep to what they declare. Run by ./dev lint; prints one line per fault.

- A file includes headers of its own module and of those that its CMakeLists.txt names in DEPENDS, a test also of those in
  TEST_DEPENDS. The compiler cannot check that, as it also sees what these include.
- No module depends on itself by way of others, and nothing that ships depends on the lab.
- Training graphs share a network's description, weights and input encoding with its engine, but not the engine: each is
  the check of the other.
- A source file includes its own header first, so that the header is known to stand alone.
- No message of a library names a flag: apps/earpoint/flag_advice.cpp adds it, by phrases and settings that messages still
  have.

usage: check_modules.py ROOT
"""

import re
import sys
from pathlib import Path

FLAG = re.compile(r'"[^"\n]*--[a-z][^"\n]*"')
INCLUDE = re.compile(r'^#include ([<"])([^>"]+)[>"]', re.M)
# What a training graph may read of networks.
SHARED_WITH_TRAINING = {"description", "weights", "view", "constants", "encoding", "training_range", "sight",
                        "checkpoint_export"}
# The modules that own the headers in include/earpoint; the others are core's, which every module may include.
FRONT_DOOR = {"renderer.h": "library", "stream.h": "library", "network.h": "library", "version.h": "library",
              "earpoint.h": "c_api",
              "trace.h": "lab_library", "metrics.h": "lab_library"}
NETWORKS = {"gtf", "vigas", "vam", "rt60", "people"}


class Module:
    def __init__(self, name, folder, depends, test_depends):
        self.name, self.folder, self.depends, self.test_depends = name, folder, depends, test_depends


def keyword(call, name):
    keys = "DEPENDS|LIBRARIES|SOURCES|TESTS|TEST_DEPENDS|TEST_LIBRARIES|SUITES"
    found = re.search(rf"\b{name}\b(.*?)(?=\b(?:{keys})\b|$)", call, re.S)
    return set(re.findall(r"[\w]+", found.group(1))) if found else set()


def read_modules(root):
    modules = {}
    for path in sorted([found for half in ("src", "lab", "bindings") for found in root.glob(f"{half}/**/CMakeLists.txt")]):
        text = re.sub(r"#.*", "", path.read_text())
        for name, call in re.findall(r"earpoint_add_module\((\w+)([^)]*)\)", text):
            test_depends = keyword(call, "TEST_DEPENDS")
            modules[name] = Module(name, path.parent, keyword(call, r"(?<!TEST_)DEPENDS"), test_depends)
    return modules


def owner(modules, path):
    held = [m for m in modules.values() if path.is_relative_to(m.folder)]
    return max(held, key=lambda m: len(m.folder.parts), default=None)


def is_test(path):
    return bool(re.search(r"(_test|_fuzz)\.cpp$|^test_|^drawn_|^reference_|^oracle_batch", path.name))


def check_includes(root, modules, path):
    module, text = owner(modules, path), path.read_text()
    if module is None:
        return
    here = path.relative_to(root)
    allowed = module.depends | {module.name}
    if is_test(path):
        allowed |= module.test_depends
    for bracket, name in INCLUDE.findall(text):
        parts = name.split("/")
        if bracket != "<" or parts[0] != "earpoint":
            continue
        if len(parts) < 3:
            of = FRONT_DOOR.get(parts[1])
            if of and of not in allowed:
                yield f"{here}: includes {name}, but module {module.name} does not name {of} among its dependencies"
            continue
        if parts[1] not in allowed:
            yield f"{here}: includes {name}, but module {module.name} does not name {parts[1]} among its dependencies"
        if module.name == "train" and not is_test(path) and parts[1] in NETWORKS and \
                Path(name).stem not in SHARED_WITH_TRAINING:
            yield f"{here}: includes {name}, of the engine, which must stay independent of the graph"
    yield from check_own_header(root, here, path, module, text)
    if not is_test(path):
        for message in FLAG.findall(text):
            if "./dev " not in message:
                yield f"{here}: a message names a flag, which only apps/ may do: {message}"


def check_own_header(root, here, path, module, text):
    if path.suffix != ".cpp" or is_test(path):
        return
    headers = [f"{path.stem}.h"]
    if path.parent != module.folder:  # train/gtf/learner.cpp has its declarations in earpoint/train/gtf_learner.h
        headers.append(f"{path.parent.name}_{path.stem}.h")
    public = module.folder / "include" / "earpoint" / module.name
    own = [h for h in headers if (public / h).exists() and (h != headers[0] or path.parent == module.folder)]
    own += [h for h in headers[:1] if (path.parent / h).exists()]
    if path.parent == module.folder and module.name in ("core", "library", "lab_library"):
        own += [h for h in headers[:1] if (root / "include/earpoint" / h).exists()]
    first = INCLUDE.search(text)
    if own and not (first and Path(first.group(2)).name in own):
        yield f"{here}: does not include its own header, {own[0]}, first"


def check_circles(modules):
    done, way = set(), []

    def visit(name):
        if name in way:
            yield "modules depend on each other in a circle: " + " -> ".join([*way[way.index(name):], name])
            return
        if name in done or name not in modules:
            return
        way.append(name)
        for other in sorted(modules[name].depends):
            yield from visit(other)
        way.pop()
        done.add(name)

    for name in sorted(modules):
        yield from visit(name)


def check_halves(root, modules):
    for module in modules.values():
        for other in sorted(module.depends):
            if other not in modules:
                yield f"{module.folder.relative_to(root)}: depends on {other}, which is not a module"
            elif module.folder.is_relative_to(root / "src") and modules[other].folder.is_relative_to(root / "lab"):
                yield f"{module.folder.relative_to(root)}: a module that ships depends on {other} of the lab"


def check_advice(root):
    here = Path("apps/earpoint/flag_advice.cpp")
    advice = (root / here).read_text()
    sources = [path.read_text() for folder in ("src", "lab", "apps") for path in (root / folder).rglob("*.cpp")
               if not is_test(path) and path.name != here.name]
    messages = re.sub(r'"\s*"', "", "\n".join(sources))  # literals that continue on the next line
    for phrase in re.findall(r'Advice\{"([^"]+)"', advice):
        if phrase not in messages:
            yield f"{here}: no message says '{phrase}'"
    for setting in re.findall(r'"(\w+)"', re.search(r"kSettings =.*?;", advice, re.S).group(0)):
        if not re.search(rf'"{setting}[": ]', messages):
            yield f"{here}: no message begins with '{setting}'"


def main(root):
    modules = read_modules(root)
    faults = [*check_circles(modules), *check_halves(root, modules), *check_advice(root)]
    for folder in ("src", "lab", "bindings"):
        for path in sorted((root / folder).rglob("*")):
            if path.suffix in (".h", ".cpp"):
                faults += check_includes(root, modules, path)
    print("\n".join(faults), end="\n" if faults else "")
    return 1 if faults else 0


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    sys.exit(main(Path(sys.argv[1]).resolve()))
