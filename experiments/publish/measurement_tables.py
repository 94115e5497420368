"""Markdown tables from what the benchmarks write."""
import json


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
    return "\n".join(rows + ["", f"{run['cores']} cores; relative difference of the losses after the "
                             f"same steps: {run['loss_difference']:.0e}."])


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
            f"multiply-adds (goal 1/20)."]
    return "\n".join(rows)


def speed_table(text):
    rows = ["| model | sound | target | cores | wall time | times real time |", "|---|---|---|---|---|---|"]
    for line in text.splitlines():
        run = json.loads(line)
        rows.append(f"| {run['model']} | {run['clip_s']} s at {run['rate_hz'] / 1000:g} kHz | "
                    f"{'moving' if run['moving'] else 'still'} | {run['cores']} | {run['wall_s']:.1f} s | "
                    f"{run['times_real_time']:.0f} |")
    return "\n".join(rows)


def page_table(text):
    rows = ["| method | drags | median | 95th percentile | share of real time |", "|---|---|---|---|---|"]
    for line in text.splitlines():
        run = json.loads(line)
        rows.append(f"| {run['method']} | {run['drags']} | {run['median_ms']} ms | {run['p95_ms']} ms | "
                    f"{100 * run['real_time_share']:.0f} % |")
    return "\n".join(rows)


def load_table(text):
    rows = ["| load | requests/s | median | 99th percentile | failed | |", "|---|---|---|---|---|---|"]
    for line in text.splitlines():
        run = json.loads(line)
        if "poses" in run:
            rows.append(f"| {run['poses']} {run['load']} | | | | | memory {run['memory_before_mb']:.1f} MB, then "
                        f"{run['memory_after_mb']:.1f} MB |")
            continue
        more = f"slow ones ended after {run['slow_ended_after_s']:.0f} s" if "slow_ended_after_s" in run else ""
        rows.append(f"| {run['load']} | {run['requests'] / run['seconds']:.0f} | {run['p50_ms']:.0f} ms | "
                    f"{run['p99_ms']:.0f} ms | {run['failed'] + run['timeouts']} | {more} |")
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
    rows += [f"| **all** | {run['responses']} | **{run['error_s']:.3f} s** (goal 0.08) |", "",
             f"Bias {run['bias_s']:+.3f} s; an estimator that always returns the median has an error of "
             f"{run['error_of_saying_the_median_s']:.3f} s."]
    return "\n".join(rows)


