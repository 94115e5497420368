#!/usr/bin/env python3
"""Cuts the small reference files in this folder out of the whole ones.

usage: cut_reference.py FOLDER    (the folder with rt60.safetensors and rt60_weights.json)
"""
import shutil
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[4] / "experiments"))
from safetensors_file import read, rows, write  # noqa: E402

CLIPS = 2
NAMES = ["feature", "rt60", "wav"]


def main():
    whole, here = Path(sys.argv[1]), Path(__file__).parent
    tensors, _ = read(whole / "rt60.safetensors")
    write(here / "rt60.safetensors", {name: rows(tensors[name], range(CLIPS)) for name in NAMES})
    shutil.copyfile(whole / "rt60_weights.json", here / "rt60_weights.json")


main()
