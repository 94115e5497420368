#!/usr/bin/env python3
"""Errors of a gtf network outside of its training data: other voices, far targets, targets out of the speaker's
sight, wrong boxes and pictures, two people at once, music and noise. Prints JSON.

usage: experiments/measure/generalisation.py EARPOINT DATA GTF.safetensors SCRATCH [--every N]

DATA is a data set of earpoint simulate whose test split the network has not seen; SCRATCH gets altered copies
of it (metadata, sounds; the rest are links). --every N takes every Nth pair. Each case is a run of `earpoint
evaluate`, so that the measures and their intervals are those of the other tables.
"""
import argparse
import copy
import json
import math
import os
import random
import shutil
import subprocess
import sys
import wave

import numpy

SPLIT = "test"
SPEECH = "speech/test-clean"
METADATA = "cleaned_metadata_v3.json"
RATE_HZ = 16000
PICTURE_PX = 256
METRICS = ("mag", "lre_db", "level_db", "itd_us", "c50_db")


class Data:
    """The test split: its pairs, the metadata of its scenes, its folder."""

    def __init__(self, folder, every):
        self.folder = folder
        with open(os.path.join(folder, f"pairs-{SPLIT}.json")) as file:
            self.list = json.load(file)
        self.pairs = self.list["pairs"][::every]
        self.scenes = {}
        for scene in sorted({pair["scene"] for pair in self.pairs}):
            with open(os.path.join(folder, SPLIT, scene, METADATA)) as file:
                self.scenes[scene] = json.load(file)

    def clip(self, pair):
        return self.scenes[pair["scene"]][pair["clip"]]

    def speaker(self, pair):
        return self.clip(pair)["speakers"][pair["speaker"]]

    def viewpoint(self, pair, which):
        return self.clip(pair)["viewpoints"][pair[which]]

    def sees(self, pair, which):
        return any(self.viewpoint(pair, which)["bboxes"][str(pair["speaker"])])

    def move_m(self, pair):
        return math.dist(self.viewpoint(pair, "source")["location"],
                         self.viewpoint(pair, "target")["location"])


def evaluate(arguments, data_folder, pairs, listed, scratch):
    """Rows of `earpoint evaluate` on those pairs, by method."""
    path = os.path.join(scratch, "pairs.json")
    with open(path, "w") as file:
        json.dump({**listed, "pairs": pairs}, file)
    run = subprocess.run(
        [arguments.earpoint, "evaluate", "--data", data_folder, "--split", SPLIT, "--pairs", path,
         "--methods", f"input,dsp,gtf={arguments.network}", "--json", "--quiet"],
        capture_output=True, text=True)
    if run.returncode != 0:
        sys.exit(f"generalisation: {run.stderr.strip()}")
    return json.loads(run.stdout)


def altered(data, scratch, name, change_viewpoint, keep_speech=True):
    """A copy of the data set, with links for everything but its metadata.

    change_viewpoint(scene, clip number, viewpoint number, viewpoint) alters a viewpoint in place.
    """
    folder = os.path.join(scratch, name)
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(os.path.join(folder, SPLIT))
    source = os.path.abspath(data.folder)
    os.symlink(os.path.join(source, "dataset.json"), os.path.join(folder, "dataset.json"))
    if keep_speech:
        os.symlink(os.path.join(source, "speech"), os.path.join(folder, "speech"))
    for scene, clips in data.scenes.items():
        place = os.path.join(folder, SPLIT, scene)
        os.makedirs(place)
        changed = copy.deepcopy(clips)
        for number, clip in enumerate(changed):
            os.symlink(os.path.join(source, SPLIT, scene, str(number)),
                       os.path.join(place, str(number)))
            for index, viewpoint in enumerate(clip["viewpoints"]):
                change_viewpoint(scene, number, index, viewpoint)
        with open(os.path.join(place, METADATA), "w") as file:
            json.dump(changed, file)
    return folder


def unchanged(*_):
    pass


def shift_boxes(scene, number, index, viewpoint):
    """Shifts boxes by a tenth of the picture to the right, or to the left if that would leave it."""
    step = PICTURE_PX // 10
    for box in viewpoint["bboxes"].values():
        if any(box):
            by = step if box[3] + step < PICTURE_PX else -step
            box[2], box[3] = max(box[2] + by, 0), max(box[3] + by, 1)


