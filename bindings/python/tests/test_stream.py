"""Live sound in blocks."""
import unittest

import numpy as np

import earpoint
from support import SPEAKER, SPEAKER_BOX, ClipCase


class StreamTest(ClipCase):
    def stream(self):
        stream = earpoint.Renderer("gtf", threads=1).stream(self.rate)
        stream.see(self.frame, SPEAKER_BOX)
        stream.move_to((1.0, 0.5, 0.0), yaw=30)
        return stream

    def test_blocks_of_any_size_give_the_samples_of_one_block(self):
        sound = self.sound[:, :self.rate]
        whole = self.stream().process(sound)
        self.assertGreater(np.abs(whole).max(), 1e-3)
        stream, parts, at = self.stream(), [], 0
        for size in [0, 1, 480, 137, 4096] + [1024] * 100:
            parts.append(stream.process(sound[:, at:at + size]))
            at += size
        self.assertTrue(np.array_equal(np.concatenate(parts, axis=1), whole))

    def test_the_output_is_late_by_its_latency(self):
        stream = earpoint.Renderer("gtf", threads=1).stream(self.rate, phase_rounds=0)
        stream.place_speaker(SPEAKER)
        sound = np.zeros((2, self.rate), np.float32)
        sound[:, self.rate // 2:] = self.sound[:, :self.rate - self.rate // 2]
        onset = np.argmax(np.abs(sound).max(axis=0) > 1e-3)
        heard = np.argmax(np.abs(stream.process(sound)).max(axis=0) > 1e-3)
        # The network's frames begin half a window of 10 ms hops before what they hear.
        self.assertAlmostEqual(heard - onset, stream.latency, delta=0.025 * self.rate)
        self.assertGreater(stream.latency, 0)

    def test_dsp_streams_too(self):
        renderer = earpoint.Renderer("dsp", threads=1)
        stream = renderer.stream(self.rate)
        self.assertIsNone(stream.speaker)
        stream.place_speaker(SPEAKER)
        stream.move_to((1.0, 0.5, 0.0), yaw=30)
        sound = np.ascontiguousarray(self.sound[:, :self.rate])
        whole = renderer.render(sound, self.rate, speaker=SPEAKER, translate=(1.0, 0.5, 0.0), yaw=30)
        heard = stream.process(sound)
        late = stream.latency
        # Both convolve in float, by transforms of other lengths.
        self.assertLess(np.abs(heard[:, late:] - whole[:, :self.rate - late]).max(), 1e-5)
        self.assertGreater(np.abs(whole).max(), 1e-3)

    def test_nothing_is_copied(self):
        block = np.ascontiguousarray(self.sound[:, :4800])
        expected = self.stream().process(block)
        out = np.empty_like(block)
        self.assertIs(self.stream().process(block, out), out)
        self.assertTrue(np.array_equal(out, expected))
        # In place, and within a larger array.
        ring = np.zeros((2, 9600), np.float32)
        ring[:, 1200:6000] = block
        window = ring[:, 1200:6000]
        self.assertIs(self.stream().process(window, out=window), window)
        self.assertTrue(np.array_equal(ring[:, 1200:6000], expected))
        self.assertFalse(ring[:, :1200].any() or ring[:, 6000:].any())

    def test_other_layouts_are_copied_and_give_the_same(self):
        block = np.ascontiguousarray(self.sound[:, :4800])
        expected = self.stream().process(block)
        for other in (np.ascontiguousarray(block.T).T, block.astype(np.float64)):
            self.assertTrue(np.array_equal(self.stream().process(other), expected))

    def test_memory_that_is_not_aligned_is_copied_or_refused(self):
        block = np.ascontiguousarray(self.sound[:, :4800])
        memory = bytearray(1 + block.nbytes)
        odd = np.frombuffer(memory, np.float32, offset=1).reshape(2, 4800)
        odd[:] = block
        self.assertFalse(odd.flags.aligned)
        self.assertTrue(np.array_equal(self.stream().process(odd), self.stream().process(block)))
        with self.assertRaisesRegex(ValueError, "out: expected float32"):
            self.stream().process(block, odd)

    def test_moves_and_reset(self):
        stream = self.stream()
        block = np.ascontiguousarray(self.sound[:, :9600])
        stream.process(block)
        self.assertEqual(len(stream.speaker), 3)
        stream.reset()
        first = stream.process(block)
        stream.reset()
        self.assertTrue(np.array_equal(stream.process(block), first))
        stream.reset()
        stream.move_to((1.0, 0.5, 0.0), yaw=-150)
        self.assertFalse(np.array_equal(stream.process(block), first))

    def test_wrong_blocks_are_refused(self):
        stream = self.stream()
        block = np.zeros((2, 480), np.float32)
        with self.assertRaisesRegex(ValueError, "float32 of shape"):
            stream.process(np.zeros((480, 2), np.float32))
        with self.assertRaisesRegex(ValueError, "float32 of shape"):
            stream.process(np.zeros((2, 480), np.int16))
        with self.assertRaisesRegex(ValueError, "out: expected float32 of shape"):
            stream.process(block, np.zeros((2, 479), np.float32))
        with self.assertRaisesRegex(ValueError, "out: expected float32 of shape"):
            stream.process(block, np.zeros((480, 2), np.float32).T)
        with self.assertRaisesRegex(ValueError, "overlaps"):
            stream.process(block, block[::-1])
        with self.assertRaisesRegex(ValueError, "read-only"):
            frozen = block.copy()
            frozen.flags.writeable = False
            stream.process(block, frozen)
        with self.assertRaises(earpoint.InputError):
            stream.move_to((float("inf"), 0, 0))
        with self.assertRaises(earpoint.InputError):
            earpoint.Renderer("gtf").stream(44101)
        with self.assertRaises(earpoint.InputError):
            earpoint.Renderer("input").stream(48000)


if __name__ == "__main__":
    unittest.main()
