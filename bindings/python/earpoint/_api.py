"""Rendering: whole clips, live sound, and what is known of models."""
from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _earpoint

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Triple = Sequence[float] | NDArray[Any]
    PathLike = str | os.PathLike[str]

MODELS = Path(__file__).parent / "models"


def model_file(word: str | os.PathLike[str]) -> str:
    """The weight file that a name means: one that comes with this package, unless EARPOINT_MODELS_DIR is set."""
    name = os.fspath(word)
    if os.path.isfile(name):
        return name
    packed = MODELS / f"{name}.safetensors"
    if not os.environ.get("EARPOINT_MODELS_DIR") and os.sep not in name and packed.is_file():
        return str(packed)
    return name


def models() -> list[str]:
    """The names of the models that render(), Renderer and load_weights() take, sorted."""
    names = set(_earpoint.installed_networks())
    if not os.environ.get("EARPOINT_MODELS_DIR"):
        names |= {file.stem for file in MODELS.glob("*.safetensors")}
    return sorted(names)


def thread_count(threads: int | None) -> int:
    if threads is None:
        return _earpoint.available_cores()
    if threads < 1:
        raise ValueError(f"threads: expected 1 or more, found {threads}")
    return int(threads)


def pose(translate: Triple, yaw: float, pitch: float, roll: float) -> list[float]:
    place = [float(value) for value in translate]
    if len(place) != 3:
        raise ValueError(f"translate: expected x, y, z in metres, found {len(place)} numbers")
    return [*place, float(yaw), float(pitch), float(roll)]


def numbers(values: ArrayLike | None) -> list[float] | None:
    return None if values is None else [float(value) for value in np.asarray(values, dtype=np.float64).reshape(-1)]


def rows_of(path: PathLike | ArrayLike | None) -> str | list[list[float]] | None:
    """A CSV file by its name, or rows of numbers."""
    if path is None:
        return None
    if isinstance(path, (str, os.PathLike)):
        return os.fspath(path)
    rows = np.asarray(path, dtype=np.float64)
    if rows.ndim != 2 or rows.shape[1] != 7:
        raise ValueError(f"path: expected an array [rows, 7], found {list(rows.shape)}")
    return [list(row) for row in rows.tolist()]


