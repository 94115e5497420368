"""The contents of the pages behind docs/results.md: their sections, the file of each, and the text above it."""
from dataclasses import dataclass
from typing import Callable, NamedTuple, Optional

from evaluation_tables import (boxes_table, enhancement_table, evaluation_table, recorded_boxes_table,
                               recorded_enhancement_table, recorded_table)
from measurement_tables import (camera_table, demo_table, detection_table, generalisation_table,
                                gtf_training_table, kill_table, load_table, memory_table,
                                network_table, page_table, position_table, python_table, reverberation_table, rt60_table,
                                session_people_table, session_table, simulation_table,
                                speaker_table, speed_table, sync_table, trace_table,
                                tracer_comparison, training_table)


class Plot(NamedTuple):
    """A picture of ratios to `input` that stands above the tables of a section."""
    name: str               # of the SVG in images/
    columns: tuple          # headings in the table, one panel each
    labels: tuple = ("method",)  # headings whose cells name a row


@dataclass
class Section:
    title: str
    file: str                        # in the folder of what was measured
    table: Optional[Callable]        # from the file's text to Markdown; None: it is Markdown
    words: str
    plot: Optional[Plot] = None


@dataclass
class Page:
    name: str                        # docs/results/NAME.md
    title: str
    words: str
    sections: list


RATIOS = ("Mag", "LRE (dB)", "RTE (s)")
EVALUATION_WORDS = (
    "`earpoint evaluate --oracles --json` on the frozen pairs of the test split. Intervals are bootstrapped by home "
    "where there are several, else by conversation, because clips of one home share rooms, positions and voices. "
    "Networks are told the speaker's true box, dsp and tf the true position. gtf and vigas are the shipped networks. "
    "A gtf that was trained for two textures has three rows: `gtf` is the natural one, `gtf:mean` the mean, and `gtf:0.5` "
    "lies between ([how gtf works](../method.md)). "
    "Oracles are given part of the answer: they show how much of the error could be removed. ")

METHODS = Page("methods", "Methods", "Errors of every method on the same pairs, beside the unchanged input, baselines "
               "and oracles.", [
    Section("Methods in unseen homes", "evaluate-novel.json", evaluation_table,
            EVALUATION_WORDS + "Homes and speakers of the test split are in no other split. Networks called -anew were trained "
            "by `./dev results` itself, from random weights.",
            Plot("methods-novel", RATIOS)),
    Section("Methods in one home", "evaluate-single.json", evaluation_table,
            EVALUATION_WORDS + "One home, split by conversation; voices of the test split are in no other split. The shipped "
            "networks were not trained on this home; those called -adapted were trained on from there with its clips, as long as "
            "*[Learning curves in one home](#learning-curves-in-one-home)* says; networks called -one-home have heard this home "
            "alone: vam 9,600 clips, the two ViGAS 3,200 with sound, those of "
            "*[the ablations](ablations.md#ablations-in-one-home)*.",
            Plot("methods-single", RATIOS)),
    Section("Methods in unseen homes, with preceding sound", "context-novel.json", evaluation_table,
            "`earpoint evaluate --context 4 --json`: the same pairs, but `dsp` and networks also get the four seconds "
            "before the second that is compared, in overlapping windows that are cross-faded, as in a long recording.",
            Plot("methods-context-novel", RATIOS)),
    Section("Methods farther away and in other rooms", "places.jsonl", boxes_table,
            "`earpoint evaluate --boxes detected|true|none` on homes of the test split with viewpoints up to 5 m from the "
            "people (2.5 m in *Methods in unseen homes*), three in ten of them in other rooms (`earpoint simulate --reach 5 "
            "--other-rooms 0.3 --seed 99`). detected: people are found in the picture, as `render` does; true: the speaker's box "
            "is given; none: nothing is. `gtf:0.5` lies between the two textures."),
    Section("Learning curves in one home", "learning_curves-single.md", None,
            "`experiments/publish/learning_curves.py`: Mag on 256 validation pairs while `earpoint train` runs on one core "
            "beside other work, so minutes are upper bounds. Validation of gtf uses the natural texture, whose loss has "
            "terms that Mag does not measure. ViGAS is first trained to locate the speaker, without producing sound, and "
            "gtf-adapted starts from a gtf that was; those clips do not count. Networks called -adapted start from shipped "
            "weights. ![Error over clips seen](../images/learning-curves-single.svg)"),
    Section("Learning curves in unseen homes", "learning_curves-novel.md", None,
            "`experiments/publish/learning_curves.py`, as above. gtf goes on from gtf-begun (gtf-magnitude in older tables): its "
            "clips are those of its own part. "
            "![Error over clips seen](../images/learning-curves-novel.svg)"),
    Section("Speech enhancement in unseen homes", "enhance-novel.json", enhancement_table,
            "`earpoint evaluate --enhance --json`: the target is the speaker's near microphone, the dry speech at its "
            "level 1 m in front of the mouth in free field. gtf is the network that `earpoint enhance` uses, gtf:mean its mean "
            "texture, gtf-anew one of `configs/enhance.json`; vigas is a small ViGAS that was trained further on fewer such clips. "
            "`oracle-gain` is the source at the true level: what a change of level alone would bring.",
            Plot("methods-enhance", RATIOS)),
    Section("The bundled clip: four earpoints", "demo.json", demo_table,
            "`earpoint evaluate --earpoints examples/earpoints.json`: against the true sound, at 16 kHz. dsp is given "
            "the speaker's position; for gtf the speaker is found in the picture. Level is relative to the clip's. One clip "
            "in one home: an example, not a comparison of methods."),
    Section("Reverberation time from sound", "rt60_error.json", rt60_table,
            "`rt60_error DATA test`: the estimator that RTE is computed with, on simulated speech of homes and "
            "voices it was not trained on, against the reverberation time of the response."),
])

