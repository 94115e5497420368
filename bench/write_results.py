#!/usr/bin/env python3
"""Puts together docs/results.md from what ./dev results has measured. Writes numbers, no judgement.

usage: bench/write_results.py MEASURED RESULTS.md [--measured-only]

MEASURED holds vigas.md, gtf_bench.json, training.json, training_gtf.json, oracle_errors.md, render_speed.jsonl,
render_memory.jsonl, page_latency.jsonl, serve_load.jsonl, demo.json, trace_gates.md, learning_curves-single.md, learning_curves-novel.md,
rt60_error.json, active_speaker.json, people_detection.jsonl, home_reverberation.jsonl, compare_tracers.json, kills.json,
change_of_results.md,
camera_bench.jsonl, simulate_cost.jsonl, session_cost.jsonl, session_sync.jsonl, evaluate-single.json, evaluate-novel.json, evaluate-recorded.json,
ablations-single.json, ablations-novel.json, generalisation.json,
generalisation_heads.json, ambient-single.json, ambient-novel.json, context-novel.json, separation-novel.md and enhance-novel.json; a section
whose file is missing stays as it is in RESULTS.md, or says so where it is new; with --measured-only it
is left out. Each section says on which day and after which commit its file was written.
"""
import datetime
import os
import platform
import shutil
import subprocess
import sys

from evaluation_tables import enhancement_table, evaluation_table
from measurement_tables import (camera_table, demo_table, detection_table, generalisation_table,
                                gtf_training_table, kill_table, load_table, memory_table, network_table,
                                page_table, reverberation_table, rt60_table, session_table, simulation_table,
                                speaker_table, speed_table, sync_table, trace_table, tracer_comparison,
                                training_table)


def machine():
    with open("/proc/cpuinfo") as file:
        model = next(line.split(":")[1].strip() for line in file if line.startswith("model name"))
    return f"{model}, {os.cpu_count()} cores, {platform.system()} {platform.machine()}"


def read(folder, name):
    path = os.path.join(folder, name)
    if not os.path.exists(path) or os.path.getsize(path) == 0:
        return None
    with open(path) as file:
        return file.read().strip()


EVALUATION_WORDS = (
    "`earpoint evaluate --oracles --json` on the frozen pairs of the test split. Intervals are drawn by home "
    "where there are several, else by conversation, since the clips of one share room, places and voices. "
    "`gtf` is the natural texture, `gtf:mean` the other one of the same network (docs/method.md). "
    "Oracles are shown part of the answer: they tell how much of the way to zero is to be had. ")

