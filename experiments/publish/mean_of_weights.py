#!/usr/bin/env python3
"""The mean of the weights of networks that were trained from one another.

usage: experiments/publish/mean_of_weights.py OUT.safetensors FILE.safetensors FILE.safetensors...

All must be networks of the same description; other metadata, as of the training, is left out, but for the range of the
training data, which is that of the last.
"""
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import safetensors_file

NETWORK, RANGE = "earpoint.network", "earpoint.training_range"


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__.split("\n\n")[1])
    out, *paths = sys.argv[1:]
    files = [safetensors_file.read(path) for path in paths]
    (first, metadata) = files[0]
    for path, (tensors, others) in zip(paths, files):
        if others.get(NETWORK) != metadata.get(NETWORK) or tensors.keys() != first.keys():
            sys.exit(f"mean_of_weights: {path}: is another network than {paths[0]}")
    mean = {}
    for name, (kind, shape, data) in first.items():
        if kind != "F32":
            sys.exit(f"mean_of_weights: {paths[0]}: '{name}' has type {kind}; expected F32")
        total = sum(np.frombuffer(tensors[name][2], "<f4").astype(np.float64) for tensors, _ in files)
        mean[name] = kind, shape, (total / len(files)).astype("<f4").tobytes()
    safetensors_file.write(out, mean, {key: value for key, value in files[-1][1].items() if key in (NETWORK, RANGE)})


main()
