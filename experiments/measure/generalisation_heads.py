#!/usr/bin/env python3
"""Errors of a gtf network with the ears of another head, and in an imported building. Prints JSON.

usage: experiments/measure/generalisation_heads.py EARPOINT KEMAR FABIAN IMPORTED GTF.safetensors SCRATCH

KEMAR and FABIAN are test splits of the same homes and conversations, which differ only in the head; IMPORTED
is that of a model which `earpoint simulate --scene` has read. SCRATCH gets the pairs whose source and target
have different heads.
"""
import argparse
import copy
import json
import os
import shutil
import sys

from generalisation import METADATA, SPLIT, Data, evaluate, row_of


def with_both_heads(kemar, fabian, scratch):
    """A data set whose viewpoints come twice: first with KEMAR's ears, then with FABIAN's.

    @return its folder and how many viewpoints come before FABIAN's
    """
    folder = os.path.join(scratch, "both-heads")
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    for name in ("dataset.json", "speech"):
        os.symlink(os.path.abspath(os.path.join(kemar.folder, name)), os.path.join(folder, name))
    os.symlink(os.path.abspath(fabian.folder), os.path.join(folder, "fabian"))
    count = 0
    for scene, clips in kemar.scenes.items():
        place = os.path.join(folder, SPLIT, scene)
        os.makedirs(place)
        both = copy.deepcopy(clips)
        for number, clip in enumerate(both):
            os.symlink(os.path.abspath(os.path.join(kemar.folder, SPLIT, scene, str(number))),
                       os.path.join(place, str(number)))
            count = len(clip["viewpoints"])
            others = copy.deepcopy(fabian.scenes[scene][number]["viewpoints"])
            for ours, other in zip(clip["viewpoints"], others):
                if ours["location"] != other["location"]:
                    sys.exit(f"{fabian.folder}: {scene} is not that of {kemar.folder}")
                other["image"] = os.path.join("fabian", other["image"])
                other["rir"] = {who: os.path.join("fabian", path) for who, path in other["rir"].items()}
            clip["viewpoints"] += others
        with open(os.path.join(place, METADATA), "w") as file:
            json.dump(both, file)
    return folder, count


def cases(kemar, fabian, imported, scratch):
    """(group, case, data set, folder, pairs)"""
    folder, count = with_both_heads(kemar, fabian, scratch)
    for case, source, target in (("KEMAR, as in training", 0, 0), ("FABIAN at the source", count, 0),
                                 ("FABIAN at the target", 0, count), ("FABIAN at both", count, count)):
        yield "head", case, kemar, folder, [
            {**pair, "source": pair["source"] + source, "target": pair["target"] + target}
            for pair in kemar.pairs]
    yield "building", "an imported model", imported, imported.folder, imported.pairs


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    for name in ("earpoint", "kemar", "fabian", "imported", "network", "scratch"):
        parser.add_argument(name)
    arguments = parser.parse_args()
    os.makedirs(arguments.scratch, exist_ok=True)
    data = [Data(folder, 1) for folder in (arguments.kemar, arguments.fabian, arguments.imported)]
    rows = []
    for group, case, kind, folder, pairs in cases(*data, arguments.scratch):
        result = evaluate(arguments, folder, pairs, kind.list, arguments.scratch)
        rows.append(row_of(group, case, result))
        print(f"{group}: {case}, {result['clips']} clips", file=sys.stderr)
    json.dump({"rows": rows}, sys.stdout, indent=1)
    print()


if __name__ == "__main__":
    main()
