"""Rooms and their impulse responses; comparison of sounds; people in recordings; simulated data sets."""
from __future__ import annotations

import json
import math
import os
import re
import warnings as python_warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _earpoint
from ._api import model_file, models, numbers, pose, thread_count

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from ._api import PathLike, Triple


@contextmanager
def arguments_for_flags() -> Iterator[None]:
    """Messages of the command line name flags: puts the arguments in their place."""
    try:
        yield
    except _earpoint.InputError as error:
        text = re.sub(r"--([a-z][a-z-]*)", lambda flag: flag.group(1).replace("-", "_"), str(error))
        raise _earpoint.InputError(text) from None


@dataclass(frozen=True)
class Response:
    """An impulse response and how it decays; what :func:`trace` returns."""

    samples: NDArray[np.float32]
    """float32 [channels, samples], left ear first; 1 is the level of the source at 1 m in free field. Sample 0 is the
    moment at which the source sounds: the travel time is included."""
    rate: int
    """Hz"""
    t30: tuple[float | None, ...]
    """Reverberation time T60 in seconds, from the decay between -5 and -35 dB, of each channel; None if it ends before
    -35 dB"""
    edt: tuple[float | None, ...]
    """Early decay time in seconds, from 0 to -10 dB, of each channel"""
    c50: tuple[float | None, ...]
    """Energy of the first 50 ms over that of all later, dB, of each channel"""


def reverberation(samples: ArrayLike, rate: int) -> Response:
    """Measures an impulse response, by the definitions of ISO 3382-1.

    :param samples: float [channels, samples] or [samples], linear pressure
    :param rate: Hz
    :return: the samples and t30, edt and c50 of each channel; None where the decay does not reach far enough
    :raises ValueError: if the array has another shape or type
    """
    sound = np.atleast_2d(np.asarray(samples))
    measured = _earpoint.reverberation(sound, int(rate))
    return Response(sound, int(rate), tuple(channel[0] for channel in measured),
                    tuple(channel[1] for channel in measured), tuple(channel[2] for channel in measured))


class Scene:
    """A room to trace sound in, from a file, or :meth:`box`. Any number of threads may use it at once.

    :param file: glTF 2.0 (.gltf, .glb), Wavefront (.obj) or Stanford (.ply). Acoustic materials are the standard ones,
        by material name
    :raises InputError: if the file is missing, damaged, or no scene of 0.5 m to 1 km
    """

    def __init__(self, file: PathLike) -> None:
        self._scene = _earpoint.Scene.open(os.fspath(file))

    @classmethod
    def box(cls, lengths: Triple, absorption: float, scattering: float = 0.1) -> Scene:
        """An empty box with a corner at the origin.

        :param lengths: along x, y, z, metres
        :param absorption: of all faces at all frequencies, 0 to 1
        :param scattering: the same
        """
        made = cls.__new__(cls)
        made._scene = _earpoint.Scene.box(numbers(lengths) or [], float(absorption), float(scattering))
        return made

    @property
    def warnings(self) -> list[str]:
        """What the importer assumed or left out, a line each."""
        return self._scene.warnings()

    def trace(self, source: Triple, listener: Triple, *, source_yaw: float = 0.0, source_pitch: float = 0.0,
              source_roll: float = 0.0, yaw: float = 0.0, pitch: float = 0.0, roll: float = 0.0,
              microphone: str = "ears", talker: bool = False, rate: int = 48000, duration: float = 1.0,
              rays: int = 5000, seed: int = 1, threads: int | None = None) -> Response:
        """The impulse response from a source to a listener. See :func:`trace`."""
        samples = self._scene.response(pose(source, source_yaw, source_pitch, source_roll),
                                       pose(listener, yaw, pitch, roll), microphone, bool(talker), int(rate),
                                       float(duration), int(rays), int(seed), thread_count(threads))
        return reverberation(samples, rate)


