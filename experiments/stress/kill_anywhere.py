#!/usr/bin/env python3
"""Kills simulate, train, evaluate and render at random moments and checks the files.

usage: experiments/stress/kill_anywhere.py EARPOINT SPEECH CLIP FOLDER [--times N] [--seed N] >kills.json

Each command first runs undisturbed. Then, N times, it is killed (SIGKILL) after a random part of that time and
started again until it ends by itself. What it has made must then equal the undisturbed result byte for
byte, and nothing else may lie beside it. FOLDER is emptied first.
"""
import argparse
import hashlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time

CONFIG = {"format": "earpoint-train-1",
          "network": {"kind": "gtf", "channels": 8, "layers": 2, "bands": 10, "picture_px": 32,
                      "picture_width": 8, "locator_width": 8, "summary_width": 8,
                      "conditioning_width": 8},
          "data": {"validation_pairs": 2},
          "training": {"seed": 1, "batch": 2, "steps": 30, "learning_rate": 0.001, "validate_every": 5}}


def digest(path):
    """A digest of a file's bytes; of a weight file only of its tensors, since its metadata have the run's times."""
    with open(path, "rb") as file:
        content = file.read()
    if path.endswith(".safetensors"):
        end = 8 + int.from_bytes(content[:8], "little")
        header = json.loads(content[8:end])
        header.pop("__metadata__", None)
        content = json.dumps(header, sort_keys=True).encode() + content[end:]
    return hashlib.sha256(content).hexdigest()


class Task:
    """A command, the folder that it works in, and which of its files must be equal."""

    def __init__(self, name, arguments, folder, skip=()):
        self.name, self.arguments, self.folder, self.skip = name, arguments, folder, skip

    def start(self):
        return subprocess.Popen(self.arguments, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                start_new_session=True)

    def finish(self):
        process = self.start()
        errors = process.communicate()[1].decode(errors="replace")
        if process.returncode != 0:
            raise RuntimeError(f"{self.name}: exit {process.returncode}: {errors.strip()}")

    def files(self):
        """Every file below the folder, hidden ones too: path -> digest of its bytes."""
        found = {}
        for root, _, names in os.walk(self.folder):
            for name in names:
                path = os.path.join(root, name)
                relative = os.path.relpath(path, self.folder)
                found[relative] = "any" if name in self.skip else digest(path)
        return found

    def empty(self):
        shutil.rmtree(self.folder, ignore_errors=True)
        os.makedirs(self.folder)


def killed_after(task, seconds):
    """Kills the command after that time. @return whether it was still running"""
    process = task.start()
    try:
        process.communicate(timeout=seconds)
        return False
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        return True


def measure(task, times, draw):
    task.empty()
    began = time.monotonic()
    task.finish()
    needed_s = time.monotonic() - began
    right = task.files()
    kills, faults = 0, []
    while kills < times:
        task.empty()
        while kills < times and killed_after(task, draw.uniform(0.0, needed_s)):
            kills += 1
            if draw.random() < 0.5:
                break
        task.finish()
        found = task.files()
        for path in sorted(set(right) | set(found)):
            if right.get(path) != found.get(path):
                state = "left over" if path not in right else "lost" if path not in found else "differs"
                faults.append(f"{path}: {state}")
    print(f"{task.name}: {kills} kills, {len(faults)} faults {faults[:5]}", file=sys.stderr)
    return {"command": task.name, "kills": kills, "files": len(right), "faults": faults,
            "undisturbed_s": round(needed_s, 2)}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("earpoint")
    parser.add_argument("speech")
    parser.add_argument("clip")
    parser.add_argument("folder")
    parser.add_argument("--times", type=int, default=25, help="kills of each command")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    earpoint = os.path.abspath(arguments.earpoint)
    shutil.rmtree(arguments.folder, ignore_errors=True)
    inside = lambda *names: os.path.join(os.path.abspath(arguments.folder), *names)
    os.makedirs(inside())
    with open(inside("config.json"), "w") as file:
        json.dump(CONFIG, file)

    def simulation(out):
        return [earpoint, "simulate", "--scenes", "3", "--conversations", "1", "--rays", "100", "--seed",
                "7", "--viewpoints", "3", "--speech", arguments.speech, "--out", out, "--quiet"]

    os.makedirs(inside("data"))
    subprocess.run(simulation(inside("data", "homes")), check=True)
    tasks = [
        Task("simulate", simulation(inside("simulate", "homes")), inside("simulate")),
        # These files have times in seconds.
        Task("train", [earpoint, "train", inside("config.json"), "--data", inside("data", "homes"), "--out",
                       inside("train", "run"), "--resume", "--jobs", "1"], inside("train"),
             ("validation.csv", "curves.png")),
        Task("evaluate", [earpoint, "evaluate", "--data", inside("data", "homes"), "--split", "val",
                          "--methods", "input,dsp", "--report", inside("evaluate", "page"), "--json"],
             inside("evaluate")),
        Task("render", [earpoint, "render", os.path.abspath(arguments.clip), "--translate", "1,0,0", "-o",
                        inside("render", "there.mp4"), "--plot", inside("render", "ears.png"), "--quiet"],
             inside("render")),
    ]
    draw = random.Random(arguments.seed)
    rows = [measure(task, arguments.times, draw) for task in tasks]
    json.dump(rows, sys.stdout, indent=1)
    print()
    sys.exit(1 if any(row["faults"] for row in rows) else 0)


if __name__ == "__main__":
    main()
