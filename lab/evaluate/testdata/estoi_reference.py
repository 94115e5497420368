#!/usr/bin/env python3
"""Prints what pystoi (0.4.1, MIT) measures of the sounds of speech_metrics_test.cpp, which holds the numbers.

usage: pip install pystoi; estoi_reference.py
"""
import numpy as np
from pystoi import stoi


def noise(samples, seed):
    """Uniform in [-1, 1): the generator of Numerical Recipes, which a few lines write anywhere."""
    values, state = np.empty(samples), seed
    for i in range(samples):
        state = (1664525 * state + 1013904223) % 2**32
        values[i] = state / 2**31 - 1
    return values


def syllables(rate, seconds):
    """Harmonics of 130 to 190 Hz in syllables of different lengths and vowels, with pauses."""
    t = np.arange(int(rate * seconds)) / rate
    phase = 2 * np.pi * 160 * t + 6 * np.sin(2 * np.pi * 0.8 * t)
    loud = np.maximum(0, np.sin(2 * np.pi * 2.2 * t) + 0.4 * np.sin(2 * np.pi * 3.7 * t))
    sound = np.zeros_like(t)
    for h in range(1, 26):
        vowel = 1 + 0.9 * np.sin(0.6 * h + 2 * np.pi * 1.3 * t)
        sound += vowel * np.sin(h * phase) / h
    return 0.1 * loud * sound


for rate in (10000, 16000):
    clean = syllables(rate, 3.0)
    for size in (0.0, 0.02, 0.1, 0.5):
        noisy = clean + size * noise(len(clean), 7)
        print(rate, size, "%.5f" % stoi(clean, noisy, rate, extended=True))
    echo = clean.copy()
    for delay, gain in ((0.05, 0.7), (0.13, 0.5), (0.21, 0.4)):
        samples = int(delay * rate)
        echo[samples:] += gain * clean[:-samples]
    print(rate, "echo", "%.5f" % stoi(clean, echo, rate, extended=True))
