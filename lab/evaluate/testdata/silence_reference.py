#!/usr/bin/env python3
"""Writes silence.json: the released evaluation's metrics where a channel is silent, computed in double precision from
their description (docs/released-code.md, "Metrics") for the pair in metrics.safetensors. Checks itself against metrics.json,
which is the released evaluation's own. Needs NumPy.
"""
import json
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parents[2] / "experiments"))
import safetensors_file  # noqa: E402


def stft(channel):
    window = np.zeros(512)
    window[56:456] = 0.54 - 0.46 * np.cos(2 * np.pi * np.arange(400) / 400)
    padded = np.pad(channel, 256)
    frames = 1 + len(channel) // 160
    return np.fft.rfft([window * padded[160 * k : 160 * k + 512] for k in range(frames)])


def delay(signal, reference):
    """Samples, by the phase transform; a silent channel has no phase and counts as the longest."""
    n = len(signal) + len(reference)
    cross = np.fft.rfft(signal, n) * np.conj(np.fft.rfft(reference, n))
    if not np.all(np.abs(cross) > 0):
        return 50.0
    correlation = np.abs(np.fft.irfft(cross / np.abs(cross), 16 * n))
    lags = np.concatenate([correlation[-8 * n :], correlation[: 8 * n + 1]])
    return min(abs(int(np.argmax(lags)) - 8 * n) / 16, 50.0)


def level_difference_db(sound):
    left, right = np.sum(sound**2, axis=1)
    return 10 * np.log10(left / (right + 1e-5)) if left > 0 else -np.inf


def metrics(target, estimate):
    spectra = [(stft(t), stft(e)) for t, e in zip(target, estimate)]
    difference_db = abs(level_difference_db(estimate) - level_difference_db(target))
    return {
        "l2_distance": [np.mean((target - estimate) ** 2)],
        "stft_distance": [sum(np.sqrt(np.sum(np.abs(t - e) ** 2)) for t, e in spectra)],
        "mag_distance": [sum(np.mean(np.abs(np.abs(t) - np.abs(e))) for t, e in spectra)],
        "lr_ratio": [difference_db if np.isfinite(difference_db) else "inf"],
        "delay": np.mean([delay(e, t) for t, e in zip(target, estimate)]),
    }


def main():
    tensors = safetensors_file.read_arrays(HERE / "metrics.safetensors")
    target, estimate = (tensors[name][0].astype(float) for name in ["tgt", "pred"])
    released = json.loads((HERE / "metrics.json").read_text())["per_pair"][0]
    for name, value in metrics(target, estimate).items():
        assert np.allclose(value, released[name], rtol=1e-5, atol=2e-6), (name, value, released[name])

    silence = np.zeros_like(target)
    cases = {
        "silent_right_pred": metrics(target, estimate * [[1.0], [0.0]]),
        "silent_pred": metrics(target, silence),
        "silent_tgt": metrics(silence, estimate),
    }
    (HERE / "silence.json").write_text(json.dumps({"edge": cases}, indent=1) + "\n")


main()