ABLATIONS = Page("ablations", "Ablations", "The networks without one of their parts.", [
    Section("Ablations in unseen homes", "ablations-novel.json", evaluation_table,
            "`earpoint evaluate --ablations --json`: the network without one of its parts, after a short training. Rows can be "
            "compared with each other, not with other tables.",
            Plot("ablations-novel", RATIOS)),
    Section("Ablations in one home", "ablations-single.json", evaluation_table,
            "`earpoint evaluate --ablations --json`, as above: gtf after 16,000 clips, three times with other seeds, its "
            "natural texture; ViGAS after 4,800 clips without sound and 3,200 with it. All from random weights.",
            Plot("ablations-single", RATIOS)),
    Section("Ablations in recorded sessions", "ablations-recorded.json", recorded_table,
            "`earpoint evaluate --layout replay --ablations --json`: ViGAS without one of its parts, half as wide as the other "
            "small ViGAS, trained on 3,200 clips of *[recorded sessions](people-and-recordings.md#methods-in-recorded-sessions)* "
            "and tested on others. So short a training tells the parts apart in LRE and ITD at most: blind has no larger Mag.",
            Plot("ablations-recorded", RATIOS)),
])

PEOPLE = Page("people-and-recordings", "People and recordings",
              "Finding people and who speaks, and data sets made of recorded sessions.", [
    Section("People in pictures", "people_detection.jsonl", detection_table,
            "`people_detection DATA test`: a person is found where a box overlaps by half (intersection over union). "
            "*Drawn*: pictures of `earpoint-people-pictures`, homes and people of its test split; people count if at most a "
            "tenth of them is hidden by anything but the picture's edge. *Views of conversations*: those of "
            "`earpoint simulate`'s test split; everybody with a box counts, hidden or not. *Photographs*: four of "
            "people and six of things from Debian packages, boxes drawn by hand (`experiments/publish/photographs.json`): "
            "a smoke test, not a measurement. NanoDet is what `./dev assets --people` installs."),
    Section("Who speaks, in unseen homes", "active_speaker.json", speaker_table,
            "`active_speaker DATA test shipped`: people are detected in the picture, and the speaker among them is "
            "identified by the interaural time difference, in single seconds of the test split; four for every speaker "
            "and viewpoint."),
    Section("Where the speaker is, in unseen homes", "speaker_position.json", position_table,
            "`speaker_position DATA test`: how far off gtf is that locates the speaker by one picture and one second of sound, "
            "on the frozen pairs: told the speaker's box in the picture, and told nothing. Median, error of three quarters and of "
            "nine tenths at most; of the distance as a share of the smaller one; *facing* is where the speaker looks."),
    Section("People and who speaks, in recorded sessions", "session_people.jsonl", session_people_table,
            "`experiments/measure/session_people.py`: `earpoint locate` on every camera's movie of the two test sessions of "
            "*Methods in recorded sessions*. People count if at most a tenth of them is hidden. A switch is a person who "
            "gets another track's number. Who speaks is asked five times a second where one person alone does, for half or "
            "more of the second around it, and is in the picture."),
    Section("Methods in recorded sessions", "evaluate-recorded.json", recorded_table,
            "`earpoint evaluate --layout replay` on the two test sessions of nine, a minute each, that `earpoint record "
            "simulate` made in one flat and `earpoint record prepare` cut into clips; no session is in two splits. Methods are told the true box. "
            "gtf and vigas are the shipped networks, which were not trained on them; networks called -recorded were trained on the "
            "six training sessions alone (both ViGAS are those of the *[ablations](ablations.md#ablations-in-recorded-sessions)*), "
            "those called -adapted on the same sessions, starting from the shipped weights.",
            Plot("methods-recorded", RATIOS)),
    Section("Networks trained with detected people, in recorded sessions", "boxes-recorded.jsonl", recorded_boxes_table,
            "`earpoint evaluate --layout replay --boxes detected` and `--boxes true` on the same clips. gtf-adapted was trained "
            "on the six training sessions with the true boxes, gtf-detected with those of the person who was detected as the "
            "speaker (`data.boxes`); both start from the shipped weights and learn from the true position."),
    Section("Speech enhancement in recorded sessions", "enhance-recorded.json", recorded_enhancement_table,
            "`earpoint evaluate --layout replay --enhance --json` on the same clips: the target is what the speaker's near "
            "microphone recorded, moved to the source by GCC-PHAT and made as loud, since its gain is not known. "
            "enhance is the shipped network, which was not trained on them; gtf and vigas were trained on the six training "
            "sessions, gtf starting from enhance and vigas from the shipped one.", Plot("enhance-recorded", RATIOS[::2])),
    Section("Cost of simulated sessions", "session_cost.jsonl", session_table,
            "`experiments/measure/session_cost.py`: processor time of `earpoint record simulate`, half a minute with three "
            "people and eight cameras of 480 x 270 pixels at 5 pictures a second, including the flat, which is drawn once "
            "for all sessions. The column for sound is measured with almost no pictures."),
    Section("Clocks of simulated sessions", "session_sync.jsonl", sync_table,
            "`experiments/measure/session_sync.py`: `earpoint record sync --truth` on sessions of `earpoint record "
            "simulate` with clocks that drift by up to 50 ppm: long ones, each in its own flat (seed-N), and the nine of "
            "*Methods in recorded sessions* (scenario-N). 95th percentiles over devices; offset errors are taken over every "
            "second of the session. The goal for five minutes at 10 dB is 0.5 ms and 1 ppm."),
])

