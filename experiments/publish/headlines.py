"""The headline numbers: taken from the tables of the pages behind them, with interval, day and commit."""
from typing import Callable, NamedTuple

from markdown_tables import estimate, ratio_table, tables_of
from result_pages import is_older, newest_day
from result_sections import PAGES


class Headline(NamedTuple):
    what: str
    section: str
    value: Callable  # from a section's content to text; KeyError, IndexError: the section has no such number


def with_interval(found):
    text = f"**{found.value:.2f}**"
    return (text if found.low is None else f"{text} [{found.low:.2f}, {found.high:.2f}]") + " of input"


def ratio(row_label, name, column):
    """The ratio to `input` in the row and column of these names."""
    def value(content):
        row = {row.get(row_label, ""): row for row in ratio_table(content)}[name]
        found = estimate(row[column])
        if found is None:
            raise KeyError(column)
        return with_interval(found)
    return value


def cell(column, where, first=0):
    """The first cell of a column in a row that has all these values, in the table of that index."""
    def value(content):
        rows = [row for row in tables_of(content)[first]
                if all(row.get(key) == wanted for key, wanted in where.items())]
        return rows[0][column]
    return value


def bold(value, after=""):
    return lambda content: f"**{value(content).split('** ')[0].strip('*')}**{after}"


def gates(content):
    rows = tables_of(content)[0]
    return f"**{sum(row[''] == 'ok' for row in rows)} of {len(rows)}** checks hold"


def kills(content):
    rows = tables_of(content)[0]
    count = sum(int(row["killed"].split()[0]) for row in rows)
    faults = sum(int(row["lost, left over or different"]) for row in rows)
    return f"**{faults}** faulty files after {count} kills"


def largest_error(content):
    return f"**{max(float(row['largest error']) for row in tables_of(content)[0]):.0e}**"


def times_slower(content):
    """How many times slower the peer is as a whole, from the two times of the table."""
    rows = {row[""]: float(row["whole, ms"]) for row in tables_of(content)[0]}
    return f"**{rows['PyTorch, last head, tuned allocator'] / rows['Earpoint']:.1f}** times faster"


def all_people(content):
    row = next(row for row in tables_of(content)[0] if row["the two people, as seen from the camera"].startswith("**all"))
    return f"**{row['right']}** of {row['cases']} seconds"


NOVEL = "Methods in unseen homes"
LRE_OF_GTF = ratio("method", "gtf", "LRE (dB)")
GTF_SPEED = bold(cell("times real time", {"model": "gtf", "sound": "600 s at 48 kHz", "target": "still", "cores": "1"}),
                 " times real time")
HEADLINES = [
    Headline("gtf in unseen homes: Mag, the magnitude distance", NOVEL, ratio("method", "gtf", "Mag")),
    Headline("gtf in unseen homes: LRE, the error of the left-right energy ratio", NOVEL, LRE_OF_GTF),
    Headline("gtf in unseen homes: error of the interaural time difference", NOVEL, ratio("method", "gtf", "ITD (us)")),
    Headline("gtf in unseen homes: RTE, the error of the reverberation time", NOVEL, ratio("method", "gtf", "RTE (s)")),
    Headline("ViGAS, trained here, in unseen homes: Mag", NOVEL, ratio("method", "vigas", "Mag")),
    Headline("gtf with the box of the wrong person: LRE", "Generalisation",
             ratio("case", "the other person's", "LRE")),
    Headline("speech enhancement by gtf: RTE", "Speech enhancement in unseen homes",
             ratio("method", "gtf", "RTE (s)")),
    Headline("who speaks, found by picture and sound", "Who speaks, in unseen homes", all_people),
    Headline("reverberation time from speech: mean absolute error", "Reverberation time from sound",
             bold(cell("mean absolute error", {"true time": "**all**"}))),
    Headline("largest difference to the authors' ViGAS code", "Exactness: our engine against the authors' code",
             largest_error),
    Headline("`earpoint render` with gtf, 48 kHz, one core", "Speed: rendering a clip",
             GTF_SPEED),
    Headline("one second through the released ViGAS, against PyTorch", "Speed: one second of sound through the released network",
             times_slower),
    Headline("peak memory of a ten-minute clip, ViGAS", "Memory: a ten-minute clip",
             bold(cell("peak memory", {"model": "vigas"}))),
    Headline("the path tracer against physics", "The path tracer against physics", gates),
    Headline("one binaural response of 1 s in a furnished home", "Speed: tracing a furnished home",
             bold(lambda content: next(row["measured"] for row in tables_of(content)[0]
                                       if row[""].startswith("one BRIR")))),
    Headline("commands killed at random moments and restarted", "Killed at random moments", kills),
]

# The numbers that README shows.
README = [(NOVEL, LRE_OF_GTF, "error of the left-right energy ratio with `gtf` in homes that it was not trained "
           "on, over that of the unchanged recording"),
          ("Speed: rendering a clip", GTF_SPEED, "`gtf` on one core, at 48 kHz, reading and writing included"),
          ("Exactness: our engine against the authors' code", largest_error,
           "largest difference between our ViGAS engine and the authors' released code")]


def anchor(title):
    """The fragment that GitHub makes of a heading."""
    kept = "".join(c for c in title.lower() if c.isalnum() or c in " -_")
    return kept.replace(" ", "-")


def link(title, folder="results/"):
    page = next(page for page in PAGES if any(section.title == title for section in page.sections))
    return f"{folder}{page.name}.md#{anchor(title)}"


def value_of(section, value, measured):
    state = measured.get(section)
    if state is None:
        return None
    try:
        return value(state.content)
    except (KeyError, IndexError, StopIteration):
        return None


def headline_table(measured):
    newest = newest_day(measured)
    lines = ["| what | value [95 % interval] | measured | more |", "|---|---|---|---|"]
    for headline in HEADLINES:
        value = value_of(headline.section, headline.value, measured)
        if value is None:
            continue
        state = measured[headline.section]
        when = state.brief() + (" (older)" if is_older(state, newest) else "")
        lines.append(f"| {headline.what} | {value} | {when} | "
                     f"[{headline.section.split(':')[0]}]({link(headline.section)}) |")
    return lines


def readme_lines(measured):
    """Three numbers for README, each with a link to its page."""
    values = [(value_of(section, value, measured), section, words) for section, value, words in README]
    return [f"- {value.removesuffix(' of input')}: {words} ([where measured]({link(section, 'docs/results/')}))"
            for value, section, words in values if value]
