"""ViGAS in PyTorch: Earpoint's engine's output, the released code's names and output, and training."""
import json
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

import earpoint
from support import SOURCE, run

try:
    import torch
    from earpoint.torch import Vigas, magnitude_loss, vigas
except ImportError as error:
    raise unittest.SkipTest(f"PyTorch cannot be imported ({error}); ./dev test installs python3-torch") from error

sys.path.insert(0, str(SOURCE / "experiments"))
import safetensors_file  # noqa: E402

REFERENCES = SOURCE / "src" / "networks" / "vigas" / "testdata"
# Float32 sums in another order, through at most thirty layers; values are of order 1.
TOLERANCE = 1e-4


def drawn(description, seed=1):
    """A network with random numbers, whose output depends on all inputs."""
    torch.manual_seed(seed)
    network = Vigas(description)
    with torch.no_grad():
        for value in network.state_dict().values():
            if value.dtype == torch.float32 and value.ndim == 1:
                value.uniform_(0.5, 1.0)
    return network.eval()


def inputs_of(description, clips=2, samples=3000, seed=2):
    """Inputs as `earpoint model run` reads them."""
    random = np.random.default_rng(seed)
    inputs = {"src_wav": 0.3 * random.standard_normal((clips, description["audio_channels"], samples))}
    for entry in description["inputs"]:
        if entry["name"] != "visual_feat" or description["image_encoder"] is None:
            inputs[entry["name"]] = random.uniform(-1, 1, (clips, entry["width"]))
    inputs = {name: values.astype(np.float32) for name, values in inputs.items()}
    encoder = description["image_encoder"]
    if encoder is not None:
        inputs["src_rgb_u8"] = random.integers(0, 256, (clips, 3, encoder["height_px"], encoder["width_px"]),
                                               dtype=np.uint8)
    return inputs


def tensors_of(inputs):
    return {("src_rgb" if name == "src_rgb_u8" else name): torch.from_numpy(values.copy())
            for name, values in inputs.items()}


class EngineTest(unittest.TestCase):
    def expect_same(self, file, network, inputs):
        with tempfile.TemporaryDirectory() as folder:
            safetensors_file.write_arrays(Path(folder) / "inputs.safetensors", inputs)
            run("model", "run", file, Path(folder) / "inputs.safetensors", "-o", Path(folder) / "outputs.safetensors")
            expected = safetensors_file.read_arrays(Path(folder) / "outputs.safetensors")["pred"]
        with torch.no_grad():
            found = network(**tensors_of(inputs)).numpy()
        self.assertGreater(np.abs(expected).max(), 1e-2)
        self.assertLess(np.abs(found - expected).max(), TOLERANCE)

    def test_the_shipped_network_gives_the_engines_output(self):
        network = vigas("vigas")
        self.assertFalse(network.training)
        self.expect_same(earpoint.load_weights("vigas").file, network, inputs_of(network.description, samples=16000))

    def test_drawn_networks_of_other_shapes_give_the_engines_output(self):
        base = earpoint.load_weights("vigas").description
        small = {**base, "channels": 8, "blocks": 2, "layers_per_block": 3, "fusion_width": 16,
                 "conditioning_width": 12}
        no_picture = {**small, "image_encoder": None}
        shapes = {"small": small, "without an encoder": no_picture,
                  "with taps before only": {**no_picture, "acausal": False, "kernel_size": 2, "dilation_base": 2},
                  "with five taps": {**no_picture, "kernel_size": 5},
                  "with taps beyond the ends": {**no_picture, "dilation_base": 60}}
        for name, description in shapes.items():
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                file = Path(folder) / "drawn.safetensors"
                network = drawn(description)
                network.save(file)
                self.expect_same(file, network, inputs_of(description))
                self.expect_same(file, vigas(file), inputs_of(description, clips=1, samples=1))


