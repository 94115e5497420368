# %% [markdown]
# # Earpoint from Python
# Hear the bundled clip from another place, measure the error, walk through it live, trace a room. The cells (`# %%`) run
# one by one in editors that know them, or all at once: `python3 examples/python/tutorial.py`.

# %% The clip: one picture and the sound of both ears. FFmpeg reads it; any other reader does too.
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import earpoint

EXAMPLES = Path(__file__).resolve().parent.parent
RATE = 48000


def sound_of(file):
    """Left and right ear, float32 [2, samples]."""
    command = ["ffmpeg", "-v", "error", "-i", str(file), "-ac", "2", "-ar", str(RATE), "-f", "f32le", "-"]
    samples = np.frombuffer(subprocess.run(command, check=True, capture_output=True).stdout, np.float32)
    return np.ascontiguousarray(samples.reshape(-1, 2).T)


def picture_of(file):
    """The first frame, uint8 [height, width, 3]."""
    command = ["ffmpeg", "-v", "error", "-i", str(file), "-frames:v", "1", "-f", "image2pipe", "-c:v", "ppm", "-"]
    data = subprocess.run(command, check=True, capture_output=True).stdout
    width, height = map(int, data.split(maxsplit=3)[1:3])
    return np.frombuffer(data[len(data) - 3 * width * height:], np.uint8).reshape(height, width, 3)


here = sound_of(EXAMPLES / "clip.mp4")
frame = picture_of(EXAMPLES / "clip.mp4")
print("sound", here.shape, "picture", frame.shape)

# %% The sound 1.5 m ahead and 0.2 m to the right of the camera, the head turned 45 degrees to the right.
speaker = (1.89, 0.196, 0.147)  # metres from the camera: front, left, up
there = earpoint.render(here, RATE, frame, speaker=speaker, translate=(1.49, -0.2, 0.0), yaw=-45)

# %% How good is it? The true sound at that place lies beside the clip.
truth = sound_of(EXAMPLES / "truth-speaker-on-the-left.flac")
samples = min(truth.shape[1], there.shape[1])
rendered = earpoint.metrics(truth[:, :samples], there[:, :samples], RATE)
unchanged = earpoint.metrics(truth[:, :samples], here[:, :samples], RATE)
for name in ("mag", "lre_db", "rte_s"):
    print(f"{name:8} rendered {rendered[name]:6.3f}   unchanged {unchanged[name]:6.3f}")
assert rendered["lre_db"] < unchanged["lre_db"]

# %% Several earpoints: keep the renderer, which has read its weights.
renderer = earpoint.Renderer("gtf")
for yaw in (0, 90, 180):
    ears = renderer.render(here, RATE, image=frame, speaker=speaker, translate=(1, 0, 0), yaw=yaw)
    left, right = np.sqrt(np.mean(ears**2, axis=1))
    print(f"yaw {yaw:3}: left ear {20 * np.log10(left / right):+.1f} dB louder than the right")

# %% Live, in blocks of 10 ms: the engine reads and writes the arrays where they are.
stream = renderer.stream(RATE)
stream.see(frame, speaker_box=(0.383, 0.348, 0.513, 1.0))
block, out = 480, np.empty((2, 480), np.float32)
heard = []
for start in range(0, RATE, block):
    stream.move_to((start / RATE, 0, 0))  # a walk of a metre in a second
    heard.append(stream.process(here[:, start:start + block], out).copy())
print("live", np.concatenate(heard, axis=1).shape, "latency", stream.latency, "samples, speaker at", stream.speaker)

# %% No speaker given: located by picture and sound.
found = earpoint.locate(EXAMPLES / "clip.mp4", three_d=True)["speaker"]
print(f"speaker {found['azimuth_deg']:.0f} degrees to the left, {found['distance_m']:.1f} m away")

# %% A room's binaural response, and how it decays.
room = earpoint.Scene.box((6, 5, 3), absorption=0.2, scattering=0.5)
response = earpoint.trace(room, source=(1, 2, 1.5), listener=(3, 2, 1.5), yaw=180, rate=RATE)
print("T30 of the left ear", response.t30[0], "s, EDT", response.edt[0], "s, C50", response.c50[0], "dB")

# %% Continue the training of shipped weights in PyTorch, and render with the result.
try:
    import torch

    import earpoint.torch
except ImportError:
    print("PyTorch is missing: the rest is left out")
    sys.exit()

network = earpoint.torch.vigas("vigas")
random = torch.Generator().manual_seed(1)
# Stand-ins for what a PairDataset gives: the picture is the clip's; poses and boxes are drawn, and the target is the source
# with its ears exchanged.
batch = {entry["name"]: torch.rand(1, entry["width"], generator=random) for entry in network.description["inputs"]
         if entry["name"] != "visual_feat"}
batch["src_rgb"] = torch.from_numpy(frame.copy()).permute(2, 0, 1)[None]
source = 0.1 * torch.randn(1, 2, 16000, generator=random)
target = source.flip(1)
network.train()
optimizer = torch.optim.Adam(network.parameters(), lr=1e-4)
for step in range(3):
    optimizer.zero_grad()
    loss = earpoint.torch.magnitude_loss(network(source, **batch), target)
    loss.backward()
    optimizer.step()
    print(f"step {step}: loss {loss.item():.4f}")
with tempfile.TemporaryDirectory() as folder:
    mine = os.path.join(folder, "mine.safetensors")
    network.save(mine)
    ears = earpoint.render(here[:, :RATE], RATE, frame, speaker_box=(0.383, 0.348, 0.513, 1.0), yaw=90, model=mine)
    print("rendered by it", ears.shape)
# For a data set: torch.utils.data.DataLoader(earpoint.torch.PairDataset(folder, "train", network=network, random=True))
