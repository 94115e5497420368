#!/usr/bin/env python3
"""How many times faster than real time `earpoint render` is, including start, reading and writing.

The sound is that of the bundled clip, looped by ffmpeg to ten minutes, beside a still picture of it.
Prints one JSON object for each way of rendering.

usage: experiments/measure/render_speed.py EARPOINT CLIP [SECONDS]
"""
import json
import os
import subprocess
import sys
import tempfile
import time

STILL = ["--translate", "1,0,0"]


def wall_s(command, cores):
    start = time.monotonic()
    subprocess.run(command, check=True, preexec_fn=lambda: os.sched_setaffinity(0, cores))
    return time.monotonic() - start


def main():
    earpoint, clip = sys.argv[1:3]
    seconds = int(sys.argv[3]) if len(sys.argv) > 3 else 600
    available = sorted(os.sched_getaffinity(0))
    with tempfile.TemporaryDirectory() as folder:
        def inside(name):
            return os.path.join(folder, name)

        def ffmpeg(*words):
            subprocess.run(["ffmpeg", "-v", "error", *words], check=True)

        ffmpeg("-i", clip, "-frames:v", "1", inside("frame.png"))
        for rate in (16000, 48000):
            ffmpeg("-stream_loop", "-1", "-i", clip, "-vn", "-ar", str(rate), "-t", str(seconds),
                   inside(f"{rate}.wav"))
        with open(inside("walk.csv"), "w") as walk:
            walk.write("time_s,x,y,z,yaw_deg,pitch_deg,roll_deg\n")
            for second in range(seconds + 1):
                walk.write(f"{second},{1.0 + 0.5 * (second % 2)},0,0,{20 * (second % 2)},0,0\n")
        moving = ["--path", inside("walk.csv")]
        for model, rate, cores, target in (
                ("gtf", 16000, 1, STILL), ("gtf", 48000, 1, STILL), ("gtf", 48000, 1, moving),
                ("gtf", 16000, 2, STILL), ("gtf", 48000, 2, STILL), ("gtf", 48000, 2, moving),
                ("vigas", 16000, 2, STILL), ("vigas", 48000, 2, STILL)):
            if cores > len(available):
                continue
            taken = wall_s(
                [earpoint, "render", inside("frame.png"), inside(f"{rate}.wav"), "--model", model,
                 "--speaker-box", "0.4,0.2,0.6,0.9", *target, "--threads", str(cores), "--quiet",
                 "-o", inside("there.wav")], available[:cores])
            print(json.dumps({"model": model, "rate_hz": rate, "cores": cores,
                              "moving": target is moving, "clip_s": seconds, "wall_s": taken,
                              "times_real_time": seconds / taken}), flush=True)


if __name__ == "__main__":
    main()
