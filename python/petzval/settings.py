"""Settings of pictures: defaults, and those of a camera."""

import operator

from .camera import Camera
from .picture_settings import DEFAULTS


def checked(settings, camera):
    """Return all settings as the engine takes them, with those of a camera where there is none."""
    settings = {**DEFAULTS, **settings}
    if camera is not None:
        if not isinstance(camera, Camera):
            raise TypeError(f"camera: expected a petzval.Camera, not {type(camera).__name__}")
        for name, value in camera.settings().items():
            if settings[name] is None:
                settings[name] = value
    catalogue = () if settings["catalogue"] is None else settings["catalogue"]
    settings["catalogue"] = list(catalogue) if isinstance(catalogue, (list, tuple)) else [catalogue]
    return settings


def count(name, value, least):
    """Return an integer that is at least so large and fits into 32 bits."""
    if value is None:
        return None
    try:
        number = operator.index(value)
    except TypeError:
        raise TypeError(f"{name}={value!r}: expected an integer") from None
    if not least <= number < 2**32:
        raise ValueError(f"{name}={number}: expected {least} to {2**32 - 1}")
    return number


def nine_numbers(look_at):
    """Return eye, target and up of a camera of arrays in one list."""
    expected = "look_at: expected (eye, target) or (eye, target, up), each three numbers"
    try:
        points = [list(map(float, point)) for point in look_at]
    except TypeError:
        raise TypeError(expected) from None
    except ValueError:
        raise ValueError(expected) from None
    if len(points) == 2:
        points.append([0.0, 1.0, 0.0])
    if len(points) != 3 or any(len(point) != 3 for point in points):
        raise ValueError(expected)
    return sum(points, [])
