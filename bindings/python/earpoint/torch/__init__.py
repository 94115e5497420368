"""PyTorch: pairs of viewpoints as a Dataset, and ViGAS as a module to train on."""
from .pairs import PairDataset
from .vigas import Vigas, magnitude_loss, vigas

__all__ = ["PairDataset", "Vigas", "magnitude_loss", "vigas"]