def swap_boxes(scene, number, index, viewpoint):
    boxes = viewpoint["bboxes"]
    boxes["0"], boxes["1"] = boxes["1"], boxes["0"]


def drop_boxes(scene, number, index, viewpoint):
    for box in viewpoint["bboxes"].values():
        box[:] = [0, 0, 0, 0]


def swap_pictures(data):
    """Gives every viewpoint the picture of a viewpoint in the next home."""
    names = list(data.scenes)
    following = dict(zip(names, names[1:] + names[:1]))

    def change(scene, number, index, viewpoint):
        others = data.scenes[following[scene]]
        viewpoint["image"] = others[number % len(others)]["viewpoints"][index]["image"]
    return change


def decoded(path, channels):
    """A sound file as [samples][channels], float."""
    raw = subprocess.run(["ffmpeg", "-loglevel", "error", "-i", path, "-f", "f32le", "-ac",
                          str(channels), "-ar", str(RATE_HZ), "-"], capture_output=True, check=True)
    return numpy.frombuffer(raw.stdout, dtype="<f4").reshape(-1, channels).astype(float)


def write_wave(path, sound):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    values = numpy.clip(numpy.round(sound * 32767), -32768, 32767).astype("<i2")
    with wave.open(path, "wb") as file:
        file.setnchannels(values.shape[1] if values.ndim == 2 else 1)
        file.setsampwidth(2)
        file.setframerate(RATE_HZ)
        file.writeframes(values.tobytes())


def speech_path(folder, utterance):
    speaker, chapter, _ = utterance.split("-")
    return os.path.join(folder, SPEECH, speaker, chapter, f"{utterance}.flac")


def plucked_chords(samples, rng):
    """Karplus-Strong strings, a chord every 0.4 s."""
    sound = numpy.zeros(samples)
    for start in range(0, samples, int(0.4 * RATE_HZ)):
        root = rng.choice([110.0, 131.0, 147.0, 165.0, 196.0])
        for ratio in (1.0, 1.26, 1.5, 2.0):
            period = int(RATE_HZ / (root * ratio))
            string = numpy.array([rng.uniform(-1, 1) for _ in range(period)])
            rest = samples - start
            played = []
            while len(played) * period < rest:
                played.append(string)
                string = 0.498 * (string + numpy.roll(string, 1))
            sound[start:] += numpy.concatenate(played)[:rest]
    return sound


def noise_bursts(samples, rng):
    """Pink noise that comes and goes four times a second."""
    white = numpy.random.default_rng(rng.getrandbits(32)).normal(size=samples)
    spectrum = numpy.fft.rfft(white)
    pink = numpy.fft.irfft(spectrum / numpy.sqrt(numpy.arange(1, len(spectrum) + 1)), samples)
    return pink * (0.5 + 0.5 * numpy.sin(2 * math.pi * 4 * numpy.arange(samples) / RATE_HZ)) ** 2


def other_sounds(data, scratch, name, make):
    """The same conversations with every utterance replaced, length and level kept."""
    folder = altered(data, scratch, name, unchanged, keep_speech=False)
    for utterance in sorted({data.speaker(pair)["speech"] for pair in data.pairs}):
        spoken = decoded(speech_path(data.folder, utterance), 1)[:, 0]
        sound = make(len(spoken), random.Random(utterance))
        level = numpy.sqrt(numpy.mean(spoken ** 2) / numpy.mean(sound ** 2))
        write_wave(speech_path(folder, utterance), sound * level)
    return folder