SECTIONS = [
    ("Methods in one home", "evaluate-single.json", evaluation_table,
     EVALUATION_WORDS + "One home; its conversations are split."),
    ("Methods in unseen homes", "evaluate-novel.json", evaluation_table,
     EVALUATION_WORDS + "Homes and speakers of the test split are in no other split."),
    ("What the corrected tracer changed", "change_of_results.md", None,
     "`bench/change_of_results.py`: means before and after the tracer was corrected: sound is diffracted at both "
     "edges of a wall's end ([ADR 0008](adr/0008-diffraction.md)), level between the ears grows near the head, "
     "transmission and uneven absorption are as *The path tracer against physics* has them. The data sets were "
     "simulated anew from the same seeds; networks are the same files, trained on what was simulated before."),
    ("Methods in unseen homes, with sound before", "context-novel.json", evaluation_table,
     "`earpoint evaluate --context 4 --json`: the same pairs, but `dsp` and networks hear the four seconds before "
     "the second that is compared too, in overlapping windows that are cross-faded, as in a long recording."),
    ("Methods in recorded sessions", "evaluate-recorded.json", evaluation_table,
     "`earpoint evaluate --layout replay` on the test sessions of twelve that `earpoint record simulate` made in one "
     "flat and `earpoint record prepare` cut into clips; no session is in two splits. The gtf that ships, which "
     "learned nothing of them."),
    ("Learning curves in one home", "learning_curves-single.md", None,
     "`bench/learning_curves.py`: Mag on 256 validation pairs while `earpoint train` runs on one core "
     "beside others, so minutes are upper bounds. Of gtf the natural texture is validated, whose losses Mag does "
     "not see. vigas and vigas-blind first learn "
     "where the speaker is, with no sound made; those clips do not count. "
     "![Error over clips seen](images/learning-curves-single.svg)"),
    ("Learning curves in unseen homes", "learning_curves-novel.md", None,
     "`bench/learning_curves.py`, as above. ![Error over clips seen](images/learning-curves-novel.svg)"),
    ("Reverberation time from sound", "rt60_error.json", rt60_table,
     "`rt60_error DATA test`: the estimator that RTE is computed with, on simulated speech of homes and "
     "voices it has not heard, against the reverberation time of the response."),
    ("People in pictures", "people_detection.jsonl", detection_table,
     "`people_detection DATA test`: a person is found where a box overlaps by half (intersection over union). "
     "*Drawn* are pictures of `earpoint-people-pictures`: homes and people of its test split, of whom nothing "
     "but the picture's edge hides more than a tenth; others need not be found. *Views of conversations* are those "
     "of `earpoint simulate`'s test split, of everybody with a box, hidden or not. *Photographs*: four of people "
     "and six of things out of Debian packages, boxes drawn by hand (`bench/photographs.json`): a smoke test, no "
     "measurement. NanoDet is what `./dev assets --people` installs."),
    ("Who speaks, in unseen homes", "active_speaker.json", speaker_table,
     "`active_speaker DATA test shipped`: people are found in the picture and the speaker among them by the time "
     "between the ears, in single seconds of the test split; four for every speaker and viewpoint."),
    ("Ablations in one home", "ablations-single.json", evaluation_table,
     "`earpoint evaluate --ablations --json`: the network without one of its parts."),
    ("Ablations in unseen homes", "ablations-novel.json", evaluation_table,
     "`earpoint evaluate --ablations --json`, as above."),
    ("Generalisation", "generalisation.json", generalisation_table,
     "`bench/generalisation.py --every 2`: gtf's mean errors over those of the unchanged input, in "
     "unseen homes, where something is not as in training; below 1 it helps. `dsp` is told where the speaker truly "
     "is. Voices of the test split are in no other; Greek is a language that training never has."),
    ("Generalisation: other heads, another building", "generalisation_heads.json", generalisation_table,
     "`bench/generalisation_heads.py`, as above: homes of other seeds, heard by the head of training and by "
     "FABIAN, measured in the horizontal plane; and a house that no generator drew, with an octagonal hall, a "
     "bare corridor and an attic, read from an OBJ file. `dsp` takes every head for KEMAR."),
    ("Ambient sound in one home", "ambient-single.json", evaluation_table,
     "`earpoint evaluate --ambient -40 --json`: room noise in what every source hears, separated by the "
     "high-pass at 80 Hz; the target is clean. `no-separation` was trained with the noise in both "
     "sounds, hears all of it, and its answer is separated; `with-ambient` was trained on separated sounds."),
    ("Ambient sound in unseen homes", "ambient-novel.json", evaluation_table,
     "`earpoint evaluate --ambient -40 --json`, as above."),
    ("Ways to separate ambient sound in unseen homes", "separation-novel.md", None,
     "`bench/ambient_separation.py --context 4 --limit 240`: room noise of three levels in what every source "
     "hears, separated by the band-pass, by spectral subtraction and by log-MMSE; the shipped models, which "
     "learned sound separated by the band-pass; four seconds of sound before the second that is compared."),
    ("Speech enhancement in unseen homes", "enhance-novel.json", enhancement_table,
     "`earpoint evaluate --enhance --json`: the target is the speaker's near microphone, the dry speech "
     "as loud as 1 m before the mouth in free field. `oracle-gain` is the source at the true level: what "
     "a change of loudness alone would bring."),
    ("Exactness: our engine against the authors' code", "oracle_errors.md", None,
     "The same weights and inputs through `earpoint model run` and through the released code. "
     "Tests hold every oracle to 1e-4, on every instruction set that the machine has."),
    ("Speed: one second of sound through the released network", "vigas.md", None,
     "`bench/compare_vigas.py`: Earpoint and PyTorch take turns in one run; medians. GFLOP are "
     "counted by the direct form of the convolutions, whatever was really multiplied."),
    ("Speed: gtf and ViGAS", "gtf_bench.json", network_table,
     "`gtf_bench`: one second of sound in turns, medians; multiply-adds by the direct form."),
    ("Speed: rendering a clip", "render_speed.jsonl", speed_table,
     "`bench/render_speed.py`: the whole of `earpoint render`, starting, reading and writing included, "
     "with the shipped models. The aim for gtf is 100 on two cores."),
    ("Speed: training steps", "training.json", training_table,
     "`bench/compare_training.py`: forward, backward and Adam on batches of one-second clips, in turns "
     "with Debian's python3-torch, which computes only the head that is heard and keeps freed memory; "
     "medians on two threads."),
    ("Speed: training gtf", "training_gtf.json", gtf_training_table,
     "`bench/gtf_training.py`: the whole of `earpoint train` with `configs/gtf-novel.json`, its examples made "
     "on the way, medians of runs in turns. *before* is the build before the passes of [ADR "
     "0015](adr/0015-training-speed.md). Wall time suffers from whatever else the machine does, processor "
     "time hardly."),
    ("Memory: a ten-minute clip", "render_memory.jsonl", memory_table,
     "`bench/render_memory.py`: the bundled clip looped, rendered to an mp4 for one earpoint. "
     "The limit is 600 MB."),
    ("The page of earpoint serve: from a drag to its sound", "page_latency.jsonl", page_table,
     "`web/measure.mjs`: drags on the map in Chromium without a window while the bundled clip plays; from the last "
     "movement to the first part of the sound that was made for it, the 90 ms that the page keeps ready included. The "
     "aim is 200 ms on two cores. The share of real time is the server's, request and answer included."),
    ("Load on the server of earpoint serve", "serve_load.jsonl", load_table,
     "`bench/serve_load.py`: wrk on one thread beside the server. A part is 43 ms of sound for a listener who has "
     "moved; parts of one listener wait for each other. Poses are posted until there are 10,000 or more, and the "
     "server's resident memory is read before and after. Slow connections send a byte of a header a second."),
    ("The bundled clip: four earpoints", "demo.json", demo_table,
     "`earpoint evaluate --earpoints examples/earpoints.json`: against the true sound, at 16 kHz. dsp is told "
     "where the speaker is, gtf nothing. Level is relative to the clip's. One clip in one home: an example, no "
     "comparison of methods."),
    ("The path tracer against physics", "trace_gates.md", None,
     "`trace_gates`: measured on the final impulse responses."),
    ("Speed: tracing a furnished home", "trace_bench.json", trace_table,
     "`trace_bench`: medians on one core. Both the tracer's rays and Embree's own end at the nearest "
     "surface; the tracer's include those that ask whether a listener is in sight."),
    ("The path tracer beside pyroomacoustics", "compare_tracers.json", tracer_comparison,
     "`bench/compare_tracers.py`: a room of 6 x 5 x 3 m, absorption 0.2, scattering 0.5, as a box and as "
     "meshes of the same walls; a mono response of 1 s in the octave of 1 kHz, both programs on one core in "
     "one run. What is right comes from neither: 400,000 particles that bounce between the walls, counted in a "
     "sphere at the microphone. The time of Earpoint is that of the whole process, that of pyroomacoustics "
     "(hybrid: image sources to order 3 in the box, rays) without starting Python. It has no tree over the "
     "walls, so that it gets fewer rays where there are many triangles."),
    ("Pictures per second on one core", "camera_bench.jsonl", camera_table,
     "`camera_bench`: 256 x 256 pixels, 4 rays per pixel, smoothed; seconds of processor time of one "
     "thread. The light of a home is solved once for its 10 conversations, that of two people once "
     "for the 4 views of a conversation; the last column counts both."),
    ("Killed at random moments", "kills.json", kill_table,
     "`bench/kill_anywhere.py`: each command is killed (SIGKILL) after a random part of its time and started "
     "again until it ends by itself. All files must then equal those of an undisturbed run, byte for byte (of weight "
     "files the tensors), with no file beside them."),
    ("Cost of simulated data", "simulate_cost.jsonl", simulation_table,
     "`bench/simulate_cost.py`: processor time of `earpoint simulate` in two homes, six conversations "
     "each; two speakers and four viewpoints a conversation, 5000 rays from each mouth, 256 x 256 "
     "pixels. The plan of a conversation, its acoustics (bodies put into the scene), trace, responses "
     "and light serve all of its viewpoints."),
    ("Cost of simulated sessions", "session_cost.jsonl", session_table,
     "`bench/session_cost.py`: processor time of `earpoint record simulate`, half a minute with three people "
     "and eight cameras of 480 x 270 pixels at 5 pictures a second. The flat, drawn once for all sessions, is "
     "in it; sound is what is left with next to no pictures."),
    ("Clocks of simulated sessions", "session_sync.jsonl", sync_table,
     "`bench/session_sync.py`: `earpoint record sync --truth` on sessions of `earpoint record simulate`, each in a "
     "flat of its own, with speech 10 dB above the ambient noise and clocks that drift by up to 50 ppm. 95th "
     "percentiles over devices, of offsets over every second of the session too."),
    ("Reverberation of homes", "home_reverberation.jsonl", reverberation_table,
     "`home_reverberation`: homes of the seeds 0 to 119, 500 and 1000 Hz. By Eyring's formula, the "
     "mean over a home's rooms by volume; and T30 of a traced response between two places 1 m or "
     "more apart in the largest room, every third home. Tracing says more: bare walls that face "
     "each other ring on, open doors couple rooms, and the formula counts the insides of "
     "furniture."),
]


