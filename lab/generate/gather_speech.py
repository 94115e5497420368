#!/usr/bin/env python3
"""Gathers recorded speech from unpacked Debian packages into a folder that earpoint simulate reads.

usage: gather_speech.py UNPACKED speech_sources.json FOLDER [VOICE,VOICE...]
       gather_speech.py --packages speech_sources.json [VOICE,VOICE...]

UNPACKED holds every package, unpacked, in a folder of its name. FOLDER gets speech.csv, a folder of
16 kHz FLAC files for every voice and the packages' licences. Short recordings of a voice are
joined, a third of a second between them, so that most files last 5 to 15 s. The second form prints
the names of the packages that are wanted. VOICES: these alone.
"""
import concurrent.futures
import csv
import glob
import json
import os
import re
import shutil
import subprocess
import sys

PAUSE_S = 0.35
SILENCE_DB = -45.0
# Silence at the ends of a recording: below -45 dB, all but a tenth of a second.
TRIM = ("silenceremove=start_periods=1:start_threshold=-45dB:start_silence=0.1,areverse,"
        "silenceremove=start_periods=1:start_threshold=-45dB:start_silence=0.1,areverse")


def recordings(unpacked, voice):
    """The voice's files, sorted."""
    found = []
    for pattern in voice["files"]:
        found += glob.glob(os.path.join(glob.escape(unpacked), pattern), recursive=True)
    wanted = re.compile(voice.get("match", "."))
    unwanted = re.compile(voice.get("without", "(?!)"))
    names = [path for path in sorted(found)
             if wanted.search(os.path.basename(path))
             and not unwanted.search(os.path.basename(path))]
    if not names:
        sys.exit(f"gather_speech.py: the voice '{voice['name']}' has no files in {unpacked}")
    return names


def spread(names, count):
    """At most so many of them, evenly over the list."""
    if len(names) <= count:
        return names
    return [names[i * len(names) // count] for i in range(count)]


def join(names, path):
    """Joins recordings into one file; returns whether there is sound in it."""
    inputs, filters = [], []
    for i, name in enumerate(names):
        if name.endswith(".g722"):
            inputs += ["-f", "g722"]
        inputs += ["-i", name]
        filters.append(f"[{i}:a]aresample=16000,aformat=channel_layouts=mono,{TRIM},"
                       f"apad=pad_dur={PAUSE_S}[a{i}]")
    parts = "".join(f"[a{i}]" for i in range(len(names)))
    filters.append(f"{parts}concat=n={len(names)}:v=0:a=1,volumedetect[out]")
    aside = path.replace(".flac", ".partial.flac")
    command = ["ffmpeg", "-nostdin", "-hide_banner", "-nostats", "-y", *inputs,
               "-filter_complex", ";".join(filters), "-map", "[out]", "-map_metadata", "-1",
               "-fflags", "+bitexact", "-flags:a", "+bitexact", "-sample_fmt", "s16", aside]
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode != 0:
        print(f"left out {names[0]}: {run.stderr.strip().splitlines()[-1]}", file=sys.stderr)
        return False
    # Nothing but pauses.
    peak_db = re.search(r"max_volume: (-?[0-9.]+) dB", run.stderr)
    if peak_db is None or float(peak_db.group(1)) < SILENCE_DB:
        os.remove(aside)
        return False
    os.rename(aside, path)
    return True


def gather(unpacked, sources, folder):
    jobs, rows = [], []
    for voice in sources["voices"]:
        names = spread(recordings(unpacked, voice), voice["join"] * sources["files_per_voice"])
        os.makedirs(os.path.join(folder, voice["name"]), exist_ok=True)
        for number, first in enumerate(range(0, len(names), voice["join"])):
            file = os.path.join(voice["name"], f"{number:04}.flac")
            jobs.append((names[first:first + voice["join"]], os.path.join(folder, file)))
            rows.append([file, voice["name"], voice["gender"], voice["split"]])
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        made = list(pool.map(lambda job: join(*job), jobs))
    with open(os.path.join(folder, "speech.csv"), "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["file", "speaker", "gender", "split"])
        writer.writerows(row for row, there in zip(rows, made) if there)
    return sum(made)


def copy_licences(unpacked, sources, folder):
    os.makedirs(os.path.join(folder, "licences"), exist_ok=True)
    for package in sources["packages"]:
        shutil.copyfile(os.path.join(unpacked, package, "usr/share/doc", package, "copyright"),
                        os.path.join(folder, "licences", package + ".txt"))


def read_sources(table, names):
    """The table, with the named voices alone and the packages that they come from."""
    with open(table, encoding="utf-8") as file:
        sources = json.load(file)
    if names:
        sources["voices"] = [voice for voice in sources["voices"] if voice["name"] in names]
    sources["packages"] = sorted({pattern.split("/")[0] for voice in sources["voices"]
                                  for pattern in voice["files"]})
    return sources


def main():
    arguments = sys.argv[1:]
    if len(arguments) in (2, 3) and arguments[0] == "--packages":
        names = arguments[2].split(",") if len(arguments) == 3 else None
        print(*read_sources(arguments[1], names)["packages"])
        return
    if len(arguments) not in (3, 4):
        sys.exit(__doc__)
    unpacked, table, folder = arguments[:3]
    sources = read_sources(table, arguments[3].split(",") if len(arguments) == 4 else None)
    os.makedirs(folder, exist_ok=True)
    copy_licences(unpacked, sources, folder)
    count = gather(unpacked, sources, folder)
    print(f"gathered {count} recordings of {len(sources['voices'])} voices in {folder}")


main()