class ReleasedCodeTest(unittest.TestCase):
    def test_a_checkpoint_of_the_released_code_loads_strictly_and_gives_its_output(self):
        folder = REFERENCES / "C_mini_noresnet"
        checkpoint = torch.load(folder / "best_val.ckpt", map_location="cpu")
        with tempfile.TemporaryDirectory() as made:
            file = Path(made) / "mini.safetensors"
            run("model", "import", folder / "best_val.ckpt", "-o", file)
            description = earpoint.load_weights(file).description
        network = Vigas(description, released=True)
        network.load_state_dict(checkpoint["state_dict"], strict=True)
        inputs = safetensors_file.read_arrays(folder / "inputs.safetensors")
        expected = safetensors_file.read_arrays(folder / "outputs.safetensors")["pred"]
        taken = {name: values for name, values in inputs.items()
                 if name == "src_wav" or name in [entry["name"] for entry in description["inputs"]]}
        with torch.no_grad():
            found = network.eval()(**tensors_of(taken)).numpy()
        step = found.size // expected.size
        self.assertLess(np.abs(found.reshape(-1)[::step] - expected.reshape(-1)).max(), TOLERANCE)

    def test_the_published_network_has_the_released_codes_names_and_shapes(self):
        manifest = json.loads((REFERENCES / "A_soundspaces" / "manifest.json").read_text())
        description = {**earpoint.load_weights("vigas").description, "channels": 64, "blocks": 3,
                       "layers_per_block": 10, "fusion_width": 512, "conditioning_width": 256,
                       "image_encoder": {"architecture": "resnet18", "width_px": 256, "height_px": 256, "channels": 8,
                                         "trunk_channels": 64},
                       "inputs": [{"name": "visual_feat", "width": 512}, {"name": "tgt_pose", "width": 3},
                                  {"name": "tgt_rotation", "width": 2}, {"name": "bboxes", "width": 4}]}
        ours = {name: list(value.shape) for name, value in Vigas(description, released=True).state_dict().items()}
        self.assertEqual(ours, {entry["name"]: entry["shape"] for entry in manifest["weights"]})
        self.assertEqual(len(ours), 613)

    def test_an_exported_checkpoint_loads_strictly(self):
        shipped = earpoint.load_weights("vigas").description
        inputs = [{**entry, "width": 2} if entry["name"] == "tgt_rotation" else entry for entry in shipped["inputs"]]
        description = {**shipped, "pose_encoding": "soundspaces", "box_encoding": "soundspaces", "inputs": inputs}
        network = drawn(description)
        with tempfile.TemporaryDirectory() as folder:
            weights, file = Path(folder) / "drawn.safetensors", Path(folder) / "best_val.ckpt"
            network.save(weights)
            run("model", "export", weights, "-o", file)
            checkpoint = torch.load(file, map_location="cpu")
        other = Vigas(description, released=True)
        other.load_state_dict(checkpoint["state_dict"], strict=True)
        for name, value in network.state_dict().items():
            if not name.endswith(".num_batches_tracked"):
                self.assertTrue(torch.equal(other.state_dict()[name], value), name)


class TrainingTest(unittest.TestCase):
    def batch(self):
        network = vigas("vigas")
        inputs = tensors_of(inputs_of(network.description, samples=4000))
        return network, inputs, 0.5 * inputs["src_wav"].flip(1)

    def test_gradients_reach_every_parameter_and_are_right(self):
        network, inputs, target = self.batch()
        magnitude_loss(network(**inputs), target).backward()
        for name, value in network.named_parameters():
            self.assertIsNotNone(value.grad, name)
            self.assertGreater(float(value.grad.abs().max()), 0.0, name)
        # Against a difference quotient, in double precision, in one direction through all parameters.
        network.double().zero_grad()
        inputs = {name: value.double() for name, value in inputs.items() if name != "src_rgb"}
        with torch.no_grad():
            inputs["visual_feat"] = torch.rand(2, network.description["inputs"][0]["width"], dtype=torch.float64)
        magnitude_loss(network(**inputs), target.double()).backward()
        torch.manual_seed(3)
        moved = {name: value for name, value in network.named_parameters() if value.grad is not None}
        direction = {name: torch.randn_like(value) for name, value in moved.items()}
        slope = sum(float((value.grad * direction[name]).sum()) for name, value in moved.items())

        def loss(step):
            with torch.no_grad():
                for name, value in moved.items():
                    value += step * direction[name]
                result = float(magnitude_loss(network(**inputs), target.double()))
                for name, value in moved.items():
                    value -= step * direction[name]
            return result

        # A central difference with steps of 1e-6: its own error is of order 1e-6 of the slope and rounding.
        self.assertAlmostEqual((loss(1e-6) - loss(-1e-6)) / 2e-6, slope, delta=1e-3 * abs(slope))

    def test_a_few_steps_lower_the_loss_and_the_result_renders(self):
        network, inputs, target = self.batch()
        network.train()
        optimizer = torch.optim.Adam(network.parameters(), lr=1e-3)
        losses = []
        for _ in range(8):
            optimizer.zero_grad()
            loss = magnitude_loss(network(**inputs), target)
            loss.backward()
            optimizer.step()
            losses.append(float(loss))
        self.assertLess(losses[-1], 0.9 * losses[0])
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "mine.safetensors"
            network.save(file)
            again = vigas(file)
            network.eval()
            with torch.no_grad():
                self.assertTrue(torch.equal(again(**inputs), network(**inputs)))
            self.assertEqual(earpoint.Renderer(file).model, str(file))

    def test_the_loss_is_the_metric(self):
        random = np.random.default_rng(4)
        reference, estimate = (0.1 * random.standard_normal((2, 16000)).astype(np.float32) for _ in range(2))
        loss = float(magnitude_loss(torch.from_numpy(estimate)[None], torch.from_numpy(reference)[None]))
        # The metric sums the ears' means and has no floor of 1e-7 under the power.
        self.assertAlmostEqual(2 * loss, earpoint.metrics(reference, estimate, 16000)["mag"], delta=1e-4)

    def test_other_networks_are_refused(self):
        with self.assertRaisesRegex(ValueError, "gtf"):
            vigas("gtf")
        with self.assertRaises(earpoint.InputError):
            vigas("missing")


if __name__ == "__main__":
    unittest.main()
