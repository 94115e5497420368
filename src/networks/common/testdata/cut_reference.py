#!/usr/bin/env python3
"""Cuts the files beside it out of what the released loaders make of random viewpoints. Needs NumPy.

usage: cut_reference.py FOLDER    (the folder with soundspaces.safetensors and replay.safetensors)
"""
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parents[3] / "experiments"))
import safetensors_file  # noqa: E402

KEPT = {
    "soundspaces": ["location", "rotation", "tgt_pose_sincos", "tgt_rotation_sincos"],
    "replay": ["centers", "directions", "pairs", "fixed_rotrel_tgt_pose", "fixed_rotrel_tgt_rotation_sincos"],
}


def main():
    for name, kept in KEPT.items():
        tensors = safetensors_file.read_arrays(Path(sys.argv[1]) / f"{name}.safetensors")
        safetensors_file.write_arrays(HERE / f"{name}.safetensors", {n: tensors[n] for n in kept})


main()
