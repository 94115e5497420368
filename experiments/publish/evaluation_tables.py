"""Markdown tables from what `earpoint evaluate --json` prints."""
import json

# Key in the JSON, heading, decimals.
METRICS = [("mag", "Mag", 4), ("lre_db", "LRE (dB)", 2), ("rte_s", "RTE (s)", 4),
           ("level_db", "level (dB)", 2), ("itd_us", "ITD (us)", 0), ("edt_s", "EDT (s)", 3),
           ("c50_db", "C50 (dB)", 2)]
RELEASED = [("mag", "Mag", 4), ("lre_db", "LRE (dB)", 2), ("rte_s", "RTE (s)", 4),
            ("stft_distance", "STFT distance", 1), ("l2", "L2", 5), ("delay_samples", "delay", 1)]


def present(rows, metrics):
    return [metric for metric in metrics if any(metric[0] in row for row in rows)]


def with_range(cell, key, decimals):
    if not cell or cell[key] is None:
        return "–"
    text = f"{cell[key]:.{decimals}f}"
    if cell["low"] is None:
        return text
    return f"{text} [{cell['low']:.{decimals}f}, {cell['high']:.{decimals}f}]"


def table(rows, metrics, cell):
    metrics = present(rows, metrics)
    lines = ["| method | " + " | ".join(heading for _, heading, _ in metrics) + " |",
             "|---" * (len(metrics) + 1) + "|"]
    for row in rows:
        cells = [cell(row, key, decimals) for key, _, decimals in metrics]
        lines.append(f"| {row['method']} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def counted(count, noun):
    return f"{count} {noun}" + ("" if count == 1 else "s")


def extent(run):
    """What was measured: clips, conversations, homes and voices."""
    text = f"{counted(run['clips'], 'clip')} of {counted(run['conversations'], 'conversation')}"
    if run.get("homes"):
        text += f" in {counted(run['homes'], 'home')}"
    if run.get("voices"):
        text += f", {counted(run['voices'], 'voice')}"
    return text + f", split {run['split']}"


def session_extent(run):
    """The same of recorded sessions, each of which `evaluate` counts as a home."""
    return f"{counted(run['clips'], 'clip')} of {counted(run['homes'], 'session')}, split {run['split']}"


def intervals(run, drawn_by=None):
    """What is resampled for the intervals, and which means are over fewer clips."""
    fewer = {heading: min(row[key]["clips"] for row in run["rows"] if row.get(key))
             for key, heading, _ in METRICS if any(row.get(key) for row in run["rows"])}
    text = f"Intervals are drawn by {drawn_by or run.get('intervals_by', 'conversation')}."
    few = [f"{heading} {count}" for heading, count in fewer.items() if count < run["clips"]]
    return text + (f" Means over fewer clips, those that have a value: {', '.join(few)}." if few else "")


def enhancement_table(text):
    """Means and ratios to `input` of what enhancement is measured by."""
    run = json.loads(text)
    return enhancement_tables(run, f"{extent(run)}, room noise of {run['ambient_db']:g} dB.", intervals(run))


def recorded_enhancement_table(text):
    """The same of recorded sessions."""
    run = json.loads(text)
    # The level of the target is that of the source.
    return enhancement_tables(run, f"{session_extent(run)}.", intervals(run, "session"), without=("level_db",))


def enhancement_tables(run, data, drawn, without=()):
    metrics = [column for column in (("mag", "Mag", 4), ("rte_s", "RTE (s)", 4), ("level_db", "level (dB)", 2))
               if column[0] not in without]
    speech = [("si_sdr_db", "SI-SDR (dB)", 1), ("estoi", "ESTOI", 3)]
    return "\n".join([
        f"{data} Mean error with its 95 % interval; 0 is best, and more of SI-SDR and ESTOI. {drawn}", "",
        table(run["rows"], metrics + speech, lambda row, key, d: with_range(row.get(key), "mean", d)), "",
        "As ratio to `input` (the paper's on Replay-NVAS: Mag 0.84, RTE 0.32):", "",
        table(run["rows"], metrics,
              lambda row, key, d: with_range(row.get(key, {}).get("ratio"), "value", 2))])


def evaluation_table(text):
    """Means, ratios to `input` and the released evaluation's numbers, one table each."""
    run = json.loads(text)
    return tables_of(run, f"{extent(run)}. Mean error with its 95 % interval; 0 is best. {intervals(run)}")


def recorded_table(text):
    """The same of recorded sessions."""
    run = json.loads(text)
    return tables_of(run, f"{session_extent(run)}. Mean error with its 95 % interval; 0 is best. "
                     f"{intervals(run, 'session')}")


def documents(text):
    """The JSON documents that a file holds one behind the other."""
    found, decoder, at = [], json.JSONDecoder(), 0
    while text[at:].strip():
        at += len(text[at:]) - len(text[at:].lstrip())
        document, at = decoder.raw_decode(text, at)
        found.append(document)
    return found


def recorded_boxes_table(text):
    """Ratios to `input` of the same methods in recorded sessions, told different boxes."""
    runs = documents(text)
    return ratios_by_boxes(runs, session_extent(runs[0]), intervals(runs[0], "session"))


def boxes_table(text):
    """The same in homes."""
    runs = documents(text)
    return ratios_by_boxes(runs, extent(runs[0]), intervals(runs[0]))


def ratios_by_boxes(runs, data, drawn):
    rows = [f"{data}. Mean error as ratio to `input`, with its 95 % interval. {drawn}", ""]
    columns = [column for column in METRICS if any(row.get(column[0]) for row in runs[0]["rows"])]
    rows += ["| boxes | method | " + " | ".join(heading for _, heading, _ in columns) + " |",
             "|---" * (2 + len(columns)) + "|"]
    for run in runs:
        for row in run["rows"]:
            if row["method"] != "input":
                cells = [with_range(row.get(key, {}).get("ratio"), "value", 2) for key, _, _ in columns]
                rows.append(f"| {run['boxes']} | {row['method']} | " + " | ".join(cells) + " |")
    return "\n".join(rows)


def tables_of(run, heading):
    rows = run["rows"]
    parts = [heading, "",
             table(rows, METRICS, lambda row, key, d: with_range(row.get(key), "mean", d)), "",
             "As ratio to `input`:", "",
             table(rows, METRICS,
                   lambda row, key, d: with_range(row.get(key, {}).get("ratio"), "value", 2)), "",
             "With the published evaluation's use of the target (it corrects signs, and delays on Replay-NVAS):", "",
             table(rows, RELEASED,
                   lambda row, key, d: f"{row['released'][key]['mean']:.{d}f}"
                   if row["released"].get(key) else "–")]
    if run["skipped"]:
        parts += ["", f"{len(run['skipped'])} pairs could not be read and were left out."]
    return "\n".join(parts)
