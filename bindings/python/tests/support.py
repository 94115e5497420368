"""What the tests share: the program, the bundled clip, sound files."""
import json
import os
import struct
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np

SOURCE = Path(__file__).resolve().parents[3]
CLIP = SOURCE / "examples" / "clip.mp4"
SPEAKER = (1.89, 0.196, 0.147)
SPEAKER_BOX = (0.383, 0.348, 0.513, 1.0)


def program():
    """The command line of the same build, which the package is compared with."""
    path = os.environ.get("EARPOINT_PROGRAM")
    if not path or not Path(path).is_file():
        raise unittest.SkipTest("EARPOINT_PROGRAM does not name the program earpoint")
    return path


def run(*words):
    """What the program prints."""
    done = subprocess.run([program(), *map(str, words)], capture_output=True, text=True)
    if done.returncode != 0:
        raise AssertionError(done.stderr)
    return done.stdout


def decoded(path, *options):
    """Samples of a sound or movie file as FFmpeg reads them, [2, samples]."""
    done = subprocess.run(["ffmpeg", "-v", "error", "-i", str(path), *options, "-f", "f32le", "-"], check=True,
                          capture_output=True)
    return np.frombuffer(done.stdout, "<f4").reshape(-1, 2).T


def write_wav(path, sound, rate):
    """A WAV file of 32-bit floats."""
    sound = np.atleast_2d(sound)
    data = np.ascontiguousarray(sound.T, "<f4").tobytes()
    channels = sound.shape[0]
    form = struct.pack("<HHIIHH", 3, channels, rate, 4 * channels * rate, 4 * channels, 32)
    chunks = b"WAVE" + b"fmt " + struct.pack("<I", len(form)) + form + b"data" + struct.pack("<I", len(data)) + data
    Path(path).write_bytes(b"RIFF" + struct.pack("<I", len(chunks)) + chunks)


def read_wav(path):
    """The samples of a WAV file of 32-bit floats, [channels, samples]."""
    data = Path(path).read_bytes()
    place, channels = 12, 0
    while place < len(data):
        name, size = data[place:place + 4], struct.unpack_from("<I", data, place + 4)[0]
        body = data[place + 8:place + 8 + size]
        if name == b"fmt ":
            form, channels, _, _, _, bits = struct.unpack_from("<HHIIHH", body)
            if form == 0xFFFE:
                form = struct.unpack_from("<H", body, 24)[0]
            if (form, bits) != (3, 32):
                raise AssertionError(f"{path}: expected 32-bit floats, found format {form} of {bits} bits")
        if name == b"data":
            return np.frombuffer(body, "<f4").reshape(-1, channels).T
        place += 8 + size + size % 2
    raise AssertionError(f"{path}: no data")


def write_speech(folder):
    """Two voices of noise, enough to simulate with."""
    folder.mkdir()
    index = "file,speaker,gender,split\n"
    random = np.random.default_rng(3)
    for gender in ("female", "male"):
        write_wav(folder / f"{gender}.wav", random.uniform(-0.1, 0.1, 24000), 16000)
        index += f"{gender}.wav,{gender} voice,{gender},test\n"
    (folder / "speech.csv").write_text(index)


class ClipCase(unittest.TestCase):
    """Two seconds of the bundled clip, as arrays and as files."""

    @classmethod
    def setUpClass(cls):
        cls.held = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.held.name)
        cls.frame_file, cls.sound_file = cls.folder / "frame.png", cls.folder / "sound.wav"
        subprocess.run(["ffmpeg", "-v", "error", "-i", str(CLIP), "-frames:v", "1", str(cls.frame_file)], check=True)
        done = subprocess.run(["ffprobe", "-v", "error", "-show_streams", "-of", "json", str(CLIP)], check=True,
                              capture_output=True)
        streams = {stream["codec_type"]: stream for stream in json.loads(done.stdout)["streams"]}
        cls.rate = int(streams["audio"]["sample_rate"])
        size = (int(streams["video"]["height"]), int(streams["video"]["width"]), 3)
        done = subprocess.run(["ffmpeg", "-v", "error", "-i", str(cls.frame_file), "-f", "rawvideo", "-pix_fmt",
                               "rgb24", "-"], check=True, capture_output=True)
        cls.frame = np.frombuffer(done.stdout, np.uint8).reshape(size)
        cls.sound = np.ascontiguousarray(decoded(CLIP, "-t", "2"))
        write_wav(cls.sound_file, cls.sound, cls.rate)

    @classmethod
    def tearDownClass(cls):
        cls.held.cleanup()
