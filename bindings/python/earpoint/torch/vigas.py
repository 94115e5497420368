"""ViGAS in plain PyTorch: the network of Novel-View Acoustic Synthesis (Chen et al., CVPR 2023), written from the paper
and from docs/formats.md. Parameters have the names of the released code's state dict."""
from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import torch
from torch import Tensor, nn
from torch.nn import functional

from .._weights import load_weights, save_weights


class ResidualBlock(nn.Module):
    """A basic block of ResNet-18."""

    def __init__(self, inputs: int, outputs: int, stride: int) -> None:
        super().__init__()
        self.conv1 = nn.Conv2d(inputs, outputs, 3, stride, 1, bias=False)
        self.bn1 = nn.BatchNorm2d(outputs)
        self.conv2 = nn.Conv2d(outputs, outputs, 3, 1, 1, bias=False)
        self.bn2 = nn.BatchNorm2d(outputs)
        self.downsample: nn.Module | None = None
        if stride != 1:
            self.downsample = nn.Sequential(nn.Conv2d(inputs, outputs, 1, stride, bias=False),
                                            nn.BatchNorm2d(outputs))

    def forward(self, x: Tensor) -> Tensor:
        y = functional.relu(self.bn1(self.conv1(x)))
        y = self.bn2(self.conv2(y))
        return functional.relu(y + (x if self.downsample is None else self.downsample(x)))


def picture_trunk(channels: int) -> nn.Sequential:
    """ResNet-18 without pooling and classifier: [clips, 3, height, width] to [clips, 8 channels, height / 32, ...]."""
    layers: list[nn.Module] = [nn.Conv2d(3, channels, 7, 2, 3, bias=False), nn.BatchNorm2d(channels), nn.ReLU(),
                               nn.MaxPool2d(3, 2, 1)]
    before = channels
    for stage in range(4):
        width = channels << stage
        layers.append(nn.Sequential(ResidualBlock(before, width, 1 if stage == 0 else 2),
                                    ResidualBlock(width, width, 1)))
        before = width
    return nn.Sequential(*layers)


class ConditionedConvolution(nn.Module):
    """Both gates of a layer: a dilated convolution of the sound, moved by the conditioning vector."""

    def __init__(self, channels: int, conditioning: int, taps: int, dilation: int, acausal: bool) -> None:
        super().__init__()
        self.w_f = nn.Conv1d(channels, channels, taps, dilation=dilation)
        self.w_g = nn.Conv1d(channels, channels, taps, dilation=dilation)
        self.v_f = nn.Conv1d(conditioning, channels, 1)
        self.v_g = nn.Conv1d(conditioning, channels, 1)
        # The tap that reads the output's own sample.
        self.centre = (taps - 1) // 2 if acausal else taps - 1

    def convolve(self, layer: nn.Conv1d, x: Tensor) -> Tensor:
        taps, dilation = layer.kernel_size[0], layer.dilation[0]
        if dilation >= x.shape[2]:  # every other tap reads nothing but zeros beyond the ends
            return functional.conv1d(x, layer.weight[:, :, self.centre:self.centre + 1], layer.bias)
        padded = functional.pad(x, (self.centre * dilation, (taps - 1 - self.centre) * dilation))
        return layer(padded)

    def forward(self, x: Tensor, z: Tensor) -> Tensor:
        f = self.convolve(self.w_f, x) + self.v_f(z)
        g = self.convolve(self.w_g, x) + self.v_g(z)
        return torch.sin(torch.tanh(f) * torch.sigmoid(g))


class GatedLayer(nn.Module):
    def __init__(self, description: Mapping[str, Any], index: int, has_residual: bool) -> None:
        super().__init__()
        channels = description["channels"]
        dilation = description["dilation_base"] ** (index % description["layers_per_block"])
        self.conv = ConditionedConvolution(channels, description["conditioning_width"], description["kernel_size"],
                                           dilation, description["acausal"])
        self.residual = nn.Conv1d(channels, channels, 1) if has_residual else None
        self.skip = nn.Conv1d(channels, channels, 1)


class OutputHead(nn.Module):
    def __init__(self, channels: int, outputs: int) -> None:
        super().__init__()
        self.first = nn.Conv1d(channels, channels, 1)
        self.second = nn.Conv1d(channels, outputs, 1)

    def forward(self, x: Tensor) -> Tensor:
        return self.second(torch.sin(self.first(x)))


