"""Weight files."""
from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _earpoint
from ._api import model_file

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from ._api import PathLike

_DESCRIPTION = "earpoint.network"


@dataclass
class Weights:
    """A network's weights and what they are of."""

    tensors: dict[str, NDArray[Any]]
    """By name; docs/formats.md lists them"""
    description: dict[str, Any]
    """The network's shape: docs/formats.md"""
    metadata: dict[str, str] = field(default_factory=dict)
    """What else the file's header says, e.g. the range of the training data"""
    file: str = ""
    """Its path"""

    @property
    def kind(self) -> str:
        """``gtf``, ``vigas``, ``vam``, ``rt60_estimator`` or ``people``"""
        return str(self.description["network"])

    @property
    def parameters(self) -> int:
        """Numbers in all tensors."""
        return sum(tensor.size for tensor in self.tensors.values())


def load_weights(file: PathLike) -> Weights:
    """Reads a weight file, all of it checked.

    :param file: a weight file, or the name of a model (:func:`models`)
    :return: tensors as NumPy arrays, which may be changed; bfloat16 becomes float32
    :raises InputError: if there is no such model, or it is not a weight file of a known network
    """
    tensors, metadata, path, _ = _earpoint.load_weights(model_file(file))
    return Weights(tensors, json.loads(metadata.pop(_DESCRIPTION)), metadata, path)


def save_weights(file: PathLike, tensors: Mapping[str, ArrayLike], description: Mapping[str, Any],
                 metadata: Mapping[str, str] | None = None) -> None:
    """Writes a weight file that every part of Earpoint loads: render, Renderer, ``earpoint model export``.

    :param file: to write, by convention .safetensors
    :param tensors: by name
    :param description: as :attr:`Weights.description`
    :param metadata: as :attr:`Weights.metadata`
    :raises InputError: if the tensors are not those that the description asks for, hold NaN, or the file cannot be
        written
    """
    kept = {**(metadata or {}), _DESCRIPTION: json.dumps(description, sort_keys=True)}
    _earpoint.save_weights(os.fspath(file), {name: np.asarray(tensor) for name, tensor in tensors.items()}, kept)
