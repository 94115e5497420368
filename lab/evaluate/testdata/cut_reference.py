#!/usr/bin/env python3
"""Cuts the small reference files in this folder out of the whole ones, and measures silence.

usage: cut_reference.py FOLDER    (the folder with metrics.safetensors, metrics.json, ...)
"""
import json
import shutil
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parents[2] / "experiments"))
import safetensors_file  # noqa: E402

PAIR = 1  # two samples of delay


def main():
    whole = Path(sys.argv[1])
    tensors = safetensors_file.read_arrays(whole / "metrics.safetensors")
    cut = {name: tensors[name][[PAIR]] for name in ["pred", "tgt"]}
    safetensors_file.write_arrays(HERE / "metrics.safetensors", cut)

    values = json.loads((whole / "metrics.json").read_text())
    values = {"per_pair": [values["per_pair"][PAIR]]}
    (HERE / "metrics.json").write_text(json.dumps(values, indent=1) + "\n")
    shutil.copyfile(whole / "signfix.safetensors", HERE / "signfix.safetensors")


main()
