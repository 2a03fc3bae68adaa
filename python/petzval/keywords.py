"""Functions whose keywords are settings of pictures."""

import difflib
import functools
import inspect

from .picture_settings import DEFAULTS


def takes(settings, refused=None):
    """Return a decorator for a function that hands its ``**settings`` on.

    Signature and help then list them all, and an unknown keyword is a :class:`TypeError` that names the
    nearest one.

    :param settings: the class whose keys are the settings
    :param refused: settings of other functions that make no sense here, and why
    """
    keys = settings.__annotations__

    def decorate(function):
        signature = inspect.signature(function)
        own = [p for p in signature.parameters.values() if p.kind is not p.VAR_KEYWORD]
        more = [
            inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=DEFAULTS[name])
            for name in DEFAULTS
            if name in keys
        ]
        decorated = _checked(function, [p.name for p in (*own, *more)], refused or {})
        decorated.__signature__ = signature.replace(parameters=[*own, *more])
        return decorated

    return decorate


def named(function):
    """Return a function whose unknown keywords are a :class:`TypeError` that names the nearest one."""
    return _checked(function, list(inspect.signature(function).parameters), {})


def _checked(function, known, refused):
    """Return a function that refuses keywords which are not known."""

    @functools.wraps(function)
    def call(*args, **keywords):
        for name, value in keywords.items():
            if name in refused:
                if value is not None:
                    raise ValueError(f"{name}: {refused[name]}")
            elif name not in known:
                near = difflib.get_close_matches(name, known, 1)
                hint = f"; did you mean {near[0]!r}?" if near else ""
                caller = function.__qualname__.replace(".__init__", "")
                raise TypeError(f"{caller}() got an unexpected keyword argument {name!r}{hint}")
        return function(*args, **keywords)

    return call
