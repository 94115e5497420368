#!/usr/bin/env python3
"""Makes the reference data beside it, but for C_mini_noresnet, of networks that the released code was run on: of each one
clip and every eighth sample of what comes out, with the manifest that tells their weights (see oracle_weights.h).

The clip of A_soundspaces/long.safetensors is ours: a noise that the test makes too, and what the network in
experiments/peers/peer_pytorch.py makes of it, which is first held against the released code's outputs. Needs PyTorch.

usage: cut_reference.py FOLDER    (the folder with A_soundspaces, B_replay, ...)
"""
import json
import sys
from pathlib import Path

import numpy as np
import torch

HERE = Path(__file__).parent
ROOT = HERE.parents[3]
sys.path += [str(ROOT / "experiments"), str(ROOT / "experiments/peers")]
import peer_pytorch  # noqa: E402
import safetensors_file  # noqa: E402

STEP = 8
LONG_SAMPLES = 20480  # more than the largest dilation, 19683
GOLDEN = 0x9E3779B97F4A7C15
MASK = 2**64 - 1


def random_numbers(name, seed, shape, low, high):
    """As OracleRandom has them."""
    key = 0xCBF29CE484222325
    for byte in name.encode():
        key = ((key ^ byte) * 0x100000001B3) & MASK
    key ^= (seed * GOLDEN) & MASK
    count = int(np.prod(shape, dtype=np.int64))
    z = np.uint64(key) + np.arange(1, count + 1, dtype=np.uint64) * np.uint64(GOLDEN)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z ^= z >> np.uint64(31)
    values = low + (high - low) * ((z >> np.uint64(11)).astype(float) * 2.0**-53)
    return values.astype(np.float32).reshape(shape)


def write_manifest(whole, name):
    manifest = json.loads((whole / name / "manifest.json").read_text())
    weights = [{k: v for k, v in entry.items() if k != "dtype"} for entry in manifest["weights"]]
    rows = ",\n".join(json.dumps(entry) for entry in weights)
    hparams = json.dumps(manifest["hparams"])
    (HERE / name).mkdir(exist_ok=True)
    (HERE / name / "manifest.json").write_text(
        f'{{"seed": {manifest["seed"]}, "hparams": {hparams}, "weights": [\n{rows}\n]}}\n')
    return manifest


def write_clip(whole, name, outputs):
    inputs = safetensors_file.read_arrays(whole / name / "inputs.safetensors")
    inputs.pop("tgt_wav")
    safetensors_file.write_arrays(HERE / name / "inputs.safetensors", {n: t[:1] for n, t in inputs.items()})
    found = safetensors_file.read_arrays(whole / name / "outputs.safetensors")
    kept = {n: found[n][:1] for n in outputs if n in found}
    kept["pred"] = kept["pred"][..., ::STEP]
    safetensors_file.write_arrays(HERE / name / "outputs.safetensors", kept)


def peer_network(manifest):
    weights = {}
    for entry in manifest["weights"]:
        if "value" not in entry:
            numbers = random_numbers(entry["name"], manifest["seed"], entry["shape"], entry["lo"], entry["hi"])
            weights[entry["name"]] = torch.from_numpy(numbers)
    names = ["visual_feat", "tgt_pose", "tgt_rotation", "bboxes"]
    description = {"blocks": 3, "layers_per_block": 10, "dilation_base": 3, "inputs": [{"name": n} for n in names]}
    return peer_pytorch.Network(weights, description)


def write_long_clip(whole, manifest):
    network = peer_network(manifest)
    inputs = safetensors_file.read_arrays(whole / "A_soundspaces/inputs.safetensors")
    outputs = safetensors_file.read_arrays(whole / "A_soundspaces/outputs.safetensors")
    fused = torch.from_numpy(outputs["fused"][:1].copy())
    heard = network.stack(torch.from_numpy(inputs["src_wav"][:1].copy()), fused, False).numpy()
    error = np.abs(heard - outputs["pred"][:1]).max()
    assert error < 2e-5, error  # as the test allows

    source = random_numbers("long source", 1, (1, 2, LONG_SAMPLES), -0.1, 0.1)
    heard = network.stack(torch.from_numpy(source), fused, False).numpy()
    safetensors_file.write_arrays(HERE / "A_soundspaces/long.safetensors", {"pred": heard[..., ::STEP]})


def main():
    torch.set_grad_enabled(False)
    whole = Path(sys.argv[1])
    write_manifest(whole, "C_tiny_noresnet")
    write_clip(whole, "C_tiny_noresnet", ["fused", "pred", "pred_T1", "pred_T7", "pred_T131"])
    write_manifest(whole, "B_replay")
    write_clip(whole, "B_replay", ["visual_feat", "fused", "pred"])
    released = write_manifest(whole, "A_soundspaces")
    write_clip(whole, "A_soundspaces", ["visual_feat", "fused", "pred"])
    debug = safetensors_file.read_arrays(whole / "A_soundspaces/debug_sample0.safetensors")
    safetensors_file.write_arrays(HERE / "A_soundspaces/debug_sample0.safetensors",
                           {"visual_map": debug["visual_map"].reshape(-1)[::STEP]})
    write_long_clip(whole, released)


main()
