"""Denoising by Intel's Open Image Denoise, which is looked for when it is first needed."""

import contextlib
import ctypes
import ctypes.util
import importlib.util
import os
import sys
from pathlib import Path

import numpy as np

#: Environment variable that names the library.
VARIABLE = "PETZVAL_OIDN"
_FLOAT3 = 3
_CPU_DEVICE = 1

_library = None


class DenoiserMissing(ImportError):
    """Open Image Denoise is not installed."""


def _candidates():
    """Yield paths and names of the library: the user's, the wheel pyoidn's, the system's."""
    named = os.environ.get(VARIABLE)
    if named:
        yield named
        return
    wheel = importlib.util.find_spec("pyoidn")
    if wheel is not None and wheel.origin is not None:
        folder = Path(wheel.origin).parent / "oidn"
        pattern = {"win32": "bin/OpenImageDenoise.dll", "darwin": "lib/libOpenImageDenoise.*dylib"}
        found = sorted(folder.glob(pattern.get(sys.platform, "lib/libOpenImageDenoise.so*")))
        yield from map(str, found)
    system = ctypes.util.find_library("OpenImageDenoise")
    if system:
        yield system


def _load():
    """Return the library with the types of its functions."""
    global _library
    if _library is not None:
        return _library
    problems = []
    for candidate in _candidates():
        try:
            library = ctypes.CDLL(candidate)
            library.oidnNewDevice
        except (OSError, AttributeError) as problem:
            problems.append(f"{candidate}: {problem}")
            continue
        pointer, text, size = ctypes.c_void_p, ctypes.c_char_p, ctypes.c_size_t
        for name, result, arguments in [
            ("oidnNewDevice", pointer, [ctypes.c_int]),
            ("oidnCommitDevice", None, [pointer]),
            ("oidnReleaseDevice", None, [pointer]),
            ("oidnGetDeviceError", ctypes.c_int, [pointer, ctypes.POINTER(text)]),
            ("oidnNewFilter", pointer, [pointer, text]),
            ("oidnSetSharedFilterImage", None, [pointer, text, pointer, ctypes.c_int] + [size] * 5),
            ("oidnSetFilterBool", None, [pointer, text, ctypes.c_bool]),
            ("oidnCommitFilter", None, [pointer]),
            ("oidnExecuteFilter", None, [pointer]),
            ("oidnReleaseFilter", None, [pointer]),
        ]:
            function = getattr(library, name)
            function.restype, function.argtypes = result, arguments
        _library = library
        return library
    hint = f"pip install pyoidn, or name the library in the environment variable {VARIABLE}"
    found = "; ".join(problems) or "no library OpenImageDenoise was found"
    raise DenoiserMissing(f"Open Image Denoise is needed to denoise: {found}; {hint}")


class _Device:
    """A device of the library."""

    def __init__(self):
        self.library = _load()
        # The result of the CPU does not depend on the graphics card of a machine.
        self.handle = self.library.oidnNewDevice(_CPU_DEVICE)
        self.library.oidnCommitDevice(self.handle)
        self.check()

    def check(self):
        message = ctypes.c_char_p()
        if self.library.oidnGetDeviceError(self.handle, ctypes.byref(message)):
            raise RuntimeError(f"Open Image Denoise: {(message.value or b'').decode()}")

    def run(self, images, flags):
        """Return the result of the filter for ray-traced pictures of height x width x 3."""
        output = np.empty_like(next(iter(images.values())))
        library, height, width = self.library, *output.shape[:2]
        handle = library.oidnNewFilter(self.handle, b"RT")
        try:
            for name, array in [*images.items(), ("output", output)]:
                data = array.ctypes.data_as(ctypes.c_void_p)
                library.oidnSetSharedFilterImage(
                    handle, name.encode(), data, _FLOAT3, width, height, 0, 0, 0
                )
            for name in flags:
                library.oidnSetFilterBool(handle, name.encode(), True)
            library.oidnCommitFilter(handle)
            library.oidnExecuteFilter(handle)
            self.check()
        finally:
            library.oidnReleaseFilter(handle)
        return output

    def close(self):
        self.library.oidnReleaseDevice(self.handle)


def denoised(pixels, albedo=None, normal=None):
    """Return pixels without noise: linear light, height x width x 3.

    ``albedo`` and ``normal`` (height x width x 3) keep the edges of textures and shapes. They are those
    that the lens sees, blurred and noisy like the picture, and are denoised first.

    :raises DenoiserMissing: Open Image Denoise is not installed
    """
    images = {"color": _image("pixels", pixels)}
    if albedo is not None:
        images["albedo"] = albedo
        if normal is not None:
            images["normal"] = normal
    images = _of_one_size(images)
    with _device() as device:
        for name in list(images)[1:]:
            images[name] = device.run({name: images[name]}, [])
        flags = ["hdr", "cleanAux"] if len(images) > 1 else ["hdr"]
        return device.run(images, flags)


def filtered(images, flags):
    """Return the result of one filter for ray-traced pictures.

    :param images: height x width x 3 by name: color, albedo, normal
    :param flags: the filter's options that are on: hdr, cleanAux
    :raises DenoiserMissing: Open Image Denoise is not installed
    """
    images = _of_one_size(images)
    with _device() as device:
        return device.run(images, flags)


@contextlib.contextmanager
def _device():
    device = _Device()
    try:
        yield device
    finally:
        device.close()


def _of_one_size(images):
    """Return the images as arrays, which must have the size of the first."""
    arrays = {name: _image(name, values) for name, values in images.items()}
    shape = next(iter(arrays.values())).shape
    for name, array in arrays.items():
        if array.shape != shape:
            raise ValueError(f"{name}: the shape is {array.shape}; expected {shape}")
    return arrays


def _image(name, values):
    array = np.ascontiguousarray(values, dtype=np.float32)
    if array.ndim != 3 or array.shape[2] != 3 or not array.size:
        raise ValueError(f"{name}: the shape is {array.shape}; expected height x width x 3")
    return array
