"""Pictures as numpy arrays: EXR, PFM and NPY files in, PNG files out."""

import struct
import zlib

import numpy as np


def read(path):
    """Returns the picture in a file as float64, rows from the top, with channels R, G, B."""
    reader = {".exr": read_exr, ".pfm": read_pfm, ".npy": np.load}[path.suffix]
    return np.asarray(reader(path), dtype=np.float64)[:, :, :3]


def read_pfm(path):
    with open(path, "rb") as file:
        kind, size, scale = (file.readline().strip() for _ in range(3))
        if kind != b"PF":
            raise ValueError(f"{path}: expected a PFM of three channels, found {kind!r}")
        width, height = map(int, size.split())
        order = "<" if float(scale) < 0 else ">"
        values = np.fromfile(file, order + "f4", 3 * width * height)
    return values.reshape(height, width, 3)[::-1]


def read_exr(path, spectra=False):
    """Reads R, G and B, or Y in all three, or the channels of spectra, of an EXR with one part in scan lines,
    uncompressed or ZIP."""
    data = path.read_bytes()
    at, header = 8, {}
    while data[at]:
        name, kind = data[at:].split(b"\0", 2)[:2]
        at += len(name) + len(kind) + 2
        size = struct.unpack_from("<i", data, at)[0]
        header[name.decode()] = data[at + 4 : at + 4 + size]
        at += 4 + size
    at += 1
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    compression = header["compression"][0]
    lines = {0: 1, 2: 1, 3: 16}.get(compression)
    if lines is None:
        raise ValueError(f"{path}: EXR compression {compression} is not supported; use none or ZIP")
    channels = exr_channels(header["channels"])
    row = np.dtype([(name, kind, width) for name, kind in channels])
    names = "YYY" if "R" not in row.names else "RGB"
    if spectra:
        names = [name for name in row.names if name.startswith("S0.")]
    picture = np.empty((height, width, len(names)))
    for (offset,) in struct.iter_unpack("<Q", data[at : at + 8 * -(-height // lines)]):
        y, size = struct.unpack_from("<2i", data, offset)
        block = data[offset + 8 : offset + 8 + size]
        count = min(lines, y1 + 1 - y)
        if compression and size < count * row.itemsize:
            block = exr_unzip(block)
        rows = np.frombuffer(block, row, count)
        for i, name in enumerate(names):
            picture[y - y0 : y - y0 + count, :, i] = rows[name]
    return picture


def exr_channels(text):
    """Returns the names and number formats of the channels in the order of the file."""
    channels = []
    while text[0]:
        name, rest = text.split(b"\0", 1)
        kind = struct.unpack_from("<i", rest)[0]
        channels.append((name.decode(), ("<u4", "<f2", "<f4")[kind]))
        text = rest[16:]
    return channels


def exr_unzip(block):
    """Undoes deflate, the differences of bytes, and the split into odd and even bytes."""
    values = np.frombuffer(zlib.decompress(block), np.uint8).astype(np.int64)
    values[1:] -= 128
    values = np.cumsum(values).astype(np.uint8)
    half = (len(values) + 1) // 2
    bytes_ = np.empty_like(values)
    bytes_[0::2], bytes_[1::2] = values[:half], values[half:]
    return bytes_.tobytes()


def write_png(path, values):
    """Writes an array of bytes, height x width x 3, as a PNG."""

    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    height, width, _ = values.shape
    rows = np.zeros((height, 1 + 3 * width), np.uint8)
    rows[:, 1:] = values.reshape(height, -1)
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0))
        + chunk(b"IDAT", zlib.compress(rows.tobytes(), 6))
        + chunk(b"IEND", b"")
    )


def for_display(picture, mean):
    """Returns bytes in sRGB; a picture with this mean luminance becomes a medium grey."""
    linear = np.clip(picture * (0.2 / mean), 0, 1)
    low, high = 12.92 * linear, 1.055 * np.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055
    return (255 * np.where(linear <= 0.0031308, low, high) + 0.5).astype(np.uint8)
