"""Export of data sets to the formats that training code reads: COCO, BOP, HDF5 and NumPy.

>>> pz.dataset("spec.toml", "out/set")
>>> pz.export.coco("out/set", "out/coco/annotations.json")

The folder is that of ``petzval dataset``. All its manifests count, and pairs are in the order of their numbers.
"""

from .bop_format import bop
from .coco_format import coco
from .hdf5_format import hdf5
from .npz_format import npz

__all__ = ["bop", "coco", "hdf5", "npz"]
