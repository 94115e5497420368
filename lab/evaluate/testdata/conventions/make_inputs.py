#!/usr/bin/env python3
"""Makes the sounds on which metric conventions are compared with released code.

Usage: make_inputs.py EARPOINT

EARPOINT is the built program. Impulse responses are traced in a box of 6 x 4 x 3 m with a fixed seed; the
estimate stands half a metre beside the reference in a more absorbent room, as a prediction might. The speech
is the first second of examples/clip.mp4 and what `render --model dsp` makes of it at another position.
All are stored as 16-bit WAV files beside this script. Needs ffmpeg and python3-scipy.
"""
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from scipy.io import wavfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[3]
SECONDS = 0.4


def run(*command):
    subprocess.run([str(part) for part in command], check=True, stdout=subprocess.DEVNULL)


def decoded(path, rate, channels):
    """A sound as float32 [samples, channels]."""
    raw = subprocess.run(["ffmpeg", "-v", "error", "-i", str(path), "-ac", str(channels), "-ar", str(rate),
                          "-f", "f32le", "-"], check=True, capture_output=True).stdout
    return np.frombuffer(raw, "<f4").reshape(-1, channels)


def store(name, rate, sound):
    wavfile.write(HERE / name, rate, np.round(32767.0 * np.clip(sound, -1.0, 1.0)).astype(np.int16))


def trace(earpoint, folder, name, absorption, listener, rate, binaural):
    out = folder / f"{name}.wav"
    extra = [] if binaural else ["--mono"]
    run(earpoint, "trace", "--shoebox", f"6,4,3,absorption={absorption},scattering=0.3", "--source", "1.5,1.2,1.5",
        "--listener", listener, "--rate", rate, "--duration", SECONDS, "--rays", 20000, "--seed", 1,
        *extra, "-o", out)
    return decoded(out, rate, 2 if binaural else 1)


def main():
    earpoint = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for kind, rate, binaural in (("rir", 48000, False), ("brir", 22050, True)):
            reference = trace(earpoint, folder, kind + "-a", 0.25, "4.2,2.6,1.6", rate, binaural)
            estimate = trace(earpoint, folder, kind + "-b", 0.35, "4.2,2.1,1.6", rate, binaural)
            scale = 0.7 / np.abs(reference).max()
            store(kind + "_reference.wav", rate, scale * reference[:, :1 + binaural])
            store(kind + "_estimate.wav", rate, scale * estimate[:, :1 + binaural])
        there = folder / "there.wav"
        clip = ROOT / "examples" / "clip.mp4"
        run(earpoint, "render", clip, "--model", "dsp", "--speaker", "2,0,0", "--translate", "1,-0.5,0", "--yaw", 90,
            "-o", there)
        store("speech_reference.wav", 22050, decoded(clip, 22050, 2)[:22050])
        store("speech_estimate.wav", 22050, decoded(there, 22050, 2)[:22050])


main()
