#!/usr/bin/env python3
"""Puts together docs/results.md from what ./dev results has measured. Writes numbers, no judgement.

usage: bench/write_results.py MEASURED RESULTS.md [--measured-only]

MEASURED holds vigas.md, gtf_bench.json, training.json, training_gtf.json, oracle_errors.md, render_speed.jsonl,
render_memory.jsonl, demo.json, trace_gates.md, learning_curves-single.md, learning_curves-novel.md,
rt60_error.json, active_speaker.json, people_detection.jsonl, home_reverberation.jsonl, compare_tracers.json, kills.json,
change_of_results.md,
camera_bench.jsonl, simulate_cost.jsonl, session_cost.jsonl, evaluate-single.json, evaluate-novel.json, evaluate-recorded.json,
ablations-single.json, ablations-novel.json, generalisation.json,
generalisation_heads.json, ambient-single.json, ambient-novel.json, context-novel.json, separation-novel.md and enhance-novel.json; a section
whose file is missing stays as it is in RESULTS.md, or says so where it is new; with --measured-only it
is left out.
"""
import json
import os
import platform
import sys

from evaluation_tables import enhancement_table, evaluation_table


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


def training_table(text):
    rows = ["| layers x channels | picture | batch | Earpoint, clips/s | PyTorch, clips/s | times faster "
            "| processor-s per clip | PyTorch's |", "|---|---|---|---|---|---|---|---|"]
    for run in json.loads(text)["networks"]:
        ours, peer = run["earpoint"], run["peer"]
        picture = f"{run['picture_px']} px" if run["picture_px"] else "none"
        rows.append(f"| {run['layers']} x {run['channels']} | {picture} | {run['clips']} | "
                    f"{ours['clips_per_s']:.2f} | {peer['clips_per_s']:.2f} | "
                    f"{run['times_faster']:.2f} | {ours['processor_s_per_clip']:.3f} | "
                    f"{peer['processor_s_per_clip']:.3f} |")
    return "\n".join(rows)


def gtf_training_table(text):
    run = json.loads(text)
    rows = ["| build | --jobs | clips/s | processor-ms per clip | two busy cores could do |",
            "|---|---|---|---|---|"]
    for row in run["rows"]:
        ms = 1000 * row["processor_s_per_clip"]
        rows.append(f"| {row['build']} | {row['jobs'] or 'default'} | {row['clips_per_s']:.0f} | {ms:.1f} | "
                    f"{2000 / ms:.0f} clips/s |")
    return "\n".join(rows + ["", f"{run['cores']} cores; losses after the same steps differ by "
                             f"{run['loss_difference']:.0e} of themselves."])


def network_table(text):
    run = json.loads(text)
    gtf, vigas = run["gtf"], run["vigas"]
    rows = ["| network | threads | million multiply-adds | a second of sound | times real time |",
            "|---|---|---|---|---|",
            f"| gtf, with its picture | {gtf['threads']} | {gtf['million_multiply_adds']:.0f} | "
            f"{1000 * (gtf['window_s'] + gtf['picture_s']):.2f} ms | {gtf['times_real_time']:.0f} |",
            f"| gtf, hop by hop, the target moving at each | {gtf['threads']} | "
            f"{gtf['million_multiply_adds']:.0f} | {1000 * gtf['moving_stream_s']:.2f} ms | "
            f"{gtf['moving_times_real_time']:.0f} |",
            f"| ViGAS as released | {vigas['threads']} | {vigas['million_multiply_adds']:.0f} | "
            f"{1000 * vigas['window_s']:.1f} ms | {vigas['times_real_time']:.1f} |", "",
            f"gtf takes 1/{vigas['million_multiply_adds'] / gtf['million_multiply_adds']:.0f} of the "
            f"multiply-adds (aim 1/20)."]
    return "\n".join(rows)


def speed_table(text):
    rows = ["| model | sound | target | cores | wall time | times real time |", "|---|---|---|---|---|---|"]
    for line in text.splitlines():
        run = json.loads(line)
        rows.append(f"| {run['model']} | {run['clip_s']} s at {run['rate_hz'] / 1000:g} kHz | "
                    f"{'moving' if run['moving'] else 'still'} | {run['cores']} | {run['wall_s']:.1f} s | "
                    f"{run['times_real_time']:.0f} |")
    return "\n".join(rows)