def trace(scene: Scene | PathLike, source: Triple, listener: Triple, *, source_yaw: float = 0.0,
          source_pitch: float = 0.0, source_roll: float = 0.0, yaw: float = 0.0, pitch: float = 0.0, roll: float = 0.0,
          microphone: str = "ears", talker: bool = False, rate: int = 48000, duration: float = 1.0, rays: int = 5000,
          seed: int = 1, threads: int | None = None) -> Response:
    """Traces the impulse response of a room, as ``earpoint trace`` writes it for the same rays and seed.

    :param scene: a :class:`Scene`, or the file of one
    :param source: x, y, z in metres, in the scene's frame, z up
    :param listener: the same
    :param source_yaw: where a talker looks, degrees to the left of x; matters only with ``talker``
    :param source_pitch: degrees up
    :param source_roll: degrees towards the right shoulder
    :param yaw: where the listener looks, degrees to the left of x
    :param pitch: degrees up
    :param roll: degrees towards the right shoulder
    :param microphone: ``ears``: a binaural response, of the KEMAR head; ``omni``: one omnidirectional microphone
    :param talker: the source has a talker's directivity, louder in front
    :param rate: Hz, from 8000 to 192000
    :param duration: of the response, seconds, from 0.01 to 30
    :param rays: from the source
    :param seed: the same seed gives the same samples
    :param threads: None: all cores; the samples are the same for any number
    :raises InputError: if source or listener are outside the scene or less than 1 mm apart, a number is out of range,
        or no sound arrives
    """
    room = scene if isinstance(scene, Scene) else Scene(scene)
    return room.trace(source, listener, source_yaw=source_yaw, source_pitch=source_pitch, source_roll=source_roll,
                      yaw=yaw, pitch=pitch, roll=roll, microphone=microphone, talker=talker, rate=rate,
                      duration=duration, rays=rays, seed=seed, threads=threads)


def metrics(reference: ArrayLike, estimate: ArrayLike, rate: int, *, convention: str = "paper", variant: str = "vigas",
            length: float | None = None, sign_fix: bool = False,
            rt60_model: PathLike | None = None) -> dict[str, Any]:
    """How an estimated sound differs from the true one, with the keys and numbers of ``earpoint metrics --json``.

    :param reference: float [2, samples], left ear first; for conventions of impulse responses [channels, samples] or
        [samples]
    :param estimate: of the same shape; an impulse response may have another length
    :param rate: Hz, of both. ``paper`` resamples to 16000 Hz, ``rwavs`` and ``naf`` to 22050 Hz, ``raf`` to 48000 Hz if
        it is not 16000 Hz
    :param convention: whose definitions; docs/metrics.md compares them, zero is best. Of binaural sounds ``paper``: mag,
        lre_db (dB; None if a left ear is silent), rte_s (seconds; None without an estimator), stft_distance, l2,
        delay_samples; ``rwavs``: mag, env. Of impulse responses ``raf``, ``naf``, ``avr``, ``iso``
    :param variant: ``rwavs``: the same as that convention; ``vigas``: the convention decides
    :param length: seconds of impulse responses to compare, from their first sample; None: 0.32 for ``raf``, 0.1 for
        ``avr``, else all
    :param sign_fix: first negate one ear of an estimate in opposite phase, as the published evaluation does
    :param rt60_model: weight file of the estimator behind rte_s; None: the shipped one
    :return: the metrics, None where one has no value; ``samples``, ``sample_rate_hz`` and ``notes``; more for ``raf``,
        ``naf`` (t60_invalid) and ``iso`` (reference, estimate: octave by octave)
    :raises InputError: if there is no such convention; if a sound is empty or has NaN; if binaural sounds have not two
        channels, or lengths that differ; if the reference is no impulse response
    """
    if variant not in ("vigas", "rwavs"):
        raise ValueError(f"variant: expected 'vigas' or 'rwavs', found {variant!r}")
    if variant == "rwavs":
        if convention not in ("paper", "rwavs"):
            raise ValueError("variant: cannot be chosen with a convention; leave it out")
        convention = "rwavs"
    truth, found = np.asarray(reference), np.asarray(estimate)
    if convention not in ("paper", "rwavs"):
        if sign_fix or rt60_model is not None:
            raise ValueError("sign_fix, rt60_model: apply to binaural sounds, not to impulse responses")
        if length is not None and not 0.0 < length < math.inf:
            raise ValueError(f"length: expected seconds above 0, found {length!r}")
        return json.loads(_earpoint.response_metrics(truth, found, int(rate), convention, length))
    if length is not None:
        raise ValueError("length: applies only to conventions for impulse responses")
    if convention == "rwavs":
        return _earpoint.rwavs_metrics(truth, found, int(rate), bool(sign_fix))
    estimator = model_file("rt60" if rt60_model is None else rt60_model)
    if rt60_model is None and "rt60" not in models():
        estimator = None
    return _earpoint.vigas_metrics(truth, found, int(rate), bool(sign_fix), estimator)