SIMULATOR = Page("simulator", "Tracer and simulator", "The path tracer against physics and against another program, and "
                 "the cost of simulated data.", [
    Section("The path tracer against physics", "trace_gates.md", None,
            "`trace_gates`: measured on the final impulse responses."),
    Section("Speed: tracing a furnished home", "trace_bench.json", trace_table,
            "`trace_bench`: medians on one core. Rays are counted alike in the tracer and in the bare Embree loop: each "
            "ends at the nearest surface; the tracer's include those that test whether a listener is visible."),
    Section("The path tracer beside pyroomacoustics", "compare_tracers.json", tracer_comparison,
            "`experiments/peers/compare_tracers.py`: a room of 6 x 5 x 3 m, absorption 0.2, scattering 0.5, as a box and "
            "as meshes of the same walls; a mono response of 1 s in the octave of 1 kHz, both programs on one core in "
            "one run. The reference is independent of both: 400,000 particles that bounce between the walls, counted in "
            "a sphere at the microphone. The time of Earpoint is that of the whole process, that of pyroomacoustics "
            "(hybrid: image sources to order 3 in the box, rays) excludes starting Python. pyroomacoustics has no tree "
            "over the walls, so it gets fewer rays where there are many triangles."),
    Section("Pictures per second on one core", "camera_bench.jsonl", camera_table,
            "`camera_bench`: 256 x 256 pixels, 4 rays per pixel, denoised; seconds of processor time of one "
            "thread. The light of a home is solved once for its 10 conversations, that of two people once "
            "for the 4 views of a conversation; the last column counts both."),
    Section("Cost of simulated data", "simulate_cost.jsonl", simulation_table,
            "`experiments/measure/simulate_cost.py`: processor time of `earpoint simulate` in two homes, six conversations "
            "each; two speakers and four viewpoints a conversation, 5000 rays from each mouth, 256 x 256 "
            "pixels. The plan of a conversation, its acoustics (bodies placed in the scene), trace, responses "
            "and light are shared by all of its viewpoints."),
    Section("Reverberation of homes", "home_reverberation.jsonl", reverberation_table,
            "`home_reverberation`: homes of the seeds 0 to 119, 500 and 1000 Hz. By Eyring's formula, averaged over a "
            "home's rooms by volume; and T30 of a traced response between two positions 1 m or more apart in the largest "
            "room, every third home. Traced times are longer: flutter echoes between bare parallel walls persist, open "
            "doors couple rooms, and the formula counts the insides of furniture."),
])