def memory_table(text):
    rows = ["| model | clip | peak memory | wall time |", "|---|---|---|---|"]
    for line in text.splitlines():
        run = json.loads(line)
        rows.append(f"| {run['model']} | {run['clip_s']} s | {run['peak_mb']:.0f} MB | "
                    f"{run['wall_s']:.0f} s |")
    return "\n".join(rows)


def rt60_table(text):
    run = json.loads(text)
    rows = ["| true time | responses | mean absolute error |", "|---|---|---|"]
    for step in run["by_time"]:
        rows.append(f"| from {step['from_s']:.1f} s | {step['responses']} | {step['error_s']:.3f} s |")
    rows += [f"| **all** | {run['responses']} | **{run['error_s']:.3f} s** (aim 0.08) |", "",
             f"On average {run['bias_s']:+.3f} s off; always saying the median would be "
             f"{run['error_of_saying_the_median_s']:.3f} s off."]
    return "\n".join(rows)


def speaker_table(text):
    run = json.loads(text)
    def row(name, part):
        return (f"| {name} | {part['cases']} | {100 * part['right']:.1f} % | {100 * part['other']:.1f} % | "
                f"{100 * part['nobody']:.1f} % |")
    rows = [f"{run['detector']}, {run['seconds']:g} s of sound each.", "",
            "| the two people, as seen from the camera | cases | right | the other person | \"not in the picture\" |",
            "|---|---|---|---|---|"]
    for step in run["by_angle"]:
        upto = f"{step['from_deg']:.0f} to {step['to_deg']:.0f} degrees apart" if step["to_deg"] <= 180 else \
            f"{step['from_deg']:.0f} degrees and more apart"
        rows.append(row(upto, step))
    rows += [row("**15 degrees and more apart** (aim 90 %)", run["well_apart"]),
             row("one is out of the picture, the other speaks", run["one_in_sight"]),
             row("the speaker is out of the picture (right: saying so)", run["speaker_outside"]),
             row("**all** (aim 80 %)", run["all"]), "",
             "How sure it says to be, and how often it is right:", "", "| certainty | cases | right |", "|---|---|---|"]
    for step in run["by_certainty"]:
        if step["cases"]:
            rows.append(f"| {step['from']:.2f} to {min(step['to'], 1):.2f} | {step['cases']} | "
                        f"{100 * step['right']:.1f} % |")
    if run.get("gtf_told"):
        rows += ["", "gtf's mean errors over those of the unchanged source, by what it is told of the speaker:", "",
                 "| told | Mag | LRE | interaural delay |", "|---|---|---|---|"]
        for name, errors in run["gtf_told"].items():
            rows.append(f"| {name} | {errors['mag']:.3f} | {errors['lre_db']:.3f} | {errors['itd_us']:.3f} |")
    if run.get("mono_given"):
        rows += ["", "The source made mono, its voice put at a person and rendered by gtf: clips whose level between "
                 "the ears is within 2 dB of the truth (aim 80 %).", "", "| source | clips | within 2 dB | median error |",
                 "|---|---|---|---|"]
        for name, key in (("mono, at the true speaker", "mono_given"), ("mono, at the one who was found", "mono_found"),
                          ("binaural", "binaural")):
            part = run[key]
            rows.append(f"| {name} | {part['cases']} | {100 * part['within_2_db']:.1f} % | {part['median_db']:.2f} dB |")
    return "\n".join(rows)


def detection_table(text):
    names = {"people": "drawn", "novel": "views of conversations", "photographs": "photographs"}
    rows = ["| detector | pictures | | people | recall | precision | height at least 1/8: recall | 1/4 | 1/2 | "
            "processor-ms per picture |", "|---|---|---|---|---|---|---|---|---|---|"]
    for line in text.splitlines():
        run = json.loads(line)
        clear = run["unoccluded"]
        # Views of conversations do not tell who is hidden: everybody with a box counts.
        known = clear["people"] > 0
        count = clear if known else run["all"]
        heights = [f"{step['recall']:.3f}" if known and step["people"] else "-"
                   for step in run["by_height"][1:]]
        rows.append(f"| {run['detector']} | {names[run['data']]} | {run['pictures']} | {count['people']} | "
                    f"{count['recall']:.3f} | {count['precision']:.3f} | {' | '.join(heights)} | "
                    f"{run['processor_ms_per_picture']:.1f} |")
    return "\n".join(rows)


