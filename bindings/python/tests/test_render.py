"""Whole clips: the samples of the command line, and clear refusals."""
import threading
import unittest

import numpy as np

import earpoint
from support import SPEAKER, SPEAKER_BOX, ClipCase, read_wav, run, write_wav


class RenderTest(ClipCase):
    def by_program(self, *words):
        there = self.folder / "there.wav"
        run("render", self.frame_file, self.sound_file, "-o", there, "--fov", 90, "--recording", "binaural", "--quiet",
            "--detector", "none", *words)
        return read_wav(there)

    def expect_same(self, ours, theirs):
        self.assertEqual(ours.dtype, np.float32)
        self.assertEqual(ours.shape, theirs.shape)
        self.assertTrue(np.array_equal(ours, theirs))
        self.assertGreater(np.abs(ours).max(), 1e-3)

    def test_gives_the_bytes_of_the_command_line_for_a_box(self):
        theirs = self.by_program("--speaker-box", ",".join(map(str, SPEAKER_BOX)), "--translate", "1,-0.5,0.1", "--yaw",
                                 35, "--pitch", 5, "--roll", -3)
        ours = earpoint.render(self.sound, self.rate, self.frame, speaker_box=SPEAKER_BOX, translate=(1, -0.5, 0.1),
                               yaw=35, pitch=5, roll=-3)
        self.expect_same(ours, theirs)
        other = earpoint.render(self.sound, self.rate, self.frame, speaker_box=SPEAKER_BOX, translate=(1, 0.5, 0.1))
        self.assertFalse(np.array_equal(ours, other))

    def test_gives_the_bytes_of_the_command_line_along_a_path(self):
        rows = [[0, 0, 0, 0, 0, 0, 0], [1.2, 0.5, 1, 0, 45.5, 0, 0], [2, 1, 1, 0, 90, -10, 0]]
        file = self.folder / "walk.csv"
        file.write_text("time_s,x,y,z,yaw_deg,pitch_deg,roll_deg\n" + "".join(
            ",".join(map(str, row)) + "\n" for row in rows))
        theirs = self.by_program("--speaker", ",".join(map(str, SPEAKER)), "--path", file)
        renderer = earpoint.Renderer("gtf")
        self.expect_same(renderer.render(self.sound, self.rate, image=self.frame, speaker=SPEAKER, path=file), theirs)
        ours = renderer.render(self.sound, self.rate, image=self.frame, speaker=SPEAKER, path=np.array(rows))
        self.expect_same(ours, theirs)

    def test_gives_the_bytes_of_the_command_line_by_other_models(self):
        box = ",".join(map(str, SPEAKER_BOX))
        for model in ("vigas", "input"):
            theirs = self.by_program("--model", model, "--speaker-box", box, "--yaw", 90, "--gain", -3)
            ours = earpoint.render(self.sound, self.rate, self.frame, speaker_box=SPEAKER_BOX, yaw=90, model=model,
                                   gain=-3)
            self.expect_same(ours, theirs)

    def test_places_one_channel_by_head_filters_as_the_command_line_does(self):
        mono = self.folder / "mono.wav"
        write_wav(mono, self.sound[0], self.rate)
        there = self.folder / "there.wav"
        run("render", self.frame_file, mono, "-o", there, "--model", "dsp", "--speaker", "1,1,0", "--translate", "0,1,0",
            "--fov", 90, "--quiet")
        ours = earpoint.render(self.sound[0], self.rate, self.frame, speaker=(1, 1, 0), translate=(0, 1, 0),
                               model="dsp")
        self.expect_same(ours, read_wav(there))

    def test_doubles_and_strided_arrays_give_the_same_samples(self):
        expected = earpoint.render(self.sound, self.rate, speaker=SPEAKER, model="dsp")
        strided = np.ascontiguousarray(self.sound.T).T
        self.assertFalse(strided.flags.c_contiguous)
        for sound in (strided, self.sound.astype(np.float64), self.sound.tolist()):
            self.assertTrue(np.array_equal(earpoint.render(sound, self.rate, speaker=SPEAKER, model="dsp"), expected))

    def test_other_python_threads_go_on_while_it_renders(self):
        renderer = earpoint.Renderer("vigas", threads=1)
        outcome = []
        thread = threading.Thread(target=lambda: outcome.append(renderer.render(
            self.sound, self.rate, image=self.frame, speaker_box=SPEAKER_BOX, translate=(1, 0, 0))))
        thread.start()
        turns = 0
        while thread.is_alive():
            turns += 1
            thread.join(0.001)
        # With the lock held there would be one turn or two; rendering takes hundreds of milliseconds.
        self.assertGreater(turns, 10)
        self.assertEqual(outcome[0].shape, self.sound.shape)

    def test_threads_may_share_a_renderer(self):
        renderer = earpoint.Renderer("dsp", threads=1)
        poses = [(0, 1, 0), (0, -1, 0), (1, 0, 0)]
        expected = [renderer.render(self.sound, self.rate, speaker=SPEAKER, translate=place) for place in poses]
        found = [None] * len(poses)

        def work(i):
            found[i] = renderer.render(self.sound, self.rate, speaker=SPEAKER, translate=poses[i])

        threads = [threading.Thread(target=work, args=(i,)) for i in range(len(poses))]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for ours, theirs in zip(found, expected):
            self.assertTrue(np.array_equal(ours, theirs))

    def test_a_renderer_lists_what_it_was_not_trained_for(self):
        renderer = earpoint.Renderer("gtf")
        self.assertEqual(renderer.warnings(self.sound, self.rate, image=self.frame, speaker=SPEAKER,
                                           translate=(0.5, 0, 0)), [])
        far = renderer.warnings(self.sound, self.rate, image=self.frame, speaker=SPEAKER, translate=(20, 0, 0))
        self.assertEqual(len(far), 1)
        self.assertIn("20", far[0])
        self.assertTrue(renderer.model.endswith("gtf.safetensors"))


