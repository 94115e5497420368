#!/usr/bin/env python3
"""Training steps of ViGAS networks: Earpoint and PyTorch alternately.

The peer (experiments/peers/peer_training.py) computes only the output head that is used, and both keep freed
memory. Every round runs each of them once, so that other load on the machine affects both alike. Writes
FOLDER/training.json.

usage: compare_training.py TRAINING_BENCH FOLDER [--rounds N] [--threads N]
"""
import argparse
import json
import os
import statistics
import subprocess
import sys

from compare_vigas import Contestant, KEEP_MEMORY, PYTHON

PEER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "peer_training.py")
# Blocks, layers in each, channels, pixels of the picture (0: no image trunk), clips in a batch.
NETWORKS = [(1, 10, 16, 0, 8), (1, 10, 32, 0, 8), (1, 10, 48, 0, 8), (3, 10, 64, 0, 2),
            (1, 10, 32, 64, 8), (1, 10, 32, 128, 8), (1, 10, 32, 256, 8), (3, 10, 64, 256, 2)]
# Float32 on either side, sums of up to 128,000 terms in different orders.
MOST_DIFFERENCE = 1e-3


def check_peer(folder, threads):
    """The peer must compute Earpoint's gradients, except in the image trunk, where batch norms of noise
    amplify rounding."""
    output = subprocess.run([PYTHON, PEER, folder, "--check", "--threads", threads], check=True,
                            text=True, stdout=subprocess.PIPE).stdout
    if not float(output) < MOST_DIFFERENCE:
        sys.exit(f"compare_training: the peer's gradients differ by {output}")
    return float(output)


def compare(bench, folder, network, rounds, threads):
    blocks, layers, channels, picture, clips = network
    saved = os.path.join(folder, "training")
    os.makedirs(saved, exist_ok=True)
    command = [bench, "--serve", "--save", saved, "--threads", threads, "--blocks", str(blocks),
               "--layers", str(layers), "--channels", str(channels), "--picture", str(picture),
               "--clips", str(clips)]
    contestants = {"earpoint": Contestant(command, KEEP_MEMORY)}
    difference = check_peer(saved, threads)
    contestants["peer"] = Contestant([PYTHON, PEER, saved, "--serve", "--threads", threads],
                                     KEEP_MEMORY)
    taken = {name: [] for name in contestants}
    for _ in range(rounds):
        for name, contestant in contestants.items():
            taken[name].append(contestant.measure("step"))
    for contestant in contestants.values():
        contestant.process.stdin.close()
        contestant.process.wait()
    result = {"layers": blocks * layers, "channels": channels, "picture_px": picture,
              "clips": clips, "largest_difference": difference}
    for name, steps in taken.items():
        result[name] = {
            "clips_per_s": clips / statistics.median(step[0] for step in steps),
            "processor_s_per_clip": statistics.median(step[1] for step in steps) / clips}
    result["times_faster"] = result["earpoint"]["clips_per_s"] / result["peer"]["clips_per_s"]
    return result


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("bench")
    parser.add_argument("folder")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--threads", type=int, default=2)
    options = parser.parse_args()
    results = []
    for network in NETWORKS:
        results.append(compare(options.bench, options.folder, network, options.rounds,
                               str(options.threads)))
        print(json.dumps(results[-1]), flush=True)
    with open(os.path.join(options.folder, "training.json"), "w") as file:
        json.dump({"threads": options.threads, "rounds": options.rounds, "networks": results}, file,
                  indent=2)


if __name__ == "__main__":
    main()
