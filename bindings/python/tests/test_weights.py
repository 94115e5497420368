"""Weight files."""
import json
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

import earpoint
from support import SOURCE, run

sys.path.insert(0, str(SOURCE / "experiments"))
import safetensors_file  # noqa: E402


class WeightsTest(unittest.TestCase):
    def test_tensors_are_those_of_the_file(self):
        for name in ("gtf", "vigas", "rt60"):
            weights = earpoint.load_weights(name)
            expected = safetensors_file.read_arrays(SOURCE / "models" / f"{name}.safetensors")
            self.assertEqual(set(weights.tensors), set(expected))
            for tensor, values in expected.items():
                self.assertEqual(weights.tensors[tensor].dtype, values.dtype)
                self.assertTrue(np.array_equal(weights.tensors[tensor], values))
            self.assertEqual(weights.parameters, sum(values.size for values in expected.values()))
            info = json.loads(run("model", "info", weights.file, "--json"))
            self.assertEqual(weights.description, {**info["description"]})
        self.assertEqual(weights.kind, "rt60_estimator")

    def test_what_was_saved_is_loaded_again_and_renders(self):
        weights = earpoint.load_weights("vigas")
        weights.tensors["input.bias"][:] = 0.25
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "mine.safetensors"
            earpoint.save_weights(file, weights.tensors, weights.description, weights.metadata)
            again = earpoint.load_weights(file)
            self.assertEqual(again.description, weights.description)
            self.assertEqual(again.metadata, weights.metadata)
            self.assertTrue((again.tensors["input.bias"] == 0.25).all())
            self.assertEqual(earpoint.Renderer(file).model, str(file))

    def test_weights_that_no_engine_loads_are_not_written(self):
        weights = earpoint.load_weights("vigas")
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "mine.safetensors"
            missing = {name: tensor for name, tensor in weights.tensors.items() if name != "input.bias"}
            broken = {**weights.tensors, "input.bias": np.full_like(weights.tensors["input.bias"], np.nan)}
            shorter = {**weights.tensors, "input.bias": weights.tensors["input.bias"][1:]}
            for tensors in (missing, broken, shorter):
                with self.assertRaisesRegex(earpoint.InputError, "input.bias"):
                    earpoint.save_weights(file, tensors, weights.description)
            with self.assertRaisesRegex(ValueError, "complex128"):
                earpoint.save_weights(file, {"input.bias": np.zeros(3, complex)}, weights.description)
            self.assertFalse(file.exists())

    def test_other_files_are_refused(self):
        for name in ("missing", str(SOURCE / "README.md")):
            with self.assertRaises(earpoint.InputError):
                earpoint.load_weights(name)


if __name__ == "__main__":
    unittest.main()
