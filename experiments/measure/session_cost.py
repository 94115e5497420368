#!/usr/bin/env python3
"""Cost of a simulated session: processor time of `earpoint record simulate` per minute of session.

usage: experiments/measure/session_cost.py EARPOINT SPEECH

Simulates half a minute with three people and eight cameras into a temporary folder, once with the
default pictures and once with nearly none, and prints one line of JSON.
"""
import json
import resource
import subprocess
import sys
import tempfile

MINUTES = 0.5
SMALL = ["--size", "64x36", "--fps", "1"]


def core_seconds(earpoint, speech, more):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([earpoint, "record", "simulate", "--out", folder, "--seed", "1", "--people", "3",
                        "--minutes", str(MINUTES), "--speech", speech, "--quiet"] + more, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    whole_s = core_seconds(*sys.argv[1:], [])
    sound_s = core_seconds(*sys.argv[1:], SMALL)
    print(json.dumps({"core_s_per_minute": whole_s / MINUTES,
                      "core_s_per_minute_without_pictures": sound_s / MINUTES,
                      "minutes_per_hour_on_two_cores": 7200 * MINUTES / whole_s}))


main()
