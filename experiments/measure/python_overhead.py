#!/usr/bin/env python3
"""The Python package's overhead over the command line: whole clips, rendered alternately by both, each in its own
process; and a stream in blocks against the same samples as one block.

Prints one JSON object for each comparison, in processor seconds; `ratio` is the median of the package over that of the
program, or of many blocks over that of one. Whole clips include start, reading and writing; `ratio`
leaves out `import_s`, which Python's start and the imports of NumPy and the package take, and `slices_s`, in which NumPy
cuts the blocks out of the arrays.

usage: PYTHONPATH=... /usr/bin/python3 experiments/measure/python_overhead.py EARPOINT CLIP [SECONDS] [ROUNDS]
"""
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time

import numpy as np

import earpoint

BOX = (0.383, 0.348, 0.513, 1.0)
RATE = 48000

RENDER = f"""
import sys
import numpy as np
import earpoint
folder, rate = sys.argv[1], {RATE}
sound = np.load(folder + "/sound.npy")
frame = np.load(folder + "/frame.npy")
there = earpoint.render(sound, rate, frame, speaker_box={BOX}, translate=(1, 0, 0), threads=1)
np.save(folder + "/there.npy", there)
"""


def processor_s(command):
    """User and system seconds of a process."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def whole_clips(program, folder, rounds):
    by_program = [program, "render", f"{folder}/frame.png", f"{folder}/sound.wav", "--speaker-box",
                  ",".join(map(str, BOX)), "--translate", "1,0,0", "--recording", "binaural", "--fov", "90", "--threads",
                  "1", "--quiet", "-o", f"{folder}/there.wav"]
    by_package = [sys.executable, "-c", RENDER, folder]
    only_import = [sys.executable, "-c", "import numpy, earpoint"]
    taken = {"program": [], "package": [], "import": []}
    for _ in range(rounds):
        taken["program"].append(processor_s(by_program))
        taken["package"].append(processor_s(by_package))
        taken["import"].append(processor_s(only_import))
    middle = {name: statistics.median(values) for name, values in taken.items()}
    return {"what": "whole clip", "program_s": middle["program"], "package_s": middle["package"],
            "import_s": middle["import"], "ratio": (middle["package"] - middle["import"]) / middle["program"]}


def blocks(sound, frame, size, rounds):
    """A second of sound in blocks of that size, against the same in one."""
    second = np.ascontiguousarray(sound[:, :RATE])
    stream = earpoint.Renderer("gtf", threads=1).stream(RATE)
    stream.see(frame, BOX)
    stream.move_to((1, 0, 0))
    out = np.empty_like(second)
    times = {"one": [], "many": [], "slices": []}
    for _ in range(rounds):
        start = time.process_time()
        stream.process(second, out)
        times["one"].append(time.process_time() - start)
        start = time.process_time()
        for at in range(0, RATE, size):
            stream.process(second[:, at:at + size], out[:, at:at + size])
        times["many"].append(time.process_time() - start)
        start = time.process_time()
        for at in range(0, RATE, size):
            _ = second[:, at:at + size], out[:, at:at + size]
        times["slices"].append(time.process_time() - start)
    middle = {name: statistics.median(values) for name, values in times.items()}
    return {"what": f"stream in blocks of {size}", "one_block_s": middle["one"], "blocks_s": middle["many"],
            "slices_s": middle["slices"], "ratio": (middle["many"] - middle["slices"]) / middle["one"]}


def main():
    program, clip = sys.argv[1:3]
    seconds = int(sys.argv[3]) if len(sys.argv) > 3 else 60
    rounds = int(sys.argv[4]) if len(sys.argv) > 4 else 5
    os.environ["OMP_NUM_THREADS"] = "1"
    with tempfile.TemporaryDirectory() as folder:
        ffmpeg = ["ffmpeg", "-v", "error"]
        subprocess.run([*ffmpeg, "-i", clip, "-frames:v", "1", f"{folder}/frame.png"], check=True)
        subprocess.run([*ffmpeg, "-stream_loop", "-1", "-i", clip, "-vn", "-ar", str(RATE), "-t", str(seconds), "-c:a",
                        "pcm_f32le", f"{folder}/sound.wav"], check=True)
        samples = subprocess.run([*ffmpeg, "-i", f"{folder}/sound.wav", "-f", "f32le", "-"], check=True,
                                 capture_output=True).stdout
        sound = np.ascontiguousarray(np.frombuffer(samples, "<f4").reshape(-1, 2).T)
        picture = subprocess.run([*ffmpeg, "-i", f"{folder}/frame.png", "-f", "image2pipe", "-c:v", "ppm", "-"],
                                 check=True, capture_output=True).stdout
        width, height = map(int, picture.split(maxsplit=3)[1:3])
        frame = np.frombuffer(picture[len(picture) - 3 * width * height:], np.uint8).reshape(height, width, 3)
        np.save(f"{folder}/sound.npy", sound)
        np.save(f"{folder}/frame.npy", frame)
        print(json.dumps({"clip_s": seconds, **whole_clips(program, folder, rounds)}), flush=True)
        for size in (480, 64):
            print(json.dumps(blocks(sound, frame, size, 4 * rounds)), flush=True)


if __name__ == "__main__":
    main()