def two_at_once(data, scratch):
    """Both people talk: responses that are the mixture itself, and an utterance that is one click."""
    seconds, lead = 2, 1600
    sounds = {}

    def change(scene, number, index, viewpoint):
        clip = data.scenes[scene][number]
        mixed = numpy.zeros((seconds * RATE_HZ, 2))
        for speaker in clip["speakers"]:
            if not speaker["speech"]:
                continue
            spoken = decoded(speech_path(data.folder, speaker["speech"]), 1)[:, 0]
            spoken = numpy.resize(spoken, seconds * RATE_HZ)
            response = decoded(
                os.path.join(data.folder, viewpoint["rir"][str(speaker["id"])]), 2)
            size = 1 << (len(spoken) + len(response)).bit_length()
            for ear in range(2):
                heard = numpy.fft.irfft(numpy.fft.rfft(spoken, size)
                                        * numpy.fft.rfft(response[:, ear], size), size)
                mixed[:, ear] += heard[:seconds * RATE_HZ]
        path = f"mixtures/{scene}-{number}-{index}.wav"
        sounds[path] = mixed
        for who in viewpoint["rir"]:
            viewpoint["rir"][who] = path

    folder = altered(data, scratch, "two-at-once", change, keep_speech=False)
    for path, sound in sounds.items():
        write_wave(os.path.join(folder, path), 0.5 * sound)
    click = numpy.zeros(3 * RATE_HZ)
    click[lead] = 1.0
    for scene, clips in data.scenes.items():
        for clip in clips:
            for speaker in clip["speakers"]:
                if speaker["speech"]:
                    write_wave(speech_path(folder, speaker["speech"]), click)
    pairs = [{**pair, "window_start": lead + RATE_HZ // 2} for pair in data.pairs]
    return folder, pairs


def cases(data, scratch):
    """Yields (group, case, folder, pairs, whether C50 is meaningful)."""
    plain = data.folder
    yield "all", "all pairs", plain, data.pairs, True
    voices = sorted({data.speaker(pair)["speech"].split("-")[0] for pair in data.pairs})
    for voice in voices:
        yield "voice", voice, plain, [pair for pair in data.pairs
                                      if data.speaker(pair)["speech"].startswith(voice + "-")], True
    for least in range(5):
        yield "move", f"{least} to {least + 1} m", plain, [
            pair for pair in data.pairs if least <= data.move_m(pair) < least + 1], True
    for word, source, target in (("seen from both", True, True),
                                 ("out of the target's sight", True, False),
                                 ("out of the source's sight", False, True)):
        yield "sight", word, plain, [
            pair for pair in data.pairs
            if (data.sees(pair, "source"), data.sees(pair, "target")) == (source, target)], True
    for case, change in (("shifted by a tenth of the picture", shift_boxes),
                         ("the other person's", swap_boxes), ("none", drop_boxes)):
        seen = [pair for pair in data.pairs if data.sees(pair, "source")]
        yield "box", "right", plain, seen, True
        yield "box", case, altered(data, scratch, "boxes", change), seen, True
    yield "picture", "of another home", altered(data, scratch, "pictures",
                                                swap_pictures(data)), data.pairs, True
    yield "sound", "plucked chords", other_sounds(data, scratch, "chords",
                                                  plucked_chords), data.pairs, True
    yield "sound", "bursts of noise", other_sounds(data, scratch, "noise",
                                                   noise_bursts), data.pairs, True
    folder, pairs = two_at_once(data, scratch)
    yield "sound", "two people at once", folder, pairs, False


def row_of(group, case, result, has_dry=True):
    """The table's row for one run of `earpoint evaluate`."""
    row = {"group": group, "case": case, "clips": result["clips"], "methods": {}}
    for method in result["rows"]:
        row["methods"][method["method"]] = {
            name: {"mean": method[name]["mean"],
                   "ratio": (method[name].get("ratio") or {}).get("value"),
                   "low": (method[name].get("ratio") or {}).get("low"),
                   "high": (method[name].get("ratio") or {}).get("high")}
            for name in METRICS if name in method and (has_dry or name != "c50_db")}
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("earpoint")
    parser.add_argument("data")
    parser.add_argument("network")
    parser.add_argument("scratch")
    parser.add_argument("--every", type=int, default=1)
    arguments = parser.parse_args()
    os.makedirs(arguments.scratch, exist_ok=True)
    data = Data(arguments.data, arguments.every)
    rows, done = [], set()
    for group, case, folder, pairs, has_dry in cases(data, arguments.scratch):
        if (group, case) in done or not pairs:
            continue
        done.add((group, case))
        result = evaluate(arguments, folder, pairs, data.list, arguments.scratch)
        row = row_of(group, case, result, has_dry)
        rows.append(row)
        print(f"{group}: {case}, {result['clips']} clips", file=sys.stderr)
    json.dump({"rows": rows}, sys.stdout, indent=1)
    print()


if __name__ == "__main__":
    main()
