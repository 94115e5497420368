#!/usr/bin/env python3
"""Cuts the small reference files in this folder out of the whole ones.

usage: cut_reference.py FOLDER    (the folder with filter.safetensors, gcc_phat.safetensors, ...)
"""
import json
import struct
import sys
from pathlib import Path

SIZES = {"F64": 8, "F32": 4}


def read(path):
    data = path.read_bytes()
    (length,) = struct.unpack("<Q", data[:8])
    header = json.loads(data[8 : 8 + length])
    header.pop("__metadata__", None)
    tensors = {}
    for name, entry in header.items():
        begin, end = entry["data_offsets"]
        body = data[8 + length + begin : 8 + length + end]
        tensors[name] = (entry["dtype"], entry["shape"], body)
    return tensors


def write(path, tensors):
    header, body = {}, b""
    for name, (dtype, shape, data) in sorted(tensors.items(), key=lambda t: -SIZES[t[1][0]]):
        header[name] = {
            "dtype": dtype,
            "shape": shape,
            "data_offsets": [len(body), len(body) + len(data)],
        }
        body += data
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 8)
    path.write_bytes(struct.pack("<Q", len(text)) + text + body)


def rows(tensor, chosen):
    dtype, shape, data = tensor
    row = len(data) // shape[0]
    return dtype, [len(chosen)] + shape[1:], b"".join(data[r * row : (r + 1) * row] for r in chosen)


def main():
    whole, here = Path(sys.argv[1]), Path(__file__).parent

    tensors = read(whole / "filter.safetensors")
    names = ["sos_80", "sos_150", "x2", "x2_cut80", "x2_cut150"]
    write(here / "filter.safetensors", {n: tensors[n] for n in names})

    tensors = read(whole / "gcc_phat.safetensors")
    pairs = {n: rows(tensors[n], [0, 1, 9]) for n in ["sig", "ref", "delay", "margin"]}
    write(here / "gcc_phat.safetensors", pairs | {"edge": tensors["edge"]})

    tensors = read(whole / "resample.safetensors")
    write(here / "resample.safetensors", {n: rows(t, [0]) for n, t in tensors.items()})


main()
