#!/usr/bin/env python3
"""Cuts the small reference files in this folder out of the whole ones.

usage: cut_reference.py FOLDER    (the folder with filter.safetensors, gcc_phat.safetensors, ...)
"""
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parents[2] / "experiments"))
import safetensors_file  # noqa: E402


def main():
    whole = Path(sys.argv[1])

    tensors = safetensors_file.read_arrays(whole / "filter.safetensors")
    names = ["sos_80", "sos_150", "x2", "x2_cut80", "x2_cut150"]
    safetensors_file.write_arrays(HERE / "filter.safetensors", {n: tensors[n] for n in names})

    tensors = safetensors_file.read_arrays(whole / "gcc_phat.safetensors")
    pairs = {n: tensors[n][[0, 1, 9]] for n in ["sig", "ref", "delay", "margin"]}
    safetensors_file.write_arrays(HERE / "gcc_phat.safetensors", pairs | {"edge": tensors["edge"]})

    tensors = safetensors_file.read_arrays(whole / "resample.safetensors")
    safetensors_file.write_arrays(HERE / "resample.safetensors", {n: t[[0]] for n, t in tensors.items()})


main()