class Vigas(nn.Module):
    """A ViGAS network.

    :param description: as :attr:`earpoint.Weights.description`
    :param released: also the parameters without effect on the output that the released class has (all output heads but
        the last, the last layer's ``residual``), as zeros: then its state dict is that of the released code
    """

    def __init__(self, description: Mapping[str, Any], *, released: bool = False) -> None:
        super().__init__()
        if description["network"] != "vigas":
            raise ValueError(f"description: expected a network 'vigas', found {description['network']!r}")
        self.description = dict(description)
        encoder = description["image_encoder"]
        if encoder is not None:
            trunk = encoder.get("trunk_channels", 64)
            self.visual_encoder = picture_trunk(trunk)
            self.conv1x1 = nn.Sequential(nn.Conv2d(8 * trunk, encoder["channels"], 1),
                                         nn.BatchNorm2d(encoder["channels"]))
        width = sum(entry["width"] for entry in description["inputs"])
        self.fusion = nn.Sequential(nn.Linear(width, description["fusion_width"]), nn.ReLU(),
                                    nn.Linear(description["fusion_width"], description["conditioning_width"]))
        channels, ears = description["channels"], description["audio_channels"]
        count = description["blocks"] * description["layers_per_block"]
        self.input = nn.Conv1d(ears, channels, 1)
        self.hyperconv_wavenet = nn.Module()
        self.hyperconv_wavenet.layers = nn.ModuleList(
            GatedLayer(description, index, released or index + 1 < count) for index in range(count))
        heads = range(count) if released else range(count - 1, count)
        self.output_net = nn.ModuleDict({str(index): OutputHead(channels, ears) for index in heads})
        for name, value in self.named_parameters():
            if self.is_without_effect(name):
                nn.init.zeros_(value)

    def is_without_effect(self, name: str) -> bool:
        """Whether a parameter is one that the released class has and the output does not depend on."""
        last = self.description["blocks"] * self.description["layers_per_block"] - 1
        if name.startswith("output_net."):
            return not name.startswith(f"output_net.{last}.")
        return name.startswith(f"hyperconv_wavenet.layers.{last}.residual.")

    def picture_feature(self, src_rgb: Tensor) -> Tensor:
        """``visual_feat``, [clips, width], of pictures: uint8 [clips, 3, height, width] of any size, or float of the
        encoder's size from 0 to 1."""
        encoder = self.description["image_encoder"]
        if src_rgb.dtype == torch.uint8:
            size = (encoder["height_px"], encoder["width_px"])
            x = src_rgb.to(self.input.weight.dtype)
            if tuple(x.shape[2:]) != size:
                x = functional.interpolate(x, size, mode="bilinear", align_corners=False)
            src_rgb = x / 255
        return functional.relu(self.conv1x1(self.visual_encoder(src_rgb))).flatten(1)

    def fuse(self, inputs: Mapping[str, Tensor]) -> Tensor:
        """The conditioning vector z, [clips, conditioning width]."""
        parts = []
        for entry in self.description["inputs"]:
            name = entry["name"]
            if name == "visual_feat" and self.description["image_encoder"] is not None and name not in inputs:
                parts.append(self.picture_feature(inputs["src_rgb"]))
            else:
                parts.append(inputs[name])
        return self.fusion(torch.cat(parts, 1))

    def forward(self, src_wav: Tensor, **inputs: Tensor) -> Tensor:
        """The sound at the target.

        :param src_wav: float [clips, 2, samples] at the description's sample rate, without ambient sound
        :param inputs: what the description lists: src_rgb (or visual_feat), tgt_pose, tgt_rotation, bboxes, each with
            the clips along the first axis
        :return: of the shape of src_wav
        """
        z = self.fuse(inputs).unsqueeze(2)
        x = self.input(src_wav)
        layers = self.hyperconv_wavenet.layers
        skips = torch.zeros_like(x)
        for index, layer in enumerate(layers):
            y = layer.conv(x, z)
            skips = skips + layer.skip(y)
            if index + 1 < len(layers):
                x = (layer.residual(y) + x) / 2
        return self.output_net[str(len(layers) - 1)](skips / len(layers))

    def save(self, file: str | os.PathLike[str]) -> None:
        """Writes a weight file that ``earpoint render --model FILE``, ``earpoint model export`` and vigas() take."""
        tensors = {name: value.detach().cpu().numpy() for name, value in self.state_dict().items()
                   if not name.endswith(".num_batches_tracked") and not self.is_without_effect(name)}
        save_weights(file, tensors, self.description)


def vigas(file: str | os.PathLike[str] = "vigas", *, released: bool = False) -> Vigas:
    """A ViGAS network with the weights of a file, in evaluation mode: its output is that of Earpoint's engine. Call
    ``.train()`` on it to go on training.

    :param file: a weight file, or the name of a model; ``earpoint model import`` makes one of the authors' checkpoint
    :param released: see :class:`Vigas`
    :raises InputError: if it is no weight file
    :raises ValueError: if it is of another network
    """
    weights = load_weights(file)
    network = Vigas(weights.description, released=released)
    state = network.state_dict()
    for name, value in state.items():
        if name in weights.tensors:
            state[name] = torch.from_numpy(weights.tensors[name].astype("float32"))
        elif not name.endswith(".num_batches_tracked") and not network.is_without_effect(name):
            raise ValueError(f"{os.fspath(file)}: tensor '{name}' is missing")
    network.load_state_dict(state)
    return network.eval()


def magnitude_loss(prediction: Tensor, target: Tensor) -> Tensor:
    """The paper's loss: mean absolute difference of the magnitudes of short-time spectra (512 points, hop 160, periodic
    Hamming window of 400 samples, zeros beyond the ends).

    :param prediction: float [clips, channels, samples], 16 kHz
    :param target: of the same shape
    :return: a scalar
    """
    def magnitudes(sound: Tensor) -> Tensor:
        window = torch.hamming_window(400, dtype=sound.dtype, device=sound.device)
        spectrum = torch.stft(sound.flatten(0, -2), 512, 160, 400, window, center=True, pad_mode="constant",
                              return_complex=True)
        power = spectrum.real.square() + spectrum.imag.square()
        return power.clamp(min=1e-7).sqrt()

    return functional.l1_loss(magnitudes(prediction), magnitudes(target))
