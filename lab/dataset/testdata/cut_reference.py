#!/usr/bin/env python3
"""Cuts released_loader/ out of the miniature data sets that the released loaders were run on: of each run its first clip
alone, with every fourth sample of what the loader made of it. Needs NumPy.

usage: cut_reference.py FOLDER    (the folder with expected.json and data/)
"""
import json
import shutil
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parents[2] / "experiments"))
import safetensors_file  # noqa: E402

RUNS = ["soundspaces_test", "soundspaces_train", "replay_val"]
SOUNDSPACES = "data/synthetic_dataset/v16"
REPLAY = "data/appen_dataset"
SPEECH = {"test": "data/LibriSpeech-wav/test-clean", "train": "data/LibriSpeech-wav/train-clean-360"}
STEP = 4


class Cut:
    def __init__(self, whole, part):
        self.whole, self.part = whole, part

    def copy(self, name):
        (self.part / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(self.whole / name, self.part / name)

    def json(self, name):
        return json.loads((self.whole / name).read_text())

    def write_json(self, name, value):
        (self.part / name).parent.mkdir(parents=True, exist_ok=True)
        (self.part / name).write_text(json.dumps(value, indent=1) + "\n")


def cut_soundspaces(cut, split, scene):
    metadata = f"{SOUNDSPACES}/{split}/{scene}/cleaned_metadata_v3.json"
    clip = cut.json(metadata)[0]
    cut.write_json(metadata, [clip])
    for viewpoint in clip["viewpoints"]:
        for name in [viewpoint["image"], *viewpoint["rir"].values()]:
            cut.copy(name)
    for speaker in clip["speakers"]:
        if speaker["speech"]:
            book, chapter, _ = speaker["speech"].split("-")
            cut.copy(f"{SPEECH[split]}/{book}/{chapter}/{speaker['speech']}.flac")


def cut_replay(cut, folder):
    views = cut.json(f"{REPLAY}/v3/metadata_v2.json")[folder]
    cut.write_json(f"{REPLAY}/v3/metadata_v2.json", {folder: views})
    cut.copy(f"{REPLAY}/camera_positions_fixed_rotation.json")
    for view in views:
        for kind in [".png", ".wav", ".npy"]:
            cut.copy(f"{folder}/{Path(view).stem}{kind}")


def main():
    cut = Cut(Path(sys.argv[1]), HERE / "released_loader")
    shutil.rmtree(cut.part, ignore_errors=True)
    released = cut.json("expected.json")["runs"]
    runs = {}
    for run in RUNS:
        first = released[run]["order"][0]
        runs[run] = {"numpy_seed": released[run]["numpy_seed"], "items": released[run]["items"][:1], "order": [first]}
        if run == "replay_val":
            cut_replay(cut, first)
        else:
            cut_soundspaces(cut, run.removeprefix("soundspaces_"), first[0])
        tensors = safetensors_file.read_arrays(cut.whole / f"expected_{run}.safetensors")
        kept = {name: values for name, values in tensors.items() if name.startswith("0/")}
        for name in ["0/src_wav", "0/tgt_wav"]:
            kept[name] = kept[name][:, ::STEP]
        safetensors_file.write_arrays(cut.part / f"expected_{run}.safetensors", kept)
    cut.write_json("expected.json", {"runs": runs})


main()
