#!/usr/bin/env python3
"""Clips per second of `earpoint train` with gtf, by number of threads: the whole command.

Runs a short and a longer training alternately; their difference does not contain the cost of starting. Wall
time needs an idle machine; processor time shows the cost of a clip in any case. With --before it measures
another build too, whose losses must agree. Writes FOLDER/training_gtf.json.

usage: gtf_training.py EARPOINT CONFIG DATA FOLDER [--before EARPOINT] [--rounds N] [--steps N]
"""
import argparse
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time

SHORT_STEPS = 8
BATCH = 16
# Relative difference of the losses after the same steps: float32 sums in other orders, amplified by Adam. The build
# before the optimisations differed by 4e-4 between numbers of threads.
MOST_DIFFERENCE = 1e-3


def train(binary, config, data, steps, jobs, folder):
    """Wall seconds, processor seconds and the last loss of one training."""
    path = os.path.join(folder, f"{steps}.json")
    with open(path, "w") as file:
        json.dump({"extends": os.path.abspath(config), "data": {"validation_pairs": 8},
                   "training": {"steps": steps, "batch": BATCH, "validate_every": 1_000_000}}, file)
    with tempfile.TemporaryDirectory(dir=folder) as run:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        start = time.monotonic()
        subprocess.run([binary, "train", path, "--data", data, "--out", run, "--quiet",
                        "--jobs", str(jobs)], check=True)
        wall_s = time.monotonic() - start
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        with open(os.path.join(run, "steps.csv")) as file:
            loss = float(file.read().split()[-1].split(",")[1])
    return (wall_s, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, loss)


def measure(binary, config, data, steps, jobs, folder):
    short = train(binary, config, data, SHORT_STEPS, jobs, folder)
    long = train(binary, config, data, SHORT_STEPS + steps, jobs, folder)
    clips = steps * BATCH
    return {"wall_s": (long[0] - short[0]) / clips, "processor_s": (long[1] - short[1]) / clips,
            "loss": long[2]}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("binary")
    parser.add_argument("config")
    parser.add_argument("data")
    parser.add_argument("folder")
    parser.add_argument("--before")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--steps", type=int, default=60)
    options = parser.parse_args()
    builds = {"now": options.binary}
    if options.before:
        builds["before"] = options.before
    os.makedirs(options.folder, exist_ok=True)
    taken = {}
    with tempfile.TemporaryDirectory(dir=options.folder) as folder:
        for _ in range(options.rounds):
            for jobs in (1, 2, 0):
                for name, binary in builds.items():
                    run = measure(binary, options.config, options.data, options.steps, jobs, folder)
                    taken.setdefault((name, jobs), []).append(run)
                    print(name, jobs, json.dumps(run), file=sys.stderr, flush=True)
    losses = [run["loss"] for runs in taken.values() for run in runs]
    if max(losses) - min(losses) > MOST_DIFFERENCE * min(losses):
        sys.exit(f"gtf_training: losses differ: {min(losses)} to {max(losses)}")
    rows = [{"build": name, "jobs": jobs,
             "clips_per_s": 1 / statistics.median(run["wall_s"] for run in runs),
             "processor_s_per_clip": statistics.median(run["processor_s"] for run in runs)}
            for (name, jobs), runs in taken.items()]
    with open(os.path.join(options.folder, "training_gtf.json"), "w") as file:
        json.dump({"cores": os.cpu_count(), "rounds": options.rounds, "rows": rows,
                   "loss_difference": max(losses) / min(losses) - 1}, file, indent=2)


if __name__ == "__main__":
    main()
