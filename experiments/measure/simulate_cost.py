#!/usr/bin/env python3
"""Cost of simulation by stage, and the cost of the paper's data set at that rate.

usage: experiments/measure/simulate_cost.py EARPOINT SPEECH [SCENES [CONVERSATIONS]]

Simulates a few homes into a temporary folder and prints one line of JSON. The paper's data set has
120 scenes, 200,000 viewpoints and 1,300 hours; hours are counted as `earpoint simulate` counts them,
so those of the estimate depend on how long the recordings of SPEECH are.
"""
import json
import subprocess
import sys
import tempfile

PAPER_SCENES = 120
PAPER_VIEWPOINTS = 200_000


def main():
    if len(sys.argv) not in (3, 4, 5):
        sys.exit(__doc__)
    earpoint, speech = sys.argv[1:3]
    scenes, conversations = (int(word) for word in (sys.argv[3:] + ["2", "6"][len(sys.argv) - 3:]))
    with tempfile.TemporaryDirectory() as folder:
        run = subprocess.run(
            [earpoint, "simulate", "--scenes", str(scenes), "--conversations", str(conversations),
             "--split", "train", "--speech", speech, "--out", folder, "--seed", "1", "--json",
             "--quiet"], capture_output=True, text=True, check=True)
    summary = json.loads(run.stdout)
    stages = dict(summary["run"]["core_seconds"])
    viewpoints = summary["viewpoints"]
    # A scene is made once for all of its conversations, which are many more in the paper's.
    per_scene_s = stages.pop("scene") / scenes
    per_viewpoint_s = sum(stages.values()) / viewpoints
    print(json.dumps({
        "scenes": scenes,
        "viewpoints": viewpoints,
        "core_s_per_scene": per_scene_s,
        "core_s_per_viewpoint": per_viewpoint_s,
        "core_s_per_viewpoint_by_stage": {name: s / viewpoints for name, s in stages.items()},
        "paper_core_hours": (PAPER_SCENES * per_scene_s + PAPER_VIEWPOINTS * per_viewpoint_s) / 3600,
        "paper_hours_of_sound": summary["hours"] * PAPER_VIEWPOINTS / viewpoints,
    }))


main()
