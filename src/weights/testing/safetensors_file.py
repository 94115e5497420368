"""Reads and writes safetensors files, for the scripts that make the tests' reference data."""
import json
import struct
from pathlib import Path

import numpy as np

TYPES = {"F64": "<f8", "I64": "<i8", "F32": "<f4", "U8": "|u1"}


def read(path):
    """@return the tensors as arrays, by name"""
    data = Path(path).read_bytes()
    (length,) = struct.unpack("<Q", data[:8])
    header = json.loads(data[8 : 8 + length])
    header.pop("__metadata__", None)
    tensors = {}
    for name, entry in header.items():
        begin, end = (8 + length + offset for offset in entry["data_offsets"])
        tensors[name] = np.frombuffer(data[begin:end], TYPES[entry["dtype"]]).reshape(entry["shape"])
    return tensors


def write(path, tensors):
    """The widest numbers come first, so that all lie at multiples of their size."""
    names = {np.dtype(kind): name for name, kind in TYPES.items()}
    header, body = {}, b""
    for name, values in sorted(tensors.items(), key=lambda item: -item[1].dtype.itemsize):
        data = np.ascontiguousarray(values).tobytes()
        header[name] = {
            "dtype": names[values.dtype],
            "shape": list(values.shape),
            "data_offsets": [len(body), len(body) + len(data)],
        }
        body += data
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 8)
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    Path(path).write_bytes(struct.pack("<Q", len(text)) + text + body)
