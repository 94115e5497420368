"""The Python package, installed from its wheel: renders a sound as a whole and live.

usage: wheel.py IN.raw WHOLE.raw LIVE.raw   (32-bit floats, two ears, interleaved, 48 kHz)
"""
import sys

import numpy as np

import earpoint

SPEAKER, PLACE, YAW = (2, 0.25, 0.125), (1, -0.5, 0), 90

given, whole, live = sys.argv[1:]
sound = np.ascontiguousarray(np.fromfile(given, "<f4").reshape(-1, 2).T)
earpoint.render(sound, 48000, speaker=SPEAKER, translate=PLACE, yaw=YAW).T.tofile(whole)
stream = earpoint.Renderer("gtf").stream(48000)
stream.place_speaker(SPEAKER)
stream.move_to(PLACE, yaw=YAW)
for at in range(0, sound.shape[1], 480):
    stream.process(sound[:, at:at + 480], sound[:, at:at + 480])
np.ascontiguousarray(sound.T).tofile(live)
assert earpoint.trace(earpoint.Scene.box((6, 4, 3), 0.3), (1, 2, 1.5), (4, 1, 1.5), rays=200).t30[0] > 0.1
