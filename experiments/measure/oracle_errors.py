#!/usr/bin/env python3
"""Largest error of `earpoint model run` against outputs of the authors' own code.

For every folder of ORACLES that has a checkpoint (best_val.ckpt, inputs.safetensors,
outputs.safetensors): import, run, compare. Prints a Markdown table.

usage: experiments/measure/oracle_errors.py EARPOINT ORACLES
"""
import array
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import safetensors_file  # noqa: E402


def read_floats(path):
    """The float32 tensors of a safetensors file: name -> numbers."""
    tensors, _ = safetensors_file.read(path)
    return {name: array.array("f", data) for name, (dtype, _, data) in tensors.items() if dtype == "F32"}


def rows_of(earpoint, folder, name):
    with tempfile.TemporaryDirectory() as scratch:
        weights = os.path.join(scratch, "weights.safetensors")
        outputs = os.path.join(scratch, "outputs.safetensors")
        run = lambda *arguments: subprocess.run([earpoint, *arguments], check=True,
                                                stdout=subprocess.DEVNULL)
        run("model", "import", os.path.join(folder, "best_val.ckpt"), "-o", weights)
        run("model", "run", weights, os.path.join(folder, "inputs.safetensors"), "-o", outputs)
        ours = read_floats(outputs)
    theirs = read_floats(os.path.join(folder, "outputs.safetensors"))
    for tensor in ("visual_feat", "fused", "pred"):
        if tensor in ours and tensor in theirs and len(ours[tensor]) == len(theirs[tensor]):
            error = max(abs(a - b) for a, b in zip(ours[tensor], theirs[tensor]))
            scale = max(abs(value) for value in theirs[tensor])
            yield f"| {name} | {tensor} | {error:.1e} | {scale:.2g} |"


def main():
    earpoint, oracles = sys.argv[1:3]
    print("| network | output | largest error | largest value |\n|---|---|---|---|")
    for name in sorted(os.listdir(oracles)):
        folder = os.path.join(oracles, name)
        if os.path.exists(os.path.join(folder, "best_val.ckpt")):
            for row in rows_of(earpoint, folder, name):
                print(row)


if __name__ == "__main__":
    main()
