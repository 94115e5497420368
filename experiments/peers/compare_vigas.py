#!/usr/bin/env python3
"""One second of sound through the released network: Earpoint and two PyTorch peers, alternately.

Peers (experiments/peers/peer_pytorch.py, 2 threads unless told otherwise):
  released  all 30 output heads, the C library's default allocator: the call as released
  fair      only the output head that is used, the allocator set to keep its memory
Every round runs each of them once, so that other load on the machine affects all alike. Writes
FOLDER/vigas.json and FOLDER/vigas.md and prints the latter.

usage: compare_vigas.py VIGAS_BENCH FOLDER [--rounds N] [--threads N]
"""
import argparse
import json
import os
import statistics
import subprocess
import sys
import time

PEER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "peer_pytorch.py")
PYTHON = "/usr/bin/python3"  # which has Debian's PyTorch
KEEP_MEMORY = {  # glibc: never return memory, so that no page faults twice
    "MALLOC_MMAP_THRESHOLD_": str(1 << 32),
    "MALLOC_TRIM_THRESHOLD_": str(1 << 35),
    "MALLOC_TOP_PAD_": str(1 << 28),
}
PAUSE_S = 0.1  # until the OpenMP threads of the previous run are asleep


class Contestant:
    def __init__(self, command, environment=None):
        self.process = subprocess.Popen(
            command, env={**os.environ, **(environment or {})}, text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.ready = self.read()

    def read(self):
        line = self.process.stdout.readline()
        if not line:
            sys.exit(f"compare_vigas: {' '.join(self.process.args)} ended")
        return line.split()

    def measure(self, name):
        time.sleep(PAUSE_S)
        self.process.stdin.write(name + "\n")
        self.process.stdin.flush()
        return [float(number) for number in self.read()]


def check_peer(folder, threads):
    """The peers must compute what Earpoint computed."""
    for heads in ("all", "last"):
        output = subprocess.run(
            [PYTHON, PEER, folder, "--check", "--heads", heads, "--threads", str(threads)],
            check=True, text=True, stdout=subprocess.PIPE).stdout
        if not float(output) < 1e-4:
            sys.exit(f"compare_vigas: the peer's output differs by {output}")
    return float(output)


def run_rounds(contestants, rounds):
    taken = {}
    for _ in range(rounds):
        for name, contestant in contestants.items():
            for part in ("whole", "stack", "trunk"):
                taken.setdefault((name, part), []).append(contestant.measure(part))
            if name == "earpoint":
                taken.setdefault("peak", []).append(contestant.measure("peak")[0])
    return taken


def summarize(taken, direct, live):
    result = {"median_fma_peak_gflops": statistics.median(taken.pop("peak"))}
    for (name, part), pairs in taken.items():
        result.setdefault(name, {})[part] = {
            "median_ms": 1e3 * statistics.median(pair[0] for pair in pairs),
            "least_ms": 1e3 * min(pair[0] for pair in pairs),
            "median_processor_ms": 1e3 * statistics.median(pair[1] for pair in pairs),
        }
    seconds = result["earpoint"]["stack"]["median_ms"] / 1e3
    for key, operations in (("direct", direct), ("without_padding", live)):
        result[key] = {
            "gflop": operations / 1e9,
            "gflops": operations / 1e9 / seconds,
            "fraction_of_peak": operations / 1e9 / seconds / result["median_fma_peak_gflops"],
        }
    for peer in ("released", "fair"):
        result[peer]["times_slower"] = (
            result[peer]["whole"]["median_ms"] / result["earpoint"]["whole"]["median_ms"])
        result[peer]["times_more_processor_time"] = (
            result[peer]["whole"]["median_processor_ms"]
            / result["earpoint"]["whole"]["median_processor_ms"])
    return result


def table(result):
    lines = ["| | whole, ms | audio core, ms | image trunk, ms | processor time of whole, ms |",
             "|---|---|---|---|---|"]
    names = {"earpoint": "Earpoint", "fair": "PyTorch, last head, tuned allocator",
             "released": "PyTorch, as released"}
    for key, name in names.items():
        parts = [f"{result[key][part]['median_ms']:.1f}" for part in ("whole", "stack", "trunk")]
        processor = f"{result[key]['whole']['median_processor_ms']:.1f}"
        lines.append("| " + " | ".join([name, *parts, processor]) + " |")
    lines.append("")
    for key, name in (("direct", "counted by the direct form"),
                      ("without_padding", "without taps that see only padding")):
        lines.append(
            f"Audio core: {result[key]['gflop']:.1f} GFLOP {name}, "
            f"{result[key]['gflops']:.0f} GFLOP/s, {result[key]['fraction_of_peak']:.0%} of the "
            f"measured peak of {result['median_fma_peak_gflops']:.0f} GFLOP/s.  ")
    for key in ("fair", "released"):
        lines.append(
            f"{names[key]}: {result[key]['times_slower']:.2f} times slower "
            f"({result[key]['times_more_processor_time']:.2f} times the processor time).  ")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("bench")
    parser.add_argument("folder")
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--threads", type=int, default=2)
    options = parser.parse_args()
    threads = str(options.threads)
    network = os.path.join(options.folder, "vigas")
    os.makedirs(network, exist_ok=True)

    earpoint = Contestant([options.bench, "--serve", "--save", network, "--threads", threads])
    difference = check_peer(network, options.threads)
    peer = [PYTHON, PEER, network, "--serve", "--threads", threads, "--heads"]
    contestants = {
        "earpoint": earpoint,
        "fair": Contestant([*peer, "last"], KEEP_MEMORY),
        "released": Contestant([*peer, "all"]),
    }
    direct, live = (float(number) for number in earpoint.ready[1:])
    result = {"threads": options.threads, "rounds": options.rounds,
              "largest_difference": difference,
              **summarize(run_rounds(contestants, options.rounds), direct, live)}
    with open(os.path.join(options.folder, "vigas.json"), "w") as file:
        json.dump(result, file, indent=2)
    with open(os.path.join(options.folder, "vigas.md"), "w") as file:
        file.write(table(result))
    print(table(result), end="")


if __name__ == "__main__":
    main()