SPEED = Page("speed-and-memory", "Speed, memory and exactness", "Timings on another machine differ; ratios are measured "
             "in one run.", [
    Section("Speed: rendering a clip", "render_speed.jsonl", speed_table,
            "`experiments/measure/render_speed.py`: the whole of `earpoint render`, including start, reading and writing, "
            "with the shipped models. The goal for gtf is 100 times real time on two cores."),
    Section("Speed: gtf and ViGAS", "gtf_bench.json", network_table,
            "`gtf_bench`: one second of sound, networks in turns, medians; multiply-adds counted by the direct form."),
    Section("Speed: one second of sound through the released network", "vigas.md", None,
            "`experiments/peers/compare_vigas.py`: Earpoint and PyTorch take turns in one run; medians. GFLOP are "
            "those of the direct form of the convolutions, whatever algorithm is used."),
    Section("Exactness: our engine against the authors' code", "oracle_errors.md", None,
            "The same weights and inputs through `earpoint model run` and through the released code. "
            "Tests hold every output to 1e-4, on every instruction set that the machine has."),
    Section("Speed: the Python package", "python_overhead.jsonl", python_table,
            "`experiments/measure/python_overhead.py`: the same rendering by the command line and by the package, in turns; "
            "and live sound in small blocks against one block. Medians; NumPy's slices of blocks are left out."),
    Section("The page of earpoint serve: from a move to its sound", "page_latency.jsonl", page_table,
            "`web/measure.mjs`: moves on the map in a headless Chromium while the bundled clip plays; from the last "
            "movement to the first part of the sound that was rendered for it, including the 90 ms that the page keeps "
            "ready of the server's sound. The target is 200 ms on two cores. The share of real time is the server's, with "
            "request and response; in the browser it is the engine's."),
    Section("Load on the server of earpoint serve", "serve_load.jsonl", load_table,
            "`experiments/stress/serve_load.py`: wrk on one thread beside the server. A part is 43 ms of sound for a "
            "listener who has moved; parts of one listener are made one after the other. Poses are posted until there are "
            "10,000 or more, and the server's resident memory is read before and after. Slow connections send one byte of "
            "a header per second."),
    Section("Memory: a ten-minute clip", "render_memory.jsonl", memory_table,
            "`experiments/stress/render_memory.py`: the bundled clip looped, rendered to an mp4 for one earpoint. "
            "The limit is 600 MB."),
    Section("Speed: training steps", "training.json", training_table,
            "`experiments/peers/compare_training.py`: forward, backward and Adam on batches of one-second clips, in turns "
            "with Debian's python3-torch, which computes only the head that is used and keeps freed memory; "
            "medians on two threads."),
    Section("Speed: training gtf", "training_gtf.json", gtf_training_table,
            "`experiments/measure/gtf_training.py`: the whole of `earpoint train` with `configs/gtf.json`, its "
            "examples prepared on the fly, medians of runs in turns. *before*, where it was measured, is the build before the "
            "optimisations of [ADR 0015](../adr/0015-training-speed.md). Other work on the machine affects wall time, but hardly "
            "processor time."),
])