class RefusalTest(ClipCase):
    def refused(self, error, pattern, *words, **options):
        with self.assertRaisesRegex(error, pattern):
            earpoint.render(*words, **options)

    def test_bad_data_are_an_input_error_of_one_line(self):
        self.assertTrue(issubclass(earpoint.InputError, ValueError))
        broken = self.sound.copy()
        broken[1, 7] = np.nan
        for sound, rate, options in ((broken, self.rate, {}), (0 * self.sound, self.rate, {}), (self.sound, 8000, {}),
                                     (self.sound[:, :100], self.rate, {}), (self.sound, self.rate, {"model": "missing"}),
                                     (self.sound, self.rate, {"model": "dsp"}),
                                     (self.sound, self.rate, {"translate": (1e5, 0, 0)}),
                                     (self.sound, self.rate, {"yaw": float("nan")}),
                                     (self.sound, self.rate, {"fov": 500}),
                                     (self.sound, self.rate, {"path": "missing.csv"}),
                                     (self.sound, self.rate, {"speaker_box": (0.5, 0.5, 0.4, 0.6)})):
            with self.assertRaises(earpoint.InputError) as caught:
                earpoint.render(sound, rate, **options)
            self.assertNotIn("\n", str(caught.exception))
            self.assertIn(": ", str(caught.exception))

    def test_wrong_arrays_are_value_errors_that_say_what_was_expected(self):
        self.refused(ValueError, "divide 16-bit samples by 32768", (32768 * self.sound).astype(np.int16), self.rate)
        self.refused(ValueError, r"transpose it with \.T", self.sound.T, self.rate)
        self.refused(ValueError, "one or two channels", np.zeros((3, 20000), np.float32), self.rate)
        self.refused(ValueError, "channels, samples", np.zeros((1, 2, 20000), np.float32), self.rate)
        self.refused(ValueError, "height, width, 3", self.sound, self.rate, self.frame[:, :, 0])
        self.refused(ValueError, "height, width, 3", self.sound, self.rate, self.frame.astype(np.float32))
        self.refused(ValueError, "x, y, z", self.sound, self.rate, translate=(1, 2))
        self.refused(ValueError, "speaker: expected x, y, z", self.sound, self.rate, speaker=(1, 2))
        self.refused(ValueError, "rows, 7", self.sound, self.rate, path=[[0, 1, 2]])
        self.refused(ValueError, "threads", self.sound, self.rate, threads=0)
        self.refused(ValueError, "rate", self.sound, 0)
        self.refused(ValueError, "band", self.sound, self.rate, band="half")


if __name__ == "__main__":
    unittest.main()