def demo_table(text):
    rows = ["| earpoint | truly: level, left-right (dB) | method | level error (dB) | LRE (dB) | Mag | RTE (s) |",
            "|---|---|---|---|---|---|---|"]
    for earpoint in json.loads(text)["earpoints"]:
        truth = earpoint["truth"]
        for run in earpoint["methods"]:
            errors = run["errors"]
            rows.append(f"| {earpoint['name']} | {truth['level_db']:+.1f}, {truth['left_right_db']:+.1f} | "
                        f"{run['method']} | {errors['level_db']:.1f} | {errors['lre_db']:.1f} | "
                        f"{errors['mag']:.3f} | {errors['rte_s']:.3f} |")
    return "\n".join(rows)


def reverberation_table(text):
    homes = [json.loads(line) for line in text.splitlines()]
    eyring = sorted(home["eyring_s"] for home in homes)
    traced = sorted(home["room_t30_s"] for home in homes if "room_t30_s" in home)
    rows = ["| seconds | homes, Eyring | | rooms, traced T30 | |", "|---|---|---|---|---|"]
    for tenth in range(int(10 * max(eyring + traced)) + 1):
        cells = [f"{tenth / 10:.1f} to {(tenth + 1) / 10:.1f}"]
        for values in (eyring, traced):
            count = sum(int(10 * value) == tenth for value in values)
            cells += [str(count), "#" * round(50 * count / len(values))]
        rows.append("| " + " | ".join(cells) + " |")
    rows += ["", ", ".join(
        f"{name}: {len(values)}, from {values[0]:.2f} to {values[-1]:.2f} s, "
        f"median {values[len(values) // 2]:.2f} s"
        for name, values in (("Eyring", eyring), ("traced", traced))) + "."]
    return "\n".join(rows)


def generalisation_table(text):
    """gtf's errors as ratios to those of the unchanged input, one row a case."""
    columns = [("mag", "Mag"), ("lre_db", "LRE"), ("level_db", "level"), ("itd_us", "ITD"),
               ("c50_db", "C50")]
    rows = ["| | case | clips | " + " | ".join(heading for _, heading in columns)
            + " | Mag, dsp | LRE, dsp |", "|---" * (len(columns) + 5) + "|"]

    def cell(method, key):
        ratio = method.get(key) or {}
        if ratio.get("ratio") is None:
            return "–"
        if ratio.get("low") is None:
            return f"{ratio['ratio']:.2f}"
        return f"{ratio['ratio']:.2f} [{ratio['low']:.2f}, {ratio['high']:.2f}]"

    for row in json.loads(text)["rows"]:
        gtf, dsp = row["methods"]["gtf"], row["methods"]["dsp"]
        cells = [row["group"], row["case"], str(row["clips"])]
        cells += [cell(gtf, key) for key, _ in columns] + [cell(dsp, "mag"), cell(dsp, "lre_db")]
        rows.append("| " + " | ".join(cells) + " |")
    return "\n".join(rows)


def trace_table(text):
    run = json.loads(text)
    home = run["home"]
    rows = ["| | measured | aim |", "|---|---|---|",
            f"| rays per second on one core, synthesis of the responses included | "
            f"{run['rays_per_s'] / 1e6:.2f} M | |",
            f"| a bare Embree loop, the same mesh and run | {run['bare_rays_per_s'] / 1e6:.2f} M | |",
            f"| share | {100 * run['rays_per_s'] / run['bare_rays_per_s']:.0f} % | 60 % |",
            f"| one BRIR of 1 s: {home['triangles']} triangles, {home['rays']} rays, 60 bounces, "
            f"one of {home['pairs']} pairs | {home['core_s_per_pair']:.3f} core-s | 0.25 core-s |",
            f"| of that, tracing | {home['trace_s'] / home['pairs']:.3f} core-s | |",
            f"| a home's tree and edges, once | {home['build_s']:.3f} core-s | |",
            "", "![Core-seconds per pair over triangles, rays and pairs](images/trace-cost.png)"]
    return "\n".join(rows)


