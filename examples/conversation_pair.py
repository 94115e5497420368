#!/usr/bin/env python3
"""Prints, as shell assignments, how to render the first pair of a simulated data set's pair list.

usage: conversation_pair.py DATASET

The data set was made with `earpoint simulate --split test --heard`. Printed are picture and sound of
the source viewpoint, translate and yaw to the target viewpoint, the speaker's place, the option that
names the box where the speaker is seen (empty out of sight), and the true sound at the target.
"""
import json
import math
import os
import shlex
import sys


def relative(location, origin, heading):
    """A place as seen from a viewpoint: front, left, up. The file's y points up, -z ahead."""
    dx, dy, dz = (a - b for a, b in zip(location, origin))
    front, left = -dz, -dx
    cos, sin = math.cos(heading), math.sin(heading)
    return front * cos + left * sin, left * cos - front * sin, dy


def box_option(edges):
    """The box of the file, rows and columns of 256, as an option of `earpoint render`."""
    if not any(edges):
        return ""
    y_min, y_max, x_min, x_max = edges
    sides = (x_min, y_min, x_max + 1, y_max + 1)
    return "--speaker-box=" + ",".join(f"{side / 256:.4f}" for side in sides)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    folder = sys.argv[1]
    with open(os.path.join(folder, "pairs-test.json"), encoding="utf-8") as file:
        pair = json.load(file)["pairs"][0]
    scene = os.path.join(folder, "test", pair["scene"])
    with open(os.path.join(scene, "cleaned_metadata_v3.json"), encoding="utf-8") as file:
        clip = json.load(file)[pair["clip"]]
    source, target = (clip["viewpoints"][pair[name]] for name in ("source", "target"))
    speaker = clip["speakers"][pair["speaker"]]
    heard = os.path.join(scene, str(pair["clip"]), "heard_{}_{}.wav")

    def three(location):
        place = relative(location, source["location"], source["rotation"])
        return ",".join(f"{value:.4f}" for value in place)

    values = {
        "picture": os.path.join(folder, source["image"]),
        "sound": heard.format(pair["source"], pair["speaker"]),
        "truth": heard.format(pair["target"], pair["speaker"]),
        "translate": three(target["location"]),
        "yaw": f"{math.degrees(target['rotation'] - source['rotation']):.4f}",
        "speaker": three(speaker["location"]),
        "box": box_option(source["bboxes"][str(speaker["id"])]),
    }
    for name, value in values.items():
        print(f"{name}={shlex.quote(value)}")


main()