class Renderer:
    """A model that renders recorded moments at other positions.

    Keep one for many clips: opening it reads and prepares the weights. Calls from several threads run one after the
    other; different renderers run in parallel. Python's global lock is released while it works.

    :param model: the name of a model (:func:`models`), a weight file, ``dsp`` (head filters, no network) or ``input``
        (the unchanged sound)
    :param fov: horizontal field of view of the source's camera, degrees, 10 to 170
    :param texture: for gtf networks trained for both: 1 natural, with the modulation and decay of such a room; 0 the
        mean, with the least error of magnitudes; None: natural
    :param hrtf: head filters of ``dsp``, a SOFA file; None: the KEMAR set of libmysofa
    :param threads: None: all cores; the samples are the same for any number
    :raises InputError: if there is no such model, or it makes no sound
    """

    def __init__(self, model: PathLike = "gtf", *, fov: float = 90.0, texture: float | None = None,
                 hrtf: PathLike | None = None, threads: int | None = None) -> None:
        self._renderer = _earpoint.Renderer(model_file(model), float(fov), texture,
                                            None if hrtf is None else os.fspath(hrtf), thread_count(threads))

    @property
    def model(self) -> str:
        """The weight file in use, or ``dsp`` or ``input``."""
        return self._renderer.model()

    def render(self, audio: ArrayLike, rate: int, *, image: ArrayLike | None = None, speaker: Triple | None = None,
               speaker_box: Sequence[float] | None = None, translate: Triple = (0.0, 0.0, 0.0), yaw: float = 0.0,
               pitch: float = 0.0, roll: float = 0.0, path: PathLike | ArrayLike | None = None, band: str = "full",
               limit: bool = True, gain: float = 0.0) -> NDArray[np.float32]:
        """Renders a whole clip. See :func:`render`."""
        return self._renderer.render(np.asarray(audio), int(rate), None if image is None else np.asarray(image),
                                     numbers(speaker), numbers(speaker_box), pose(translate, yaw, pitch, roll),
                                     rows_of(path), (is_full(band), bool(limit)), float(gain))

    def warnings(self, audio: ArrayLike, rate: int, *, image: ArrayLike | None = None, speaker: Triple | None = None,
                 speaker_box: Sequence[float] | None = None, translate: Triple = (0.0, 0.0, 0.0), yaw: float = 0.0,
                 pitch: float = 0.0, roll: float = 0.0, path: PathLike | ArrayLike | None = None) -> list[str]:
        """What of a request is outside the model's training data: messages, a line each. Takes what render() takes."""
        return self._renderer.warnings(np.asarray(audio), int(rate), None if image is None else np.asarray(image),
                                       numbers(speaker), numbers(speaker_box), pose(translate, yaw, pitch, roll),
                                       rows_of(path))

    def stream(self, rate: int = 48000, *, extend_band: bool = True, limit: bool = True,
               phase_rounds: int | None = None) -> Stream:
        """Starts rendering live sound. The stream may outlive the renderer.

        :param rate: Hz, from 16000 to 192000, a multiple of 50
        :param extend_band: sound above the network's band (8 kHz) follows the gain of its top octave; gtf only
        :param limit: keep the output within full scale
        :param phase_rounds: rounds that make the phases of frames consistent, each adds 20 ms of latency; None: as many
            as the network was trained with; 0: the lowest latency. "dsp" has none
        :raises InputError: if the rate or the rounds are not supported, or the model is neither a gtf network nor "dsp"
        """
        return Stream(self._renderer.stream(int(rate), bool(extend_band), bool(limit), phase_rounds))


def is_full(band: str) -> bool:
    if band not in ("full", "model"):
        raise ValueError(f"band: expected 'full' or 'model', found {band!r}")
    return band == "full"


class Stream:
    """Live sound at an earpoint, block by block; made by :meth:`Renderer.stream`.

    Calls from several threads run one after the other. Python's global lock is released in each.
    """

    __slots__ = ("_stream",)

    def __init__(self, stream: _earpoint.Stream) -> None:
        self._stream = stream

    def process(self, block: NDArray[np.float32], out: NDArray[np.float32] | None = None) -> NDArray[np.float32]:
        """Renders the next samples.

        :param block: left and right ear of the source, float32 [2, samples], any number of samples. The engine reads it
            where it is if the samples of a channel lie side by side (a C-contiguous array, or columns of one); other
            arrays are copied first. NaN and infinity count as 0
        :param out: takes the result, of the same shape; may be ``block`` itself. None: a new array
        :return: left and right ear of the earpoint, float32 [2, samples], :attr:`latency` samples late: ``out``, or the
            array that the engine wrote
        :raises ValueError: if an array has another shape or type, or ``out`` overlaps ``block`` otherwise
        """
        return self._stream.process(block, out)

    def move_to(self, translate: Triple = (0.0, 0.0, 0.0), yaw: float = 0.0, pitch: float = 0.0,
                roll: float = 0.0) -> None:
        """The earpoint from here on, relative to the source's camera.

        :param translate: x, y, z in metres: front, left, up
        :param yaw: degrees to the left
        :param pitch: degrees up
        :param roll: degrees towards the right shoulder
        :raises InputError: if it is not finite or farther than 10 km
        """
        self._stream.move_to(pose(translate, yaw, pitch, roll))

    def see(self, image: ArrayLike | None, speaker_box: Sequence[float] | None = None) -> None:
        """The source camera's picture from here on; takes some milliseconds.

        :param image: uint8 [height, width, 3], RGB, any size; None: no picture
        :param speaker_box: x_min, y_min, x_max, y_max, fractions of the picture; None: unknown
        :raises InputError: if the box is no box within the picture, or the model is "dsp" and there is a box but no
            picture
        """
        self._stream.see(None if image is None else np.asarray(image), numbers(speaker_box))

    def place_speaker(self, mouth: Triple | None) -> None:
        """Where the speaker's mouth is: x, y, z in metres from the camera; None: located by picture and sound."""
        self._stream.place_speaker(numbers(mouth))

    @property
    def latency(self) -> int:
        """Latency of the output in samples, for any block size."""
        return self._stream.latency()

    @property
    def speaker(self) -> tuple[float, float, float] | None:
        """Estimated position of the speaker's mouth, metres from the camera; None before the first
        sound, or if "dsp" was told nothing."""
        found = self._stream.speaker()
        return None if found is None else (found[0], found[1], found[2])

    def reset(self) -> None:
        """Restarts from silence; picture, speaker and earpoint are kept."""
        self._stream.reset()


