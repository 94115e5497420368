#!/usr/bin/env python3
"""Training steps of the ViGAS network in PyTorch, on the processor: the peer of training_bench. Only
the output head that is used is computed. Weights, inputs and expected gradients come from
`training_bench --save FOLDER`.

usage: peer_training.py FOLDER [--threads N] [--check] [--serve]
  --check   print the largest difference of a gradient from FOLDER/gradients.safetensors, as a
            fraction of the largest element of its tensor, without the image trunk's, and end
  --serve   read "step" from standard input, answer each with a line: seconds, and processor seconds
            of all threads
"""
import argparse
import json
import os
import sys
import time

import torch

from peer_pytorch import Network, read_safetensors

LEARNING_RATE = 1e-5  # small, so that the weights hardly change


class Trainer:
    def __init__(self, folder):
        weights, metadata = read_safetensors(os.path.join(folder, "weights.safetensors"))
        self.inputs, _ = read_safetensors(os.path.join(folder, "inputs.safetensors"))
        description = json.loads(metadata["earpoint.network"])
        self.hop = description["hop_samples"]
        self.parameters = {name: tensor.requires_grad_() for name, tensor in weights.items()
                           if ".running_" not in name}
        self.network = Network(weights, description)
        self.network.training = True
        self.window = torch.hamming_window(400)
        self.optimizer = torch.optim.Adam(self.parameters.values(), lr=LEARNING_RATE)

    def magnitude(self, sounds):
        spectrum = torch.stft(sounds.flatten(0, 1), 512, self.hop, 400, self.window,
                              pad_mode="constant", return_complex=True)
        return torch.view_as_real(spectrum).square().sum(3).clamp_min(1e-7).sqrt()

    def gradients(self):
        self.optimizer.zero_grad(set_to_none=True)
        inputs, network = self.inputs, self.network
        feature = network.trunk(inputs["src_rgb"]) if "src_rgb" in inputs else None
        prediction = network.stack(inputs["src_wav"], network.fuse(feature, inputs), False)
        difference = self.magnitude(prediction) - self.magnitude(inputs["tgt_wav"])
        loss = difference.abs().mean()
        loss.backward()
        return loss.item()

    def step(self):
        self.gradients()
        self.optimizer.step()

    def largest_difference(self, expected):
        self.gradients()
        return max(float((self.parameters[name].grad - gradient).abs().max() / gradient.abs().max())
                   for name, gradient in expected.items()
                   if not name.startswith(("visual_encoder.", "conv1x1.")))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--serve", action="store_true")
    options = parser.parse_args()
    torch.set_num_threads(options.threads)

    trainer = Trainer(options.folder)
    if options.check:
        expected, _ = read_safetensors(os.path.join(options.folder, "gradients.safetensors"))
        print(trainer.largest_difference(expected))
        return
    trainer.step()
    if options.serve:
        print("ready", flush=True)
        for _ in sys.stdin:
            start, processor_start = time.perf_counter(), time.process_time()
            trainer.step()
            taken = time.perf_counter() - start
            print(f"{taken:.9g} {time.process_time() - processor_start:.9g}", flush=True)


if __name__ == "__main__":
    main()
