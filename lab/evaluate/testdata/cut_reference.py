#!/usr/bin/env python3
"""Cuts the small reference files in this folder out of the whole ones.

usage: cut_reference.py FOLDER    (the folder with metrics.safetensors, metrics.json, ...)
"""
import json
import shutil
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "experiments"))
from safetensors_file import read, rows, write  # noqa: E402

PAIR = 1  # two samples of delay


def main():
    whole, here = Path(sys.argv[1]), Path(__file__).parent
    tensors, _ = read(whole / "metrics.safetensors")
    write(here / "metrics.safetensors", {name: rows(tensors[name], [PAIR]) for name in ["pred", "tgt"]})

    values = json.loads((whole / "metrics.json").read_text())
    values = {"per_pair": [values["per_pair"][PAIR]]}
    (here / "metrics.json").write_text(json.dumps(values, indent=1) + "\n")
    shutil.copyfile(whole / "signfix.safetensors", here / "signfix.safetensors")


main()
