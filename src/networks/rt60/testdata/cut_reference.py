#!/usr/bin/env python3
"""Cuts the small reference files in this folder out of the whole ones.

usage: cut_reference.py FOLDER    (the folder with rt60.safetensors and rt60_weights.json)
"""
import shutil
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parents[3] / "experiments"))
import safetensors_file  # noqa: E402

CLIPS = 2


def main():
    whole = Path(sys.argv[1])
    tensors = safetensors_file.read_arrays(whole / "rt60.safetensors")
    cut = {name: tensors[name][:CLIPS] for name in ["feature", "rt60", "wav"]}
    safetensors_file.write_arrays(HERE / "rt60.safetensors", cut)
    shutil.copyfile(whole / "rt60_weights.json", HERE / "rt60_weights.json")


main()