def stamp(path):
    """When a file was measured, and the last commit before that where this is a checkout."""
    seconds = os.path.getmtime(path)
    commit = ""
    if shutil.which("git"):
        commit = subprocess.run(["git", "log", "-1", f"--before={int(seconds)}", "--format=%h"],
                                capture_output=True, text=True, check=False,
                                cwd=os.path.dirname(os.path.abspath(__file__))).stdout.strip()
    day = datetime.datetime.fromtimestamp(seconds, datetime.timezone.utc).date()
    return f"*Measured on {day}{' at ' + commit if commit else ''}.*"


def sections_of(path):
    """The sections that a page has, by title."""
    if not os.path.exists(path):
        return {}
    with open(path) as file:
        parts = file.read().split("\n## ")[1:]
    return {part.split("\n", 1)[0]: part.split("\n", 1)[1].strip() for part in parts}


def main():
    if len(sys.argv) not in (3, 4) or sys.argv[3:] not in ([], ["--measured-only"]):
        sys.exit(__doc__)
    folder, output = sys.argv[1:3]
    earlier = sections_of(output)
    text = ["# Results", "",
            f"Written by `./dev results` on {machine()}. Timings on another machine differ; ratios "
            "are measured in one run.", ""]
    for title, name, table, words in SECTIONS:
        content = read(folder, name)
        if content is None and sys.argv[3:]:
            continue
        if content is None and title in earlier:
            text += [f"## {title}", "", earlier[title], ""]
            continue
        if content is None:
            text += [f"## {title}", "", words, "", "*Not measured yet.*", ""]
            continue
        text += [f"## {title}", "", words, "", stamp(os.path.join(folder, name)), "",
                 table(content) if table else content, ""]
    with open(output, "w") as file:
        file.write("\n".join(text))


if __name__ == "__main__":
    main()
