"""Pinhole camera of a picture in OpenCV's frame: x to the right, y down, z forward, right-handed, millimetres.

petzval's camera has x to the right, y up and z forward, in metres. A world of pbrt is left-handed, so a proper rotation
needs a mirrored world: its y changes sign. A camera that mirrors, as that of glTF does, has a right-handed world, which
stays.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .pairs import Row

Matrix = NDArray[np.float64]

#: OpenCV's camera from petzval's; and the mirror image of a world or an object.
FLIP_Y = np.diag([1.0, -1.0, 1.0])
_SAME = np.eye(3)


@dataclass
class Pinhole:
    """The pinhole camera of a picture.

    :param matrix: camera matrix of the pixels of the file, whose centres are whole numbers
    :param rotation: camera from world
    :param translation: camera from world (mm)
    :param world: mirror of the world, 3 x 3: the world above from that of petzval
    :param unit: a unit of the scene's world (mm)
    :param centre: depth of the projection centre behind the origin of petzval's camera (m)
    :param distortion: the model of distortion and its coefficients; empty for a pinhole
    """

    matrix: Matrix
    rotation: Matrix
    translation: Matrix
    world: Matrix
    unit: float
    centre: float
    distortion: dict[str, Any]


def pinhole(row: Row, picture: str, origin: tuple[int, int]) -> Pinhole:
    """Return the camera of a picture whose first pixel stands here in the whole frame.

    :raises ValueError: no camera matrix describes the lens
    """
    place = f"pair {row['pair']}: the {picture} picture"
    camera = row[picture]["camera"]
    if camera is None:
        raise ValueError(
            f"{place} has no camera matrix, as no model describes its lens; use picture='clean' of a data set with "
            "the clean camera 'pinhole'"
        )
    pose = np.array(row[picture]["world_from_camera"], np.float64)
    scales = np.linalg.norm(pose[:, :3], axis=0)
    scale = float(scales.mean())
    axes = pose[:, :3] / scale
    if not np.allclose(axes.T @ axes, _SAME, atol=1e-4):
        raise ValueError(f"{place} has a camera of axes {scales.tolist()}; expected a rotation and one scale")
    world = mirror(axes)
    rotation = FLIP_Y @ axes.T @ world
    centre = np.array(camera.get("projection_centre_mm", [0.0, 0.0, 0.0]), np.float64)
    eye = world @ pose[:, 3] * (1000.0 / scale)
    matrix = np.array(camera["matrix"], np.float64)
    matrix[:2, 2] -= origin
    distortion = {"model": camera["model"], **camera["distortion"]} if camera.get("distortion") else {}
    translation = -rotation @ eye - FLIP_Y @ centre
    return Pinhole(matrix, rotation, translation, world, 1000.0 / scale, float(centre[2]) / 1000.0, distortion)


def mirror(axes: Matrix) -> Matrix:
    """Return the mirror that makes a product with a left-handed frame right-handed: none if it is so already."""
    return FLIP_Y if np.linalg.det(axes) > 0 else _SAME


def object_pose(camera: Pinhole, pose: Matrix) -> tuple[Matrix, Matrix, Matrix]:
    """Return rotation and translation (mm) of camera from model, and the matrix of model (mm) from object.

    :param pose: ``world_from_object`` of petzval, 3 x 4
    :raises ValueError: the object is sheared or has several scales
    """
    scale = float(np.linalg.norm(pose[:, :3], axis=0).mean())
    axes = pose[:, :3] / scale if scale > 0 else np.zeros((3, 3))
    if not np.allclose(axes.T @ axes, _SAME, atol=1e-4):
        raise ValueError(f"world_from_object {pose.tolist()}: expected a rotation and one scale")
    # The model is mirrored where the object would turn the world into its mirror image.
    model = _SAME if np.linalg.det(camera.world @ axes) > 0 else FLIP_Y
    rotation = camera.rotation @ camera.world @ axes @ model
    translation = camera.rotation @ camera.world @ pose[:, 3] * camera.unit + camera.translation
    return rotation, translation, model * (scale * camera.unit)