def render(audio: ArrayLike, rate: int, image: ArrayLike | None = None, speaker: Triple | None = None,
           speaker_box: Sequence[float] | None = None, translate: Triple = (0.0, 0.0, 0.0), yaw: float = 0.0,
           pitch: float = 0.0, roll: float = 0.0, model: PathLike = "gtf", *, fov: float = 90.0,
           path: PathLike | ArrayLike | None = None, texture: float | None = None, hrtf: PathLike | None = None,
           band: str = "full", limit: bool = True, gain: float = 0.0,
           threads: int | None = None) -> NDArray[np.float32]:
    """Renders a recorded moment at another position and turn of the head.

    The samples are those that ``earpoint render`` writes for the same sound, picture and speaker. It opens the model
    for each call; keep a :class:`Renderer` for many clips.

    :param audio: float32 [2, samples] from -1 to 1, left ear first; or [samples] or [1, samples], whose voice is placed
        at the speaker by head filters if their position is known. At least 0.1 s
    :param rate: sample rate, Hz, 16000 or more
    :param image: the camera's picture, uint8 [height, width, 3], RGB
    :param speaker: x, y, z of the speaker's mouth, metres from the camera: front, left, up
    :param speaker_box: x_min, y_min, x_max, y_max of the speaker in the picture, fractions of it, or pixels. With
        neither, the network locates the speaker by picture and sound
    :param translate: x, y, z of the earpoint, metres from the camera: front, left, up
    :param yaw: turn of the head, degrees to the left
    :param pitch: degrees up
    :param roll: degrees towards the right shoulder
    :param model: a name, a weight file, ``dsp`` or ``input``; see :class:`Renderer`
    :param fov: horizontal field of view of the camera, degrees
    :param path: instead of translate and turn, a moving earpoint: a CSV file as ``earpoint render --path`` reads it, or
        an array [rows, 7] of time in seconds, x, y, z in metres and yaw, pitch, roll in degrees
    :param texture: see :class:`Renderer`
    :param hrtf: see :class:`Renderer`
    :param band: ``full``: sound above the model's band gets the gain of the band's top octave; ``model``: remove it
    :param limit: keep peaks within full scale
    :param gain: of the output, dB, before the limiter
    :param threads: None: all cores
    :return: left and right ear at the earpoint, float32 [2, samples]
    :raises InputError: if the sound is too short, of a lower rate, silent, or has NaN; if the model needs a picture or
        a speaker and none is given; if the path does not cover the sound
    :raises ValueError: if an array has another shape or type
    """
    renderer = Renderer(model, fov=fov, texture=texture, hrtf=hrtf, threads=threads)
    return renderer.render(audio, rate, image=image, speaker=speaker, speaker_box=speaker_box, translate=translate,
                           yaw=yaw, pitch=pitch, roll=roll, path=path, band=band, limit=limit, gain=gain)
