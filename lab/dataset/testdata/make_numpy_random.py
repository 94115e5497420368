#!/usr/bin/env python3
"""Writes numpy_random.json: what NumPy's old generator of seed 0 draws, as the released loader uses it. Needs NumPy."""
import json
from pathlib import Path

import numpy as np


def main():
    np.random.seed(0)
    operations = []
    for n in [5, 1, 10, 4, 3, 2, 257, 30] * 4:
        operations.append(["permutation", n, np.random.permutation(n).tolist()])
        operations.append(["index", n, int(np.random.choice(n))])
        # Of 2**n and one more, between which the number of bits that are drawn changes.
        for most in [2 ** (n % 17), 2 ** (n % 17) + 1]:
            operations.append(["index", most, int(np.random.randint(most))])
    rows = ",\n".join(json.dumps(operation) for operation in operations)
    text = f'{{"seed": 0, "ops": [\n{rows}\n]}}\n'
    (Path(__file__).parent / "numpy_random.json").write_text(text)


main()