ROBUSTNESS = Page("robustness", "Robustness", "Inputs that differ from the training data, ambient noise, and commands that "
                  "are killed.", [
    Section("Generalisation", "generalisation.json", generalisation_table,
            "`experiments/measure/generalisation.py --every 2`: gtf's mean errors over those of the unchanged input, in "
            "unseen homes, where one condition differs from most of training; below 1 it improves on the input. `dsp` is given "
            "the speaker's true position. Voices of the test split are in no other split; Greek and French are not in "
            "the training data.", Plot("generalisation", ("Mag", "LRE", "ITD"), ("", "case"))),
    Section("Generalisation: other heads, another building", "generalisation_heads.json", generalisation_table,
            "`experiments/measure/generalisation_heads.py`, as above: homes of other seeds, with the head of training and "
            "with FABIAN, measured in the horizontal plane; and a house that was not generated, with an octagonal hall, a "
            "bare corridor and an attic, read from an OBJ file. `dsp` assumes KEMAR for every head.",
            Plot("generalisation-heads", ("Mag", "LRE", "ITD"), ("", "case"))),
    Section("Ambient sound in unseen homes", "ambient-novel.json", evaluation_table,
            "`earpoint evaluate --ambient -40 --json`: room noise in every source, separated by the high-pass at 80 Hz; "
            "the target is clean. `no-separation` was trained with the noise in both sounds and gets all of it; its "
            "output is separated. `with-ambient` was trained on separated sounds.", Plot("ambient-novel", RATIOS)),
    Section("Ambient sound in one home", "ambient-single.json", evaluation_table,
            "`earpoint evaluate --ambient -40 --json`, as above.", Plot("ambient-single", RATIOS)),
    Section("Ways to separate ambient sound in unseen homes", "separation-novel.md", None,
            "`experiments/measure/ambient_separation.py --context 4 --limit 120`: room noise of three levels in every "
            "source, separated by the band-pass, by spectral subtraction and by log-MMSE; the shipped models, which were "
            "trained on sound separated by the band-pass; four seconds of sound before the second that is compared."),
    Section("Networks trained on each way to separate ambient sound", "separation-trained.md", None,
            "`experiments/measure/ambient_separation.py --levels=-40`: room noise of -40 dB in every source, in training "
            "too; the shipped gtf and ViGAS, each trained on for a while on one separation; one second of sound as in the "
            "paper."),
    Section("Killed at random moments", "kills.json", kill_table,
            "`experiments/stress/kill_anywhere.py`: each command is killed (SIGKILL) at a random moment and restarted "
            "until it finishes by itself. All files must then equal those of an undisturbed run, byte for byte (for weight "
            "files: the tensors), with no extra files."),
])

OLDER = Page("older", "Older comparisons", "Comparisons of two versions, made once, and sections that `./dev results` no "
             "longer writes.", [
    Section("What the corrected tracer changed", "change_of_results.md", None,
            "`experiments/publish/change_of_results.py`: means before and after the tracer was corrected: sound is "
            "diffracted at both edges of a wall's end ([ADR 0008](../adr/0008-diffraction.md)), the interaural level "
            "difference grows near the head, transmission and uneven absorption are as in *[The path tracer against "
            "physics](simulator.md#the-path-tracer-against-physics)*. The data sets were simulated again from the same "
            "seeds; the networks are the same files, trained on the earlier data."),
])

PAGES = [METHODS, ABLATIONS, PEOPLE, SIMULATOR, SPEED, ROBUSTNESS, OLDER]

# Headings and sentences with another wording on earlier pages.
FORMER_TITLES = {"Methods in unseen homes, with sound before": "Methods in unseen homes, with preceding sound"}
FORMER_WORDS = {"With what the published evaluation does with the target's help:":
                    "With the published evaluation's use of the target (it corrects signs, and delays on Replay-NVAS):",
                "(aim ": "(goal ", "| measured | aim |": "| measured | goal |"}
