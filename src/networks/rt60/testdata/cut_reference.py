#!/usr/bin/env python3
"""Cuts the small reference files in this folder out of the whole ones.

usage: cut_reference.py FOLDER    (the folder with rt60.safetensors and rt60_weights.json)
"""
import json
import shutil
import struct
import sys
from pathlib import Path

CLIPS = 2
NAMES = ["feature", "rt60", "wav"]


def main():
    whole, here = Path(sys.argv[1]), Path(__file__).parent
    data = (whole / "rt60.safetensors").read_bytes()
    (length,) = struct.unpack("<Q", data[:8])
    header = json.loads(data[8 : 8 + length])
    cut, body = {}, b""
    for name in NAMES:
        begin, end = header[name]["data_offsets"]
        shape = header[name]["shape"]
        part = data[8 + length + begin :][: (end - begin) // shape[0] * CLIPS]
        cut[name] = {
            "dtype": header[name]["dtype"],
            "shape": [CLIPS] + shape[1:],
            "data_offsets": [len(body), len(body) + len(part)],
        }
        body += part
    text = json.dumps(cut).encode()
    text += b" " * (-len(text) % 8)
    (here / "rt60.safetensors").write_bytes(struct.pack("<Q", len(text)) + text + body)
    shutil.copyfile(whole / "rt60_weights.json", here / "rt60_weights.json")


main()
