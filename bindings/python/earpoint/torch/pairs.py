"""Pairs of viewpoints of a data set."""
from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import Any

import torch
from torch import Tensor
from torch.utils.data import Dataset

from .. import _earpoint
from .vigas import Vigas


class PairDataset(Dataset[dict[str, Any]]):
    """Pairs of viewpoints of a data set that ``earpoint simulate`` or ``earpoint record prepare`` made, or of a
    published one (SoundSpaces-NVAS v16, Replay-NVAS v3), read as ``earpoint train`` reads them.

    An item is a dict that torch.utils.data.DataLoader makes batches of:

    ============  =================  ==================================================================
    src_wav       float32 [2, T]     the speech as the source view hears it, 16 kHz, left ear first
    tgt_wav       float32 [2, T]     the same at the target
    src_rgb       uint8 [3, H, W]    the source view's picture (Replay: 216 x 384); with a network: float32 of its
                                     size, 0 to 1
    tgt_pose      float32 [3]        of the target, as the layout's released loader or the network has it
    tgt_rotation  float32 [2 or 6]   the same
    bboxes        float32 [4]        the speaker's box in the picture; zeros: out of sight
    position      float64 [3]        of the target, metres from the source: front, left, up
    orientation   float64 [4]        of the target's head, quaternion w, x, y, z in the source's frame
    name          str                scene, clip, viewpoints and second
    ============  =================  ==================================================================

    Any number of workers may read, forked or spawned: each process opens the data set when it reads its first item, and
    keeps up to 256 MB of it.

    :param folder: the data set's
    :param split: train, val, test, or another that is there
    :param network: a ViGAS network (or its description) whose encoding of poses, boxes and pictures is wanted; None: the
        released loader's
    :param draw: ``frozen``: the pair list beside the data set; without one, the list that ``earpoint evaluate`` draws.
        ``every-target``: a list drawn like that, with ``seed``. ``released``: as the released test draws. Of Replay the
        first two mean the last one
    :param seed: of ``every-target``
    :param random: draw source, speaker and second anew at every access (of Replay: the views), by PyTorch's generator,
        which a DataLoader seeds in each worker: for training
    :param layout: ``soundspaces`` or ``replay``; None: whichever the folder holds
    :param align: Replay: move the source by its delay to the target, as the released loader does
    :raises InputError: if there is no such data set or split, or a file is missing or malformed
    """

    def __init__(self, folder: str | os.PathLike[str], split: str = "train", *,
                 network: Vigas | Mapping[str, Any] | None = None, draw: str = "frozen", seed: int = 0,
                 random: bool = False, layout: str | None = None, align: bool = False) -> None:
        description = network.description if isinstance(network, Vigas) else network
        text = None if description is None else json.dumps(dict(description))
        self._arguments = (os.path.abspath(os.fspath(folder)), split, layout, draw, int(seed), text, bool(align))
        self.random = random
        self._reader: _earpoint.PairReader | None = None
        self._process = -1
        self._count = len(self._opened())

    def _opened(self) -> _earpoint.PairReader:
        """This process' own reader: one that was there before a fork may be in the middle of something."""
        if self._reader is None or self._process != os.getpid():
            self._reader = _earpoint.PairReader(*self._arguments)
            self._process = os.getpid()
        return self._reader

    @property
    def layout(self) -> str:
        """``soundspaces`` or ``replay``"""
        return self._opened().layout()

    def __len__(self) -> int:
        return self._count

    def __getitem__(self, index: int) -> dict[str, Any]:
        if not -self._count <= index < self._count:
            raise IndexError(f"pair {index} of {self._count}")
        reader = self._opened()
        place = index % self._count
        if self.random:
            item = reader.drawn(place, int(torch.randint(2**62, ())))
        else:
            item = reader.item(place)
        return {name: self._tensor(value) for name, value in item.items()}

    @staticmethod
    def _tensor(value: Any) -> Tensor | str:
        return value if isinstance(value, str) else torch.from_numpy(value)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_reader": None}
