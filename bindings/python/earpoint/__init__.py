"""Earpoint: hear a recorded moment from another place.

>>> import earpoint
>>> there = earpoint.render(audio, 48000, image=frame, translate=(1.0, -0.5, 0.0), yaw=90)

Sounds are float32 arrays [2, samples], left ear first, from -1 to 1. Places are metres from the camera: x front, y
left, z up. Angles are degrees: a positive yaw turns to the left, pitch up, roll towards the right shoulder.

Bad data from outside raise :class:`InputError`, a ValueError of one line: where, what is wrong, what to do. Arrays of
another shape or type raise ValueError. docs/python.md is the guide; ``earpoint.torch`` is for PyTorch.
"""
from ._api import Renderer, Stream, models, render
from ._earpoint import InputError
from ._earpoint import version as _version
from ._scene import Response, Scene, locate, metrics, reverberation, simulate, trace
from ._weights import Weights, load_weights, save_weights

__version__ = _version()
__all__ = ["InputError", "Renderer", "Response", "Scene", "Stream", "Weights", "load_weights", "locate", "metrics",
           "models", "render", "reverberation", "save_weights", "simulate", "trace"]
