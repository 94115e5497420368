"""Reads and writes safetensors files without any package; docs/formats.md describes the format."""
import json
import struct
from pathlib import Path

BYTES = {"F64": 8, "I64": 8, "U64": 8, "F32": 4, "I32": 4, "U32": 4, "F16": 2, "BF16": 2, "I16": 2,
         "U16": 2, "I8": 1, "U8": 1, "BOOL": 1}


def read(path):
    """Tensors by name, each with its type, shape and bytes; and the metadata."""
    data = Path(path).read_bytes()
    (length,) = struct.unpack("<Q", data[:8])
    header = json.loads(data[8:8 + length])
    metadata = header.pop("__metadata__", {})
    tensors = {}
    for name, entry in header.items():
        begin, end = (8 + length + offset for offset in entry["data_offsets"])
        tensors[name] = entry["dtype"], entry["shape"], data[begin:end]
    return tensors, metadata


def write(path, tensors, metadata=None):
    """Tensors and metadata as read() gives them; the larger types first, so that all are aligned."""
    header, body = {"__metadata__": metadata} if metadata else {}, b""
    for name, (dtype, shape, data) in sorted(tensors.items(), key=lambda t: -BYTES[t[1][0]]):
        header[name] = {"dtype": dtype, "shape": shape, "data_offsets": [len(body), len(body) + len(data)]}
        body += data
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 8)
    Path(path).write_bytes(struct.pack("<Q", len(text)) + text + body)


NUMPY = {"F64": "<f8", "I64": "<i8", "F32": "<f4", "I32": "<i4", "U8": "|u1"}


def read_arrays(path):
    """Tensors by name as NumPy arrays."""
    import numpy as np
    tensors, _ = read(path)
    return {name: np.frombuffer(data, NUMPY[dtype]).reshape(shape) for name, (dtype, shape, data) in tensors.items()}


def write_arrays(path, arrays):
    """Writes NumPy arrays by name; makes the folder if it is missing."""
    import numpy as np
    names = {np.dtype(kind): name for name, kind in NUMPY.items()}
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    write(path, {name: (names[values.dtype], list(values.shape), np.ascontiguousarray(values).tobytes())
                 for name, values in arrays.items()})