def locate(clip: PathLike, sound: PathLike | None = None, *, speaker_box: Sequence[float] | None = None,
           speaker_boxes: PathLike | None = None, fov: float | None = None, recording: str = "auto",
           model: PathLike = "gtf", detector: PathLike | None = None, three_d: bool = False) -> dict[str, Any]:
    """The people of a recording and who of them speaks: what ``earpoint locate --json`` prints.

    :param clip: a movie or a sound file; with ``sound`` a picture
    :param sound: the picture's sound file
    :param speaker_box: x_min, y_min, x_max, y_max of the speaker, fractions of the picture or pixels: people are then
        not detected
    :param speaker_boxes: a CSV file with boxes over time
    :param fov: the camera's horizontal field of view, degrees, 10 to 170; None: as the file tells, else 90
    :param recording: ``binaural``, ``stereo``, ``mono``, or ``auto``: detected
    :param model: a gtf network
    :param detector: people detector, a weight file or an .onnx network; ``none``: do not detect; None: the shipped one
    :param three_d: distance, height and heading as well (``--3d``)
    :return: ``speaker`` (azimuth_deg, ...), ``people``, ``windows`` and ``frames`` over time; docs/formats.md
    :raises InputError: for a bad recording, picture, box or model
    """
    inputs = [os.fspath(clip)] if sound is None else [os.fspath(clip), os.fspath(sound)]
    if recording not in ("auto", "binaural", "stereo", "mono"):
        raise ValueError(f"recording: expected 'auto', 'binaural', 'stereo' or 'mono', found {recording!r}")
    if fov is not None and not 10.0 <= fov <= 170.0:
        raise _earpoint.InputError(f"fov: expected 10 to 170 degrees, found {fov:g}")
    box = "" if speaker_box is None else ",".join(repr(value) for value in numbers(speaker_box) or [])
    finder = detector
    if detector is None and "people" in models():
        finder = model_file("people")
    with arguments_for_flags():
        return json.loads(_earpoint.locate(
            inputs, box, "" if speaker_boxes is None else os.fspath(speaker_boxes), fov, recording,
            model_file(model), "" if finder is None else os.fspath(finder), three_d))


def simulate(out: PathLike, **options: Any) -> dict[str, Any]:
    """Simulates a data set of homes, people who talk in them, pictures and binaural responses.

    The same options and seed give the bytes of ``earpoint simulate``; an interrupted run continues in the same folder.

    :param out: folder of the data set
    :param options: those of ``earpoint simulate``, with underscores: scenes, conversations, split, speech, seed,
        viewpoints, other_rooms, other_rooms_reach, height_spread, rays, rate, duration, path_prefix, released_speech,
        heard, jobs, shard; or instead of scenes, scene (a list of files) with materials, up, unit, close_ceiling
    :return: the summary that ``earpoint simulate --json`` prints
    :raises InputError: if an option is out of range or the folder was begun with others
    :raises TypeError: for an unknown option, or one of another type
    """
    given = {name: os.fspath(value) if isinstance(value, os.PathLike) else value for name, value in options.items()}
    if "scene" in given:
        files = given["scene"]
        given["scene"] = [os.fspath(file) for file in ([files] if isinstance(files, (str, os.PathLike)) else files)]
    with arguments_for_flags():
        summary, lines = _earpoint.simulate(os.fspath(out), given)
    for line in lines:
        python_warnings.warn(line, stacklevel=2)
    return json.loads(summary)
