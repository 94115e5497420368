#!/usr/bin/env python3
"""Makes the clips with which shipped_gtf_test.cpp tests a shipped network, from the test split of a data set of
earpoint simulate: one second of a voice in a home, the camera's picture and the speaker's true position.

usage: experiments/publish/make_sanity_clips.py DATA FOLDER

FOLDER gets sounds.flac (left ear, right ear, dry voice; 16 kHz, the clips one after the other), views.png
(64 x 64 pixels each, one below the other) and clips.json. One clip per conversation, only of the Asterisk voices,
whose licences allow it. The data of the committed clips: simulate --scenes 120 --conversations 6 --rays 1000
--seed 11.
"""
import json
import math
import os
import subprocess
import sys

import numpy

RATE_HZ = 16000
SPLIT = "test"
CLIPS = 56
VIEW_PX = 64
VOICES = ("asterisk_fr-", "asterisk_it-")


def decoded(path, channels):
    raw = subprocess.run(["ffmpeg", "-loglevel", "error", "-i", path, "-f", "f32le", "-ac",
                          str(channels), "-ar", str(RATE_HZ), "-"], capture_output=True, check=True)
    return numpy.frombuffer(raw.stdout, dtype="<f4").reshape(-1, channels).astype(float)


def loudest_second(voice):
    """A second that begins where the voice does, so that no earlier sound rings into it."""
    if len(voice) <= RATE_HZ:
        return voice
    energy = numpy.cumsum(voice ** 2)
    start = int(numpy.argmax(energy[RATE_HZ:] - energy[:-RATE_HZ]))
    return voice[start:start + RATE_HZ]


def heard(voice, response):
    size = 1 << (len(voice) + len(response)).bit_length()
    spectrum = numpy.fft.rfft(voice, size)
    ears = [numpy.fft.irfft(spectrum * numpy.fft.rfft(response[:, ear], size), size)[:len(voice)]
            for ear in range(2)]
    return numpy.stack(ears, axis=1)


def place(viewpoint, speaker):
    """The mouth's position in the viewpoint's frame (x front, y left, z up); files have y up and look along -z."""
    dx, dy, dz = (s - v for s, v in zip(speaker["location"], viewpoint["location"]))
    front, left, yaw = -dz, -dx, viewpoint["rotation"]
    return [front * math.cos(yaw) + left * math.sin(yaw),
            left * math.cos(yaw) - front * math.sin(yaw), dy]


def pictures(paths):
    """The views, one below the other, as raw RGB."""
    rows = []
    for path in paths:
        raw = subprocess.run(["ffmpeg", "-loglevel", "error", "-i", path, "-vf",
                              f"scale={VIEW_PX}:{VIEW_PX}:flags=area", "-f", "rawvideo", "-pix_fmt",
                              "rgb24", "-"], capture_output=True, check=True)
        rows.append(raw.stdout)
    return b"".join(rows)


def chosen(data):
    """A viewpoint and a speaker in sight of it, one of each conversation."""
    for scene in sorted(os.listdir(os.path.join(data, SPLIT))):
        with open(os.path.join(data, SPLIT, scene, "cleaned_metadata_v3.json")) as file:
            clips = json.load(file)
        for number, clip in enumerate(clips):
            for speaker in clip["speakers"]:
                index = (number + int(scene[-2:])) % len(clip["viewpoints"])
                viewpoint = clip["viewpoints"][index]
                box = viewpoint["bboxes"][str(speaker["id"])]
                if (speaker["speech"] or "").startswith(VOICES) and any(box):
                    yield viewpoint, speaker, box
                    break


def main():
    data, folder = sys.argv[1:3]
    os.makedirs(folder, exist_ok=True)
    clips, sounds, views = [], [], []
    for viewpoint, speaker, box in chosen(data):
        if len(clips) == CLIPS:
            break
        name = speaker["speech"]
        voice_name, chapter, _ = name.split("-")
        voice = loudest_second(decoded(os.path.join(
            data, "speech/test-clean", voice_name, chapter, f"{name}.flac"), 1)[:, 0])
        if len(voice) < RATE_HZ:
            continue
        response = decoded(os.path.join(data, viewpoint["rir"][str(speaker["id"])]), 2)
        # As in the loaders, the common delay of both ears is dropped.
        response = response[numpy.flatnonzero(numpy.abs(response).max(axis=1) > 0)[0]:]
        sounds.append(numpy.concatenate([heard(voice, response), voice[:, None]], axis=1))
        views.append(os.path.join(data, viewpoint["image"]))
        clips.append({"box": [box[2] / 256, box[0] / 256, (box[3] + 1) / 256, (box[1] + 1) / 256],
                      "speaker_m": [round(value, 3) for value in place(viewpoint, speaker)],
                      "voice": name})
    peak = max(float(numpy.abs(sound).max()) for sound in sounds)
    # Twelve bits are enough, and half the file.
    values = numpy.round(numpy.concatenate(sounds) * (0.9 / peak) * 2047).astype("<i2") * 16
    subprocess.run(["ffmpeg", "-loglevel", "error", "-y", "-f", "s16le", "-ar", str(RATE_HZ), "-ac",
                    "3", "-i", "-", "-compression_level", "12",
                    os.path.join(folder, "sounds.flac")], input=values.tobytes(), check=True)
    subprocess.run(["ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24",
                    "-s", f"{VIEW_PX}x{VIEW_PX * len(clips)}", "-i", "-",
                    os.path.join(folder, "views.png")], input=pictures(views), check=True)
    with open(os.path.join(folder, "clips.json"), "w") as file:
        file.write("[" + ",\n ".join(json.dumps(clip) for clip in clips) + "]\n")


if __name__ == "__main__":
    main()
