#!/usr/bin/env python3
"""Cuts the small reference files in this folder out of the whole ones.

usage: cut_reference.py FOLDER    (the folder with filter.safetensors, gcc_phat.safetensors, ...)
"""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "experiments"))
from safetensors_file import read, rows, write  # noqa: E402


def main():
    whole, here = Path(sys.argv[1]), Path(__file__).parent

    tensors, _ = read(whole / "filter.safetensors")
    names = ["sos_80", "sos_150", "x2", "x2_cut80", "x2_cut150"]
    write(here / "filter.safetensors", {n: tensors[n] for n in names})

    tensors, _ = read(whole / "gcc_phat.safetensors")
    pairs = {n: rows(tensors[n], [0, 1, 9]) for n in ["sig", "ref", "delay", "margin"]}
    write(here / "gcc_phat.safetensors", pairs | {"edge": tensors["edge"]})

    tensors, _ = read(whole / "resample.safetensors")
    write(here / "resample.safetensors", {n: rows(t, [0]) for n, t in tensors.items()})


main()
