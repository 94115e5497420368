"""Rooms, metrics, people and simulated data: what the command line gives."""
import json
import math
import tempfile
import unittest
from pathlib import Path

import numpy as np

import earpoint
from support import CLIP, ClipCase, read_wav, run, write_speech, write_wav


class TraceTest(unittest.TestCase):
    def test_direct_sound_arrives_after_distance_over_speed_of_sound_at_its_level(self):
        room = earpoint.Scene.box((6, 4, 3), absorption=1.0)
        response = room.trace((1, 2, 1.5), (4, 2, 1.5), microphone="omni", rate=16000, duration=0.3)
        self.assertEqual(response.samples.shape, (1, 4800))
        peak = int(np.abs(response.samples[0]).argmax())
        # 3 m at 343 to 344 m/s; a sample is 21 mm.
        self.assertAlmostEqual(peak / 16000, 3.0 / 343.5, delta=1 / 16000)
        # A third of the amplitude at 1 m; air and the place between two samples take less than a quarter.
        self.assertAlmostEqual(float(response.samples[0, peak]), 1 / 3, delta=1 / 12)

    def test_a_box_reverberates_as_eyring_says(self):
        response = earpoint.trace(earpoint.Scene.box((6, 4, 3), 0.3, 0.5), (1, 2, 1.5), (4, 2, 1.5), yaw=180,
                                  rate=16000, duration=0.6)
        volume, surface = 6 * 4 * 3, 2 * (6 * 4 + 6 * 3 + 4 * 3)
        eyring_s = 0.161 * volume / (-surface * math.log(1 - 0.3))
        for ear in range(2):
            # A box that is no cube, and air: within a quarter.
            self.assertAlmostEqual(response.t30[ear], eyring_s, delta=0.25 * eyring_s)
            self.assertLess(response.edt[ear], 2 * eyring_s)
            self.assertGreater(response.c50[ear], 0)

    def test_a_decay_that_ends_early_has_no_t30(self):
        response = earpoint.trace(earpoint.Scene.box((6, 4, 3), 0.02), (1, 2, 1.5), (4, 2, 1.5), rate=16000,
                                  duration=0.05, rays=500)
        self.assertEqual(response.t30, (None, None))

    def test_gives_the_bytes_of_the_command_line(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "brir.wav"
            run("trace", "--shoebox", "6,4,3,absorption=0.3,scattering=0.2", "--source", "1,2,1.5", "--listener",
                "4,2,1.5,yaw=180", "-o", file, "--rays", 800, "--duration", 0.4, "--rate", 16000, "--seed", 7)
            ours = earpoint.trace(earpoint.Scene.box((6, 4, 3), 0.3, 0.2), (1, 2, 1.5), (4, 2, 1.5), yaw=180, rays=800,
                                  duration=0.4, rate=16000, seed=7)
            self.assertTrue(np.array_equal(ours.samples, read_wav(file)))

    def test_wrong_places_are_refused(self):
        room = earpoint.Scene.box((6, 4, 3), 0.3)
        for source, listener in (((1, 2, 1.5), (7, 2, 1.5)), ((1, 2, 1.5), (1, 2, 1.5))):
            with self.assertRaises(earpoint.InputError):
                room.trace(source, listener)
        with self.assertRaises(earpoint.InputError):
            earpoint.trace("missing.glb", (0, 0, 0), (1, 0, 0))
        with self.assertRaisesRegex(ValueError, "microphone"):
            room.trace((1, 2, 1.5), (4, 2, 1.5), microphone="both")
        with self.assertRaisesRegex(ValueError, "above 0"):
            earpoint.Scene.box((6, 0, 3), 0.3)

    def test_measures_an_exponential_decay(self):
        rate, t60 = 16000, 0.4
        noise = np.random.default_rng(1).standard_normal(rate)
        response = noise * 10 ** (-3 * np.arange(rate) / rate / t60)
        found = earpoint.reverberation(response, rate)
        # Noise: the level of 8 ms, some hundred samples, varies by half a decibel.
        self.assertAlmostEqual(found.t30[0], t60, delta=0.02)
        self.assertAlmostEqual(found.edt[0], t60, delta=0.06)


def decaying(rate, t60, seed):
    """Two channels of a second of noise that decays."""
    noise = np.random.default_rng(seed).standard_normal((2, rate))
    return (0.1 * noise * 10 ** (-3 * np.arange(rate) / rate / t60)).astype(np.float32)


class MetricsTest(ClipCase):
    def test_has_the_keys_and_numbers_of_the_command_line(self):
        estimate = np.ascontiguousarray(0.7 * self.sound[::-1])
        file = self.folder / "estimate.wav"
        write_wav(file, estimate, self.rate)
        for variant in ("vigas", "rwavs"):
            theirs = json.loads(run("metrics", self.sound_file, file, "--json", "--variant", variant))
            ours = earpoint.metrics(self.sound, estimate, self.rate, variant=variant)
            self.assert_same(ours, theirs)
            self.assertGreater(ours["mag"], 0)

    def test_conventions_have_the_keys_and_numbers_of_the_command_line(self):
        estimate = np.ascontiguousarray(0.7 * self.sound[::-1])
        file = self.folder / "swapped.wav"
        write_wav(file, estimate, self.rate)
        for convention, options, flags in (("paper", {}, []), ("rwavs", {}, []),
                                           ("rwavs", {"sign_fix": True}, ["--sign-fix"])):
            theirs = json.loads(run("metrics", self.sound_file, file, "--json", "--convention", convention, *flags))
            self.assert_same(earpoint.metrics(self.sound, estimate, self.rate, convention=convention, **options), theirs)

    def test_conventions_of_responses_have_the_keys_and_numbers_of_the_command_line(self):
        rate = 32000
        reference, estimate = decaying(rate, 0.4, 1), decaying(rate, 0.5, 2)[:, :rate // 2]
        files = self.folder / "reference.wav", self.folder / "short.wav"
        for file, response in zip(files, (reference, estimate)):
            write_wav(file, response, rate)
        compared = {}
        for convention in ("raf", "naf", "avr", "iso"):
            for length in (None, 0.25, 0.75):
                flags = [] if length is None else ["--length", length]
                theirs = json.loads(run("metrics", *files, "--json", "--convention", convention, *flags))
                ours = earpoint.metrics(reference, estimate, rate, convention=convention, length=length)
                self.assert_same(ours, theirs)
                compared[convention, length] = [value for value in ours.values() if isinstance(value, float)]
        # Each has numbers, and others than the rest.
        self.assertEqual(len(set(map(tuple, compared.values()))), len(compared))
        self.assertTrue(all(compared.values()))
        one = earpoint.metrics(reference[0], estimate[0], rate, convention="iso")
        self.assertEqual(len(one["reference"]), 1)

    def assert_same(self, ours, theirs):
        self.assertEqual(list(ours), list(theirs))
        for name, value in theirs.items():
            if name != "notes":  # they name files
                self.assertEqual(ours[name], value, name)
        self.assertEqual(len(ours["notes"]), len(theirs["notes"]))

    def test_the_same_sound_has_no_error(self):
        ours = earpoint.metrics(self.sound, self.sound, self.rate)
        for name in ("mag", "lre_db", "rte_s", "stft_distance", "l2", "delay_samples"):
            self.assertEqual(ours[name], 0.0, name)

    def test_sounds_that_cannot_be_compared_are_refused(self):
        for estimate in (self.sound[:, 1:], self.sound[:1], np.full_like(self.sound, np.nan)):
            with self.assertRaises(earpoint.InputError):
                earpoint.metrics(self.sound, estimate, self.rate)
        with self.assertRaisesRegex(ValueError, "variant"):
            earpoint.metrics(self.sound, self.sound, self.rate, variant="other")
        with self.assertRaisesRegex(earpoint.InputError, "convention"):
            earpoint.metrics(self.sound, self.sound, self.rate, convention="other")
        with self.assertRaisesRegex(ValueError, "variant"):
            earpoint.metrics(self.sound, self.sound, self.rate, convention="iso", variant="rwavs")
        with self.assertRaisesRegex(ValueError, "length"):
            earpoint.metrics(self.sound, self.sound, self.rate, length=0.1)
        response = decaying(16000, 0.4, 3)
        for length in (0.0, -1.0, float("nan"), float("inf")):
            with self.assertRaisesRegex(ValueError, "length"):
                earpoint.metrics(response, response, 16000, convention="iso", length=length)
        with self.assertRaisesRegex(ValueError, "sign_fix"):
            earpoint.metrics(response, response, 16000, convention="iso", sign_fix=True)
        with self.assertRaisesRegex(earpoint.InputError, "reference"):
            earpoint.metrics(response[:, ::-1], response, 16000, convention="raf")


class LocateTest(ClipCase):
    def test_gives_the_json_of_the_command_line(self):
        theirs = json.loads(run("locate", self.frame_file, self.sound_file, "--3d", "--fov", 90, "--json", "--quiet",
                                "--detector", "none"))
        ours = earpoint.locate(self.frame_file, self.sound_file, three_d=True, fov=90, detector="none")
        del theirs["model"], ours["model"]  # paths, of the program's and of the package's models
        self.assertEqual(ours, theirs)
        self.assertIn("picture", ours["by"])
        self.assertGreater(len(ours["windows"]), 0)
        self.assertGreater(ours["speaker"]["distance_m"], 0.1)

    def test_takes_a_box_and_refuses_a_bad_one(self):
        ours = earpoint.locate(CLIP, speaker_box=(0.383, 0.348, 0.513, 1.0))
        self.assertIn("box", ours["by"])
        with self.assertRaisesRegex(earpoint.InputError, "box"):
            earpoint.locate(CLIP, speaker_box=(0.5, 0.5, 0.4, 0.6))
        with self.assertRaises(earpoint.InputError):
            earpoint.locate("missing.mp4")
        with self.assertRaisesRegex(earpoint.InputError, "fov"):
            earpoint.locate(CLIP, fov=5)


class SimulateTest(unittest.TestCase):
    def test_gives_the_bytes_of_the_command_line(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            write_speech(folder / "speech")
            run("simulate", "--out", folder / "theirs", "--scenes", 1, "--conversations", 1, "--split", "test",
                "--viewpoints", 2, "--speech", folder / "speech", "--rays", 50, "--duration", 0.2, "--seed", 5, "--quiet")
            summary = earpoint.simulate(folder / "ours", scenes=1, conversations=1, split="test", viewpoints=2,
                                        speech=folder / "speech", rays=50, duration=0.2, seed=5)
            self.assertEqual((summary["conversations"], summary["viewpoints"]), (1, 2))
            self.assertEqual(summary["run"]["simulated_conversations"], 1)
            theirs = {file.relative_to(folder / "theirs"): file.read_bytes()
                      for file in (folder / "theirs").rglob("*") if file.is_file()}
            ours = {file.relative_to(folder / "ours"): file.read_bytes()
                    for file in (folder / "ours").rglob("*") if file.is_file()}
            self.assertGreater(len(ours), 8)
            self.assertEqual(ours, theirs)

    def test_wrong_options_are_refused(self):
        with tempfile.TemporaryDirectory() as name:
            with self.assertRaisesRegex(TypeError, "no option 'ray'"):
                earpoint.simulate(Path(name) / "out", ray=5)
            with self.assertRaisesRegex(TypeError, "option 'scenes' cannot be 'two'"):
                earpoint.simulate(Path(name) / "out", scenes="two")
            with self.assertRaisesRegex(earpoint.InputError, "^rays: expected 1 or more"):
                earpoint.simulate(Path(name) / "out", rays=0)
            with self.assertRaisesRegex(earpoint.InputError, "^up: expected y or z, found 'x'"):
                earpoint.simulate(Path(name) / "out", scene="room.glb", up="x")
            self.assertFalse((Path(name) / "out").exists())


if __name__ == "__main__":
    unittest.main()