def tracer_comparison(text):
    run = json.loads(text)
    rows = ["| room | program | rays | T30 off by | its spread | reverberation re direct sound off by "
            "| processor-s |", "|---|---|---|---|---|---|---|"]
    for case in run["rows"]:
        room = "box" if case["box"] else f"mesh of {case['triangles']} triangles"
        for name, key in ((f"Earpoint {run['earpoint']}", "earpoint"),
                          (f"pyroomacoustics {run['pyroomacoustics']}", "peer")):
            found = case[key]
            rows.append(f"| {room} | {name} | {found['rays']} | {found['t30_error_percent']:+.1f} % | "
                        f"{found['t30_spread_percent']:.1f} % | {found['level_error_db']:+.1f} dB | "
                        f"{found['processor_s']:.2f} |")
    return "\n".join(rows + ["", f"{run['runs']} seeds each. By the particles: T30 {run['t30_s']:.3f} s, "
                             f"reverberation {run['level_db']:.1f} dB over the direct sound."])


def kill_table(text):
    rows = ["| command | killed | files | lost, left over or different | undisturbed |", "|---|---|---|---|---|"]
    for run in json.loads(text):
        rows.append(f"| {run['command']} | {run['kills']} times | {run['files']} | {len(run['faults'])} | "
                    f"{run['undisturbed_s']:.1f} s |")
    return "\n".join(rows)


def camera_table(text):
    rows = ["| homes | triangles | light of a home | with two people | views/s | views/s, light included |",
            "|---|---|---|---|---|---|"]
    for line in text.splitlines():
        run = json.loads(line)
        rows.append(f"| {run['homes']} | {run['triangles']} | {run['home_light_s']:.2f} s | "
                    f"{run['people_light_s']:.3f} s | {run['views_per_s']:.1f} | "
                    f"{run['views_per_s_with_light']:.1f} |")
    rows += ["", "![Views of conversations in homes](images/homes.jpg)", "",
             "Drawn by `./dev pictures`: the homes of the seeds from 100 on, one view each."]
    return "\n".join(rows)


def simulation_table(text):
    run = json.loads(text.splitlines()[-1])
    stages = run["core_s_per_viewpoint_by_stage"]
    rows = ["| core-seconds per viewpoint | " + " | ".join(stages) + " | together |",
            "|---" * (len(stages) + 2) + "|",
            f"| {run['viewpoints']} viewpoints | "
            + " | ".join(f"{seconds:.3f}" for seconds in stages.values())
            + f" | {run['core_s_per_viewpoint']:.2f} |", "",
            f"A home takes {run['core_s_per_scene']:.1f} core-seconds, once. At this rate the paper's "
            f"120 scenes and 200,000 viewpoints take {run['paper_core_hours']:.0f} core-hours; with the "
            f"gathered speech they hold {run['paper_hours_of_sound']:.0f} hours of sound."]
    return "\n".join(rows)


def session_table(text):
    run = json.loads(text.splitlines()[-1])
    return "\n".join([
        "| core-seconds per minute | of them sound | minutes that two cores make in an hour |", "|---|---|---|",
        f"| {run['core_s_per_minute']:.0f} | {run['core_s_per_minute_without_pictures']:.0f} "
        f"| {run['minutes_per_hour_on_two_cores']:.0f} |"])


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
    ("Reverberation of homes", "home_reverberation.jsonl", reverberation_table,
     "`home_reverberation`: homes of the seeds 0 to 119, 500 and 1000 Hz. By Eyring's formula, the "
     "mean over a home's rooms by volume; and T30 of a traced response between two places 1 m or "
     "more apart in the largest room, every third home. Tracing says more: bare walls that face "
     "each other ring on, open doors couple rooms, and the formula counts the insides of "
     "furniture."),
]


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
        measured = "*Not measured yet.*" if content is None else table(content) if table else content
        text += [f"## {title}", "", words, "", measured, ""]
    with open(output, "w") as file:
        file.write("\n".join(text))


if __name__ == "__main__":
    main()
