#!/usr/bin/env python3
"""Cuts the small reference files in this folder out of the whole ones.

usage: cut_reference.py FOLDER    (the folder with metrics.safetensors, metrics.json, ...)
"""
import json
import shutil
import struct
import sys
from pathlib import Path

PAIR = 1  # two samples of delay


def main():
    whole, here = Path(sys.argv[1]), Path(__file__).parent
    data = (whole / "metrics.safetensors").read_bytes()
    (length,) = struct.unpack("<Q", data[:8])
    header = json.loads(data[8 : 8 + length])
    cut, body = {}, b""
    for name in ["pred", "tgt"]:
        begin, end = header[name]["data_offsets"]
        row = (end - begin) // header[name]["shape"][0]
        part = data[8 + length + begin + PAIR * row :][:row]
        cut[name] = {
            "dtype": header[name]["dtype"],
            "shape": [1] + header[name]["shape"][1:],
            "data_offsets": [len(body), len(body) + row],
        }
        body += part
    text = json.dumps(cut).encode()
    text += b" " * (-len(text) % 8)
    (here / "metrics.safetensors").write_bytes(struct.pack("<Q", len(text)) + text + body)

    values = json.loads((whole / "metrics.json").read_text())
    values = {"per_pair": [values["per_pair"][PAIR]]}
    (here / "metrics.json").write_text(json.dumps(values, indent=1) + "\n")
    shutil.copyfile(whole / "signfix.safetensors", here / "signfix.safetensors")


main()
