#!/usr/bin/env python3
"""The ViGAS network in PyTorch, layer by layer as in the paper's released code: the peer of
vigas_bench. Weights, inputs and expected outputs come from `vigas_bench --save FOLDER`, or from
reference data with the same file names.

usage: peer_pytorch.py FOLDER [--heads all|last] [--threads N] [--check] [--serve]
  --heads   `all`: also the 29 output heads that are not used, as released; `last`: only the used one
  --check   print the largest difference of the output from FOLDER/outputs.safetensors and end
  --serve   read "whole", "trunk" or "stack" from standard input, answer each with a line: seconds,
            and processor seconds of all threads
"""
import argparse
import json
import os
import sys
import time

import numpy as np
import torch
import torch.nn.functional as F

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import safetensors_file  # noqa: E402


def read_safetensors(path):
    """Tensors by name, and the metadata."""
    dtypes = {"F32": np.float32, "F64": np.float64, "U8": np.uint8, "I64": np.int64}
    tensors, metadata = safetensors_file.read(path)
    arrays = {name: np.frombuffer(data, dtypes[dtype]).reshape(shape)
              for name, (dtype, shape, data) in tensors.items()}
    return {name: torch.from_numpy(array.copy()) for name, array in arrays.items()}, metadata


class Network:
    training = False  # whether batch norms use the statistics of their batch

    def __init__(self, weights, description):
        self.weights = weights
        self.layers = description["blocks"] * description["layers_per_block"]
        self.layers_per_block = description["layers_per_block"]
        self.base = description["dilation_base"]
        self.inputs = [entry["name"] for entry in description["inputs"]]
        # The heads before the last are not in the weight file; their cost does not depend on the values.
        self.heads = [
            f"output_net.{i}" if f"output_net.{i}.first.weight" in weights
            else f"output_net.{self.layers - 1}"
            for i in range(self.layers)
        ]

    def convolve(self, x, name, **options):
        return F.conv1d(x, self.weights[name + ".weight"], self.weights.get(name + ".bias"),
                        **options)

    def convolve_image(self, x, name, **options):
        return F.conv2d(x, self.weights[name + ".weight"], self.weights.get(name + ".bias"),
                        **options)

    def normalize(self, x, name):
        w = self.weights
        return F.batch_norm(x, w[name + ".running_mean"], w[name + ".running_var"],
                            w[name + ".weight"], w[name + ".bias"], self.training, 0.1, 1e-5)

    def block(self, x, name, stride):
        y = F.relu(self.normalize(
            self.convolve_image(x, name + ".conv1", stride=stride, padding=1), name + ".bn1"))
        y = self.normalize(self.convolve_image(y, name + ".conv2", padding=1), name + ".bn2")
        if stride == 2:
            x = self.normalize(self.convolve_image(x, name + ".downsample.0", stride=2),
                               name + ".downsample.1")
        return F.relu(y + x)

    def trunk(self, picture):
        name = "visual_encoder"
        x = self.convolve_image(picture, name + ".0", stride=2, padding=3)
        x = F.max_pool2d(F.relu(self.normalize(x, name + ".1")), 3, 2, 1)
        for stage in range(4, 8):
            for block in range(2):
                stride = 2 if stage > 4 and block == 0 else 1
                x = self.block(x, f"{name}.{stage}.{block}", stride)
        x = F.relu(self.normalize(self.convolve_image(x, "conv1x1.0"), "conv1x1.1"))
        return x.flatten(1)

    def fuse(self, feature, inputs):
        parts = [feature if name == "visual_feat" else inputs[name] for name in self.inputs]
        w = self.weights
        hidden = F.relu(F.linear(torch.cat(parts, 1), w["fusion.0.weight"], w["fusion.0.bias"]))
        return F.linear(hidden, w["fusion.2.weight"], w["fusion.2.bias"])

    def layer(self, x, z, index):
        name = f"hyperconv_wavenet.layers.{index}"
        dilation = self.base ** (index % self.layers_per_block)
        padded = F.pad(x, (dilation, dilation))
        f = self.convolve(padded, name + ".conv.w_f", dilation=dilation)
        g = self.convolve(padded, name + ".conv.w_g", dilation=dilation)
        f = f + self.convolve(z, name + ".conv.v_f")
        g = g + self.convolve(z, name + ".conv.v_g")
        y = torch.sin(torch.tanh(f) * torch.sigmoid(g))
        skip = self.convolve(y, name + ".skip")
        if name + ".residual.weight" in self.weights:
            x = (self.convolve(y, name + ".residual") + x) / 2
        return x, skip

    def head(self, mean, index):
        name = self.heads[index]
        return self.convolve(torch.sin(self.convolve(mean, name + ".first")), name + ".second")

    def stack(self, source, fused, all_heads):
        z = fused.unsqueeze(2)
        x = self.convolve(source, "input")
        skips = []
        for index in range(self.layers):
            x, skip = self.layer(x, z, index)
            skips.append(skip)
        if not all_heads:
            return self.head(torch.stack(skips).mean(0), self.layers - 1)
        outputs = [self.head(torch.stack(skips[:count]).mean(0), count - 1)
                   for count in range(self.layers, 0, -1)]
        return outputs[0]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder")
    parser.add_argument("--heads", choices=["all", "last"], default="last")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--serve", action="store_true")
    options = parser.parse_args()
    torch.set_num_threads(options.threads)
    torch.set_grad_enabled(False)

    weights, metadata = read_safetensors(os.path.join(options.folder, "weights.safetensors"))
    inputs, _ = read_safetensors(os.path.join(options.folder, "inputs.safetensors"))
    network = Network(weights, json.loads(metadata["earpoint.network"]))
    picture = inputs["src_rgb"] if "src_rgb" in inputs else inputs["src_rgb_u8"].float() / 255
    feature = network.trunk(picture)
    fused = network.fuse(feature, inputs)
    all_heads = options.heads == "all"

    measurements = {
        "trunk": lambda: network.trunk(picture),
        "stack": lambda: network.stack(inputs["src_wav"], fused, all_heads),
        "whole": lambda: network.stack(
            inputs["src_wav"], network.fuse(network.trunk(picture), inputs), all_heads),
    }
    if options.check:
        expected, _ = read_safetensors(os.path.join(options.folder, "outputs.safetensors"))
        print(float((measurements["whole"]() - expected["pred"]).abs().max()))
        return
    measurements["whole"]()
    if options.serve:
        print("ready", flush=True)
        for line in sys.stdin:
            start, processor_start = time.perf_counter(), time.process_time()
            measurements[line.strip()]()
            taken = time.perf_counter() - start
            print(f"{taken:.9g} {time.process_time() - processor_start:.9g}", flush=True)
        return
    taken = []
    for _ in range(10):
        start = time.perf_counter()
        measurements["whole"]()
        taken.append(time.perf_counter() - start)
    print(f"least {1e3 * min(taken):.1f} ms, median {1e3 * sorted(taken)[5]:.1f} ms")


if __name__ == "__main__":
    main()
