#!/usr/bin/env python3
"""Peak memory of `earpoint render` on a 10-minute clip, as a child process of this one.

The clip is the bundled one, looped by ffmpeg (picture and sound). Prints one JSON object.

usage: experiments/stress/render_memory.py EARPOINT CLIP [MODEL]
  MODEL  dsp (the default), or the file of a ViGAS network
"""
import json
import os
import resource
import subprocess
import sys
import tempfile
import time

MINUTES = 10


def main():
    earpoint, clip = sys.argv[1:3]
    model = sys.argv[3] if len(sys.argv) > 3 else "dsp"
    with tempfile.TemporaryDirectory() as folder:
        long_clip = os.path.join(folder, "long.mp4")
        subprocess.run(
            ["ffmpeg", "-v", "error", "-stream_loop", "-1", "-i", clip, "-t", str(MINUTES * 60),
             "-c", "copy", long_clip],
            check=True)
        # In a child process: the system reports the largest memory of all children so far, and ffmpeg
        # was one of them.
        reader, writer = os.pipe()
        start = time.monotonic()
        child = os.fork()
        if child == 0:
            os.close(reader)
            subprocess.run(
                [earpoint, "render", long_clip, "--model", model, "--speaker", "2,0,0",
                 "--speaker-box", "0.4,0.2,0.6,0.9", "--translate", "1,0,0", "--quiet",
                 "-o", os.path.join(folder, "there.mp4")],
                check=True)
            peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
            os.write(writer, str(peak).encode())
            os._exit(0)
        os.close(writer)
        text = os.read(reader, 64).decode()
        os.waitpid(child, 0)
        if not text:
            sys.exit("render failed")
        print(json.dumps({
            "model": "vigas" if os.path.isfile(model) else model,
            "clip_s": MINUTES * 60,
            "peak_mb": int(text) / 1024,
            "wall_s": time.monotonic() - start,
        }))


if __name__ == "__main__":
    main()
