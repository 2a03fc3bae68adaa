"""Settings of pictures: defaults, checks, and texts that tell pictures apart."""

import operator
from collections.abc import Iterable, Sequence

from .camera import Camera
from .picture_settings import DEFAULTS

#: Settings whose outcome tells pictures apart in place of their texts: files and layers.
_BY_OUTCOME = ("lens", "aov", "catalogue", "spp", "seed", "resolution", "crop")


def checked(settings, camera):
    """Return all settings as the engine takes them, with those of a camera where there is none."""
    settings = {**DEFAULTS, **settings}
    aov = settings["aov"]
    if isinstance(aov, Iterable):
        # list() would make room for the length that an object claims.
        settings["aov"] = [aov] if isinstance(aov, str) else [name for name in aov]
    settings["spp"] = count("spp", settings["spp"], 1)
    settings["seed"] = count("seed", settings["seed"], 0)
    if camera is not None:
        if not isinstance(camera, Camera):
            raise TypeError(f"camera: expected a petzval.Camera, not {type(camera).__name__}")
        for name, value in camera.settings().items():
            if settings[name] is None:
                settings[name] = value
    settings["look_at"] = nine_numbers(settings["look_at"])
    catalogue = () if settings["catalogue"] is None else settings["catalogue"]
    settings["catalogue"] = list(catalogue) if isinstance(catalogue, (list, tuple)) else [catalogue]
    return settings


def said(settings):
    """Return the settings that are given as texts, by name, to tell one picture from another."""
    return {
        name: _text(value)
        for name, value in settings.items()
        if value is not None and name not in _BY_OUTCOME
    }


def _text(value):
    """Return a text that is equal for equal values, whatever their types."""
    if isinstance(value, (str, bool)):
        return str(value)
    if isinstance(value, Sequence) or getattr(value, "ndim", 0):
        return ",".join(_text(item) for item in value)
    try:
        return repr(float(value))
    except TypeError:
        # The engine refuses it.
        return repr(value)


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
    """Return eye, target and up in one list."""
    if look_at is None:
        return None
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
