"""Compares two sounds: raw 32-bit floats, or WAV files of them. They must not be silent.

usage: compare.py A B TOLERANCE   B may be -, which compares nothing
"""
import array
import math
import struct
import sys


def samples_of(path):
    with open(path, "rb") as file:
        data = file.read()
    if data[:4] == b"RIFF":
        place = 12
        while data[place:place + 4] != b"data":
            place += 8 + struct.unpack_from("<I", data, place + 4)[0]
        data = data[place + 8:place + 8 + struct.unpack_from("<I", data, place + 4)[0]]
    samples = array.array("f")
    samples.frombytes(data)
    return samples


a_path, b_path, tolerance = sys.argv[1:]
a = samples_of(a_path)
if not all(map(math.isfinite, a)):
    sys.exit(f"{a_path} has samples that are no numbers")
if not max(map(abs, a)) > 1e-3:
    sys.exit(f"{a_path} is silent")
if b_path != "-":
    b = samples_of(b_path)
    if len(a) != len(b):
        sys.exit(f"{a_path} has {len(a)} samples, {b_path} {len(b)}")
    differences = [abs(x - y) for x, y in zip(a, b)]
    if not all(difference <= float(tolerance) for difference in differences):
        sys.exit(f"{a_path} differs from {b_path} by up to {max(differences)}")
