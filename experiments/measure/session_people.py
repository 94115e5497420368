#!/usr/bin/env python3
"""People and who speaks in simulated sessions: `earpoint locate` on every camera's movie, against the truth.

usage: experiments/measure/session_people.py EARPOINT SESSION [SESSION...] [--detector FILE]

A SESSION is a folder of `earpoint record simulate`. A person counts as found in a picture if a box that is seen there
overlaps theirs by half (intersection over union). People of whom more than a tenth is hidden need not be found, and a
box on them is not wrong. A switch is a person's next box having another track's number. Who speaks is asked five times a
second where exactly one person does, for half or more of the second around that moment, and is in the picture. Prints one
JSON object.
"""
import argparse
import csv
import json
import math
import os
import subprocess

LEAST_OVERLAP = 0.5
SAME_PERSON = 0.25  # overlap of a box that shows a person, though not exactly
LEAST_VISIBLE = 0.9
WINDOW_S = 1.0  # of sound around a moment
LEAST_SPOKEN_S = 0.5  # of it


def overlap(a, b):
    width = min(a[2], b[2]) - max(a[0], b[0])
    height = min(a[3], b[3]) - max(a[1], b[1])
    if width <= 0 or height <= 0:
        return 0.0
    shared = width * height
    return shared / ((a[2] - a[0]) * (a[3] - a[1]) + (b[2] - b[0]) * (b[3] - b[1]) - shared)


def pairs_of(found, people):
    """Pairs of boxes that overlap enough, the best first, each box in one: {person: index into found}."""
    candidates = sorted(((overlap(box, person["box"]), i, name) for i, (_, box) in enumerate(found)
                         for name, person in people.items()), reverse=True)
    pairs = {}
    for share, i, name in candidates:
        if share >= LEAST_OVERLAP and name not in pairs and i not in pairs.values():
            pairs[name] = i
    return pairs


def true_boxes(session, camera):
    """By frame, without those in which nobody is: {person: {"box", "visible"}}; and seconds between frames."""
    frames, period_s = {}, math.inf
    with open(os.path.join(session, "boxes.csv"), newline="") as file:
        for row in csv.DictReader(file):
            if int(row["camera"]) != camera:
                continue
            box = [float(row[key]) for key in ("x_min", "y_min", "x_max", "y_max")]
            frames.setdefault(int(row["frame"]), {})[int(row["person"])] = {"box": box, "visible": float(row["visible"])}
            if int(row["frame"]) > 0:
                period_s = float(row["time_s"]) / int(row["frame"])
    return frames, period_s


def only_speaker(truth, time_s):
    """The one person who speaks in the second around a moment; None if nobody or several do."""
    spoken_s = []
    for person in truth["people"]:
        inside = (min(end, time_s + WINDOW_S / 2) - max(begin, time_s - WINDOW_S / 2) for begin, end in person["speech"])
        spoken_s.append(sum(max(0.0, part) for part in inside))
    speakers = [i for i, length in enumerate(spoken_s) if length > 0]
    return speakers[0] if len(speakers) == 1 and spoken_s[speakers[0]] >= LEAST_SPOKEN_S else None


def count_camera(session, camera, located, truth, counts):
    frames, period_s = true_boxes(session, camera)
    clock = truth["cameras"][camera]
    last_track = {}
    for moment in located["frames"]:
        # As locate takes them: the nearest, and the earlier of two that are as near.
        people = frames.get(math.ceil(moment["time_s"] / period_s - 0.5 - 1e-4), {})
        seen = [(person["track"], person["box"]) for person in moment["people"] if person["seen"]]
        pairs = pairs_of(seen, people)
        counts["pictures"] += 1
        clear = {name for name, person in people.items() if person["visible"] >= LEAST_VISIBLE}
        counts["people"] += len(clear)
        counts["found"] += len(clear & pairs.keys())
        counts["wrong"] += len(seen) - len(pairs)
        for name, i in pairs.items():
            track = seen[i][0]
            counts["switches"] += last_track.get(name, track) != track
            last_track[name] = track
        session_s = clock["offset_s"] + moment["time_s"] / (1 + 1e-6 * clock["drift_ppm"])
        speaker = only_speaker(truth, session_s)
        if speaker is None or speaker not in people:
            continue
        counts["moments"] += 1
        best = max(moment["people"], key=lambda person: person["speaking"], default=None)
        if best is None or best["speaking"] < moment["outside"]:
            counts["nobody"] += 1
        elif overlap(best["box"], people[speaker]["box"]) >= SAME_PERSON:
            counts["right"] += 1


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("earpoint")
    parser.add_argument("sessions", nargs="+")
    parser.add_argument("--detector", help="as of earpoint locate")
    options = parser.parse_args()
    counts = dict.fromkeys(("pictures", "people", "found", "wrong", "switches", "moments", "right", "nobody"), 0)
    name = None
    for session in options.sessions:
        with open(os.path.join(session, "truth.json")) as file:
            truth = json.load(file)
        with open(os.path.join(session, "session.json")) as file:
            cameras = json.load(file)["cameras"]
        for index, camera in enumerate(cameras):
            lens = camera["intrinsics"]
            fov_degrees = 2 * math.degrees(math.atan(lens["width"] / 2 / lens["fx"]))
            command = [options.earpoint, "locate", os.path.join(session, camera["video"]), "--json", "--quiet",
                       "--fov", f"{fov_degrees:.3f}", "--recording", "binaural"]
            if options.detector:
                command += ["--detector", options.detector]
            located = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)
            name = located["detector"]
            count_camera(session, index, located, truth, counts)
    counts["recall"] = counts["found"] / counts["people"]
    counts["precision"] = 1 - counts["wrong"] / max(1, counts["wrong"] + counts["found"])
    counts["speaker_right"] = counts["right"] / max(1, counts["moments"])
    print(json.dumps({"detector": name, "sessions": len(options.sessions), **counts}))


if __name__ == "__main__":
    main()
