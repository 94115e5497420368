"""Pairs of a data set, read by workers of a DataLoader."""
import json
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np

import earpoint
from support import write_speech, write_wav

try:
    import torch
    from earpoint.torch import PairDataset, magnitude_loss, vigas
    from torch.utils.data import DataLoader
except ImportError as error:
    raise unittest.SkipTest(f"PyTorch cannot be imported ({error}); ./dev test installs python3-torch") from error


def write_replay(folder, scene, clips):
    """A data set in the form of Replay-NVAS: two cameras, of which the second is 1 m ahead, 2 m to the left, looks left
    and hears the same noise 20 samples later."""
    root = folder / "data" / "appen_dataset"
    random = np.random.default_rng(1)
    metadata = {}
    for clip in range(clips):
        place = root / "v3" / scene / str(clip)
        place.mkdir(parents=True)
        sound = 0.1 * random.standard_normal((2, 16020))
        for camera in (1, 2):
            write_wav(place / f"{camera}.wav", sound[:, 20:] if camera == 1 else sound[:, :16000], 16000)
            np.save(place / f"{camera}.npy", np.array([[0.125, 0.25, 0.5, 0.75, 3.0]]))
            subprocess.run(["ffmpeg", "-v", "error", "-f", "lavfi", "-i", "color=0xc80a1e:size=64x36", "-frames:v", "1",
                            place / f"{camera}.png"], check=True)
        metadata[f"data/appen_dataset/v3/{scene}/{clip}"] = ["1.png", "2.png"]
    (root / "v3" / "metadata_v2.json").write_text(json.dumps(metadata))
    cameras = {"centers": {scene: {"DSLR-1": [100, 0, 150], "DSLR-2": [200, 200, 150]}},
               "rotations": {scene: {"DSLR-1": [1, 0, 0], "DSLR-2": [0, 1, 0]}}}
    (root / "camera_positions_fixed_rotation.json").write_text(json.dumps(cameras))


class PairsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.held = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.held.name)
        write_speech(cls.folder / "speech")
        cls.homes = cls.folder / "homes"
        earpoint.simulate(cls.homes, scenes=1, conversations=2, split="test", viewpoints=3,
                          speech=cls.folder / "speech", rays=50, duration=0.2, seed=5)
        cls.pairs = PairDataset(cls.homes, "test")

    @classmethod
    def tearDownClass(cls):
        cls.held.cleanup()

    def test_every_viewpoint_is_a_target_once(self):
        self.assertEqual(len(self.pairs), 2 * 3)
        self.assertEqual(self.pairs.layout, "soundspaces")
        names = [item["name"] for item in self.pairs]
        self.assertEqual(len(set(names)), len(names))
        first = self.pairs[0]
        self.assertEqual(first["src_wav"].shape, (2, 16000))
        self.assertEqual(first["src_wav"].dtype, torch.float32)
        self.assertEqual(first["src_rgb"].dtype, torch.uint8)
        self.assertEqual(first["src_rgb"].shape, (3, 256, 256))
        self.assertGreater(float(first["tgt_wav"].abs().max()), 1e-5)
        for name, shape in (("tgt_pose", 3), ("tgt_rotation", 2), ("bboxes", 4), ("position", 3), ("orientation", 4)):
            self.assertEqual(tuple(first[name].shape), (shape,), name)
        self.assertAlmostEqual(float(first["orientation"].norm()), 1.0, places=6)
        # The encoded distance is that of the position, which is level.
        self.assertAlmostEqual(float(first["tgt_pose"][0]), float(first["position"][:2].norm()), places=5)
        with self.assertRaises(IndexError):
            self.pairs[6]
        self.assertEqual(self.pairs[-1]["name"], names[-1])

    def test_the_encoded_distance_is_that_of_the_viewpoints(self):
        metadata = json.loads(next(self.homes.glob("test/*/cleaned_metadata_v3.json")).read_text())
        distances = {}
        for clip_index, clip in enumerate(metadata):
            for source, one in enumerate(clip["viewpoints"]):
                for target, other in enumerate(clip["viewpoints"]):
                    offset = np.subtract(other["location"], one["location"])
                    distances[clip_index, source, target] = float(np.hypot(offset[0], offset[2]))
        for item in self.pairs:
            clip, views = item["name"].split(", ")[1].split(": ")
            source, target = map(int, views.split(" -> "))
            expected = distances[int(clip.split()[1]), source, target]
            self.assertAlmostEqual(float(item["tgt_pose"][0]), expected, places=4)

    def test_workers_forked_and_spawned_read_the_same(self):
        expected = [self.pairs[i] for i in range(len(self.pairs))]
        for context in ("fork", "spawn"):
            loader = DataLoader(self.pairs, batch_size=2, num_workers=2, multiprocessing_context=context)
            found = list(loader)
            self.assertEqual(len(found), 3)
            for i, item in enumerate(expected):
                batch = found[i // 2]
                self.assertEqual(batch["name"][i % 2], item["name"])
                for name, value in item.items():
                    if name != "name":
                        self.assertTrue(torch.equal(batch[name][i % 2], value), (context, name))

    def test_random_pairs_follow_pytorchs_seed_and_keep_the_target(self):
        pairs = PairDataset(self.homes, "test", random=True)

        def names(seed):
            torch.manual_seed(seed)
            loader = DataLoader(pairs, batch_size=1, num_workers=1, multiprocessing_context="fork")
            return [batch["name"][0] for _ in range(4) for batch in loader]

        first = names(1)
        self.assertEqual(names(1), first)
        self.assertNotEqual(names(2), first)
        self.assertGreater(len(set(first)), len(pairs))
        targets = [name.split(" -> ")[1][0] for name in first[:6]]
        self.assertEqual(targets, [item["name"].split(" -> ")[1][0] for item in self.pairs])

    def test_a_network_gets_what_it_takes_and_learns(self):
        network = vigas("vigas")
        pairs = PairDataset(self.homes, "test", network=network)
        encoder = network.description["image_encoder"]
        batch = next(iter(DataLoader(pairs, batch_size=3)))
        self.assertEqual(tuple(batch["src_rgb"].shape), (3, 3, encoder["height_px"], encoder["width_px"]))
        self.assertEqual(batch["src_rgb"].dtype, torch.float32)
        inputs = {name: batch[name] for name in ("src_rgb", "tgt_pose", "tgt_rotation", "bboxes")}
        loss = magnitude_loss(network(batch["src_wav"], **inputs), batch["tgt_wav"])
        loss.backward()
        self.assertGreater(float(network.input.weight.grad.abs().max()), 0)
        # The picture as a network of its size is shown it.
        raw = torch.stack([self.pairs[i]["src_rgb"] for i in range(3)])
        with torch.no_grad():
            # Both scale in float32, with products in another order.
            self.assertTrue(torch.allclose(network.eval().picture_feature(raw),
                                           network.picture_feature(batch["src_rgb"]), atol=1e-5))

    def test_draws(self):
        self.assertEqual(len(PairDataset(self.homes, "test", draw="released")), 2)
        drawn = [PairDataset(self.homes, "test", draw="every-target", seed=seed)[0]["name"] for seed in range(6)]
        self.assertGreater(len(set(drawn)), 1)

    def test_reads_the_replay_layout(self):
        folder = self.folder / "recorded"
        write_replay(folder, "SC-1022", 2)
        pairs = PairDataset(folder, "train")
        self.assertEqual(pairs.layout, "replay")
        self.assertEqual(len(pairs), 2)
        item = pairs[0]
        self.assertEqual(tuple(item["tgt_rotation"].shape), (6,))
        self.assertEqual(tuple(item["src_rgb"].shape), (3, 216, 384))
        self.assertRegex(item["name"], "^SC-1022/0: (1 -> 2|2 -> 1)$")
        ahead = item["name"].endswith("1 -> 2")
        # From camera 1 the other is 1 m ahead and 2 m to the left; from camera 2, which looks left, 2 m behind and 1 m
        # to the left.
        expected = [1.0, 2.0, 0.0] if ahead else [-2.0, 1.0, 0.0]
        self.assertTrue(np.allclose(item["position"], expected, atol=1e-6), (item["name"], item["position"]))
        self.assertTrue(np.allclose(item["bboxes"], [0.125, 0.25, 0.5, 0.75], atol=1e-6))

    def test_folders_and_splits_that_are_not_there_are_refused(self):
        for folder, options in ((self.folder / "missing", {}), (self.homes, {"split": "none"}),
                                (self.homes, {"split": "test", "layout": "replay"}),
                                (self.homes, {"split": "test", "draw": "other"})):
            with self.assertRaises(earpoint.InputError):
                PairDataset(folder, **options)


if __name__ == "__main__":
    unittest.main()
