#!/usr/bin/env python3
"""Writes stft.safetensors: a noise of two channels, and its transform by NumPy in double precision, frame by frame as the
released code frames it. Needs NumPy.
"""
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parents[2] / "experiments"))
import safetensors_file  # noqa: E402

SAMPLES = 2000


def main():
    sound = np.random.default_rng(1).normal(0, 0.1, (2, SAMPLES)).astype(np.float32)
    window = np.zeros(512)
    window[56:456] = 0.54 - 0.46 * np.cos(2 * np.pi * np.arange(400) / 400)
    padded = np.pad(sound.astype(float), [(0, 0), (256, 256)])
    frames = [padded[:, 160 * k : 160 * k + 512] for k in range(1 + SAMPLES // 160)]
    # [channels][bins][frames][real and imaginary part], as PyTorch has it.
    spectra = np.moveaxis(np.fft.rfft(np.array(frames) * window), 0, 2)
    parts = np.stack([spectra.real, spectra.imag], axis=-1).astype(np.float32)
    safetensors_file.write_arrays(HERE / "stft.safetensors", {"tgt": sound[None], "stft0": parts})


main()
