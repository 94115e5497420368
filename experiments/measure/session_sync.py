#!/usr/bin/env python3
"""Errors of the clocks of simulated sessions: `earpoint record sync` against the truth.

usage: experiments/measure/session_sync.py EARPOINT SPEECH FOLDER [--minutes 5] [--cameras 4] [--snr 10] [--walks 5]
           [--seeds 101,...] [--sessions FOLDER...]

Simulates one session per seed, each in its own flat, into FOLDER/seed-N, or takes it from there, and prints
one line of JSON for each. With --sessions, those of `earpoint record simulate` in these folders instead.
"""
import argparse
import json
import os
import subprocess

# Clocks are estimated by sound alone: few pictures, and few rays, which only matter for late reverberation.
CHEAP = ["--size", "64x36", "--fps", "1", "--samples", "1", "--rays", "200"]


def simulated(earpoint, speech, options, seed):
    folder = os.path.join(options.folder, f"seed-{seed}")
    subprocess.run([earpoint, "record", "simulate", "--out", folder, "--seed", str(seed), "--speech", speech,
                    "--minutes", options.minutes, "--cameras", options.cameras, "--snr", options.snr,
                    "--walks", options.walks, "--quiet"] + CHEAP, check=True)
    return folder


def simulation_of(session):
    """What a session was simulated with: it lies beside a single one, and above several."""
    for folder in (session, os.path.dirname(session.rstrip("/"))):
        path = os.path.join(folder, "simulation.json")
        if os.path.exists(path):
            with open(path) as file:
                return json.load(file)
    raise SystemExit(f"{session}: no simulation.json there or above")


def measured(earpoint, folder):
    simulation = simulation_of(folder)
    found = subprocess.run([earpoint, "record", "sync", os.path.join(folder, "session.json"), "--truth",
                            os.path.join(folder, "truth.json"), "--json", "--quiet"],
                           check=True, stdout=subprocess.PIPE, text=True).stdout
    found = json.loads(found)
    return {"session": os.path.basename(folder.rstrip("/")), "minutes": simulation["minutes"],
            "snr_db": simulation["snr_db"],
            "cameras": sum(device["kind"] == "camera" for device in found["devices"]),
            "people": sum(device["kind"] == "microphone" for device in found["devices"]),
            "by_onsets": sum(device["method"] == "onsets" for device in found["devices"]),
            "offset_error_ms_p95": found["offset_error_ms_p95"],
            "drift_error_ppm_p95": found["drift_error_ppm_p95"]}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("earpoint")
    parser.add_argument("speech")
    parser.add_argument("folder")
    parser.add_argument("--minutes", default="5")
    parser.add_argument("--cameras", default="4")
    parser.add_argument("--snr", default="10")
    parser.add_argument("--walks", default="5")
    parser.add_argument("--seeds", default="101,102,103,104,105,106")
    parser.add_argument("--sessions", nargs="+", metavar="FOLDER")
    options = parser.parse_args()
    folders = options.sessions or (simulated(options.earpoint, options.speech, options, int(seed))
                                   for seed in options.seeds.split(","))
    for folder in folders:
        print(json.dumps(measured(options.earpoint, folder)), flush=True)


main()