def position_table(text):
    rows = ["| told | pairs | azimuth | distance | facing |", "|---|---|---|---|---|"]
    for row in json.loads(text)["rows"]:
        def quantiles(part, unit, scale=1):
            return ", ".join(f"{scale * part[key]:.{1 if part[key] * scale < 10 else 0}f}{unit}"
                             for key in ("median", "three_quarters", "nine_tenths"))
        rows.append(f"| {'the true box' if row['box'] else 'nothing'} | {row['pairs']} | "
                    f"{quantiles(row['azimuth_deg'], '°')} | {quantiles(row['distance_ratio'], ' %', 100)} | "
                    f"{quantiles(row['heading_deg'], '°')} |")
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
    rows += [row("**15 degrees and more apart** (goal 90 %)", run["well_apart"]),
             row("one is out of the picture, the other speaks", run["one_in_sight"]),
             row("the speaker is out of the picture (right: saying so)", run["speaker_outside"]),
             row("**all** (goal 80 %)", run["all"]), "",
             "The certainty that is stated, and how often the answer is right:", "", "| certainty | cases | right |", "|---|---|---|"]
    for step in run["by_certainty"]:
        if step["cases"]:
            rows.append(f"| {step['from']:.2f} to {min(step['to'], 1):.2f} | {step['cases']} | "
                        f"{100 * step['right']:.1f} % |")
    if run.get("gtf_told"):
        rows += ["", "gtf's mean errors over those of the unchanged source, by what it gets of the speaker:", "",
                 "| told | Mag | LRE | interaural delay |", "|---|---|---|---|"]
        for name, errors in run["gtf_told"].items():
            rows.append(f"| {name} | {errors['mag']:.3f} | {errors['lre_db']:.3f} | {errors['itd_us']:.3f} |")
    if run.get("mono_given"):
        rows += ["", "The source made mono, its voice placed at a person and rendered by gtf: clips whose interaural "
                 "level difference is within 2 dB of the truth (goal 80 %).", "", "| source | clips | within 2 dB | median error |",
                 "|---|---|---|---|"]
        for name, key in (("mono, at the true speaker", "mono_given"), ("mono, at the person found", "mono_found"),
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
        # It is unknown who is hidden in views of conversations: everybody with a box counts.
        known = clear["people"] > 0
        count = clear if known else run["all"]
        heights = [f"{step['recall']:.3f}" if known and step["people"] else "-"
                   for step in run["by_height"][1:]]
        rows.append(f"| {run['detector']} | {names[run['data']]} | {run['pictures']} | {count['people']} | "
                    f"{count['recall']:.3f} | {count['precision']:.3f} | {' | '.join(heights)} | "
                    f"{run['processor_ms_per_picture']:.1f} |")
    return "\n".join(rows)


def python_table(text):
    rows = ["| | reference, processor-ms | in Python, processor-ms | ratio | goal |", "|---|---|---|---|---|"]
    for line in text.splitlines():
        run = json.loads(line)
        if "clip_s" in run:
            name = f"{run['clip_s']} s of sound: `earpoint render`, and `earpoint.render` without imports"
            reference, ours = run["program_s"], run["package_s"] - run["import_s"]
        else:
            name = f"1 s live: one block, and {run['what'].removeprefix('stream in ')} samples"
            reference, ours = run["one_block_s"], run["blocks_s"] - run["slices_s"]
        rows.append(f"| {name} | {1000 * reference:.1f} | {1000 * ours:.1f} | {run['ratio']:.3f} | 1.05 |")
    return "\n".join(rows)


def session_people_table(text):
    rows = ["| detector | sessions | pictures | people | recall | precision | switches | moments | the speaker is right | "
            "outside the picture, wrongly |", "|" + "---|" * 10]
    for line in text.splitlines():
        run = json.loads(line)
        rows.append(f"| {run['detector']} | {run['sessions']} | {run['pictures']} | {run['people']} | "
                    f"{run['recall']:.3f} | {run['precision']:.3f} | {run['switches']} | {run['moments']} | "
                    f"{100 * run['speaker_right']:.1f} % | {100 * run['nobody'] / max(1, run['moments']):.1f} % |")
    return "\n".join(rows)


def demo_table(text):
    rows = ["| earpoint | true level, left-right (dB) | method | level error (dB) | LRE (dB) | Mag | RTE (s) |",
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
    rows = ["| | measured | goal |", "|---|---|---|",
            f"| rays per second on one core, synthesis of the responses included | "
            f"{run['rays_per_s'] / 1e6:.2f} M | |",
            f"| a bare Embree loop, the same mesh and run | {run['bare_rays_per_s'] / 1e6:.2f} M | |",
            f"| share | {100 * run['rays_per_s'] / run['bare_rays_per_s']:.0f} % | 60 % |",
            f"| one BRIR of 1 s: {home['triangles']} triangles, {home['rays']} rays, 60 bounces, "
            f"one of {home['pairs']} pairs | {home['core_s_per_pair']:.3f} core-s | 0.25 core-s |",
            f"| of that, tracing | {home['trace_s'] / home['pairs']:.3f} core-s | |",
            f"| a home's tree and edges, once | {home['build_s']:.3f} core-s | |",
            "", "![Core-seconds per pair over triangles, rays and pairs](../images/trace-cost.png)"]
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
    rows += ["", "![Views of conversations in homes](../images/homes.jpg)", "",
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
        "| core-seconds per minute | of that, sound | minutes that two cores make in an hour |", "|---|---|---|",
        f"| {run['core_s_per_minute']:.0f} | {run['core_s_per_minute_without_pictures']:.0f} "
        f"| {run['minutes_per_hour_on_two_cores']:.0f} |"])


def sync_table(text):
    rows = ["| session | minutes | speech above noise, dB | people | cameras | offset error, ms | drift error, ppm |",
            "|---" * 7 + "|"]
    for line in text.splitlines():
        run = json.loads(line)
        rows.append(f"| {run['session']} | {run['minutes']:g} | {run['snr_db']:g} | {run['people']} | {run['cameras']} "
                    f"| {run['offset_error_ms_p95']:.2f} | {run['drift_error_ppm_p95']:.2f} |")
    return "\n".join(rows)
