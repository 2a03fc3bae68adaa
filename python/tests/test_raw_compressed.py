"""Raw files that are compressed by lossless JPEG, judged by libraw and imagecodecs."""

import struct

import numpy as np
import pytest

import petzval as pz

rawpy = pytest.importorskip("rawpy")

WIDTH, HEIGHT = 85, 59


def lossless_jpeg(samples, components, predictor):
    """Return samples of rows x columns as lossless JPEG (ITU-T T.81, annex H) of several components a pixel."""
    rows, columns = samples.shape
    grid = samples.reshape(rows, columns // components, components).astype(int)
    predicted = np.empty_like(grid)
    left, above, corner = grid[1:, :-1], grid[:-1, 1:], grid[:-1, :-1]
    predicted[0, 1:], predicted[1:, 0], predicted[0, 0] = grid[0, :-1], grid[:-1, 0], 1 << 15
    predicted[1:, 1:] = {
        1: left,
        2: above,
        3: corner,
        4: left + above - corner,
        5: left + ((above - corner) >> 1),
        6: above + ((left - corner) >> 1),
        7: (left + above) >> 1,
    }[predictor]
    bits = []
    for difference in (grid - predicted).ravel() & 0xFFFF:
        difference = difference if difference <= 32768 else difference - 65536
        size = int(abs(difference)).bit_length()
        # All 17 symbols have codes of five bits.
        bits.append(f"{size:05b}")
        if 0 < size < 16:
            bits.append(f"{difference if difference > 0 else difference + (1 << size) - 1:0{size}b}")
    text = "".join(bits)
    text += "1" * (-len(text) % 8)
    data = int(text, 2).to_bytes(len(text) // 8, "big").replace(b"\xff", b"\xff\0")
    table = bytes([0, *[0] * 4, 17, *[0] * 11, *range(17)])
    frame = struct.pack(">BHHB", 16, rows, columns // components, components)
    frame += b"".join(bytes([i, 0x11, 0]) for i in range(components))
    scan = bytes([components, *(b for i in range(components) for b in (i, 0)), predictor, 0, 0])
    segments = [(0xC4, table), (0xC3, frame), (0xDA, scan)]
    head = b"".join(struct.pack(">BBH", 0xFF, kind, len(body) + 2) + body for kind, body in segments)
    return b"\xff\xd8" + head + data + b"\xff\xd9"


def repacked(path, out, tile, encode, compression=7, table=None, bits=None):
    """Write a DNG of petzval again, in tiles that a function encodes."""
    old = path.read_bytes()
    assert old[:4] == b"II*\0"
    (directory,) = struct.unpack_from("<I", old, 4)
    (count,) = struct.unpack_from("<H", old, directory)
    sizes = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 7: 1, 9: 4, 10: 8, 12: 8}
    entries, strips = {}, None
    for i in range(count):
        tag, kind, number = struct.unpack_from("<HHI", old, directory + 2 + 12 * i)
        length = sizes[kind] * number
        at = directory + 10 + 12 * i if length <= 4 else struct.unpack_from("<I", old, directory + 10 + 12 * i)[0]
        entries[tag] = (kind, number, old[at : at + length])
        if tag == 273:
            (strips,) = struct.unpack_from("<I", entries[tag][2])
    codes = np.frombuffer(old, "<u2", WIDTH * HEIGHT, strips).reshape(HEIGHT, WIDTH)
    padded = np.pad(codes, ((0, -HEIGHT % tile[1]), (0, -WIDTH % tile[0])), mode="edge")
    tiles = [
        encode(padded[y : y + tile[1], x : x + tile[0]])
        for y in range(0, HEIGHT, tile[1])
        for x in range(0, WIDTH, tile[0])
    ]
    for tag in (273, 278, 279, 34665):
        entries.pop(tag, None)
    number = len(tiles)
    entries[259] = (3, 1, struct.pack("<H", compression))
    entries[322], entries[323] = ((4, 1, struct.pack("<I", side)) for side in tile)
    entries[325] = (4, number, struct.pack(f"<{number}I", *map(len, tiles)))
    if bits is not None:
        entries.pop(50717)
        entries[258] = (3, 1, struct.pack("<H", bits))
    if table is not None:
        entries[50712] = (3, len(table), struct.pack(f"<{len(table)}H", *table))
    data, places = bytearray(b"II*\0\0\0\0\0"), []
    for each in tiles:
        places.append(len(data))
        data += each + b"\0" * (len(each) % 2)
    entries[324] = (4, number, struct.pack(f"<{number}I", *places))
    records = []
    for tag, (kind, number, body) in sorted(entries.items()):
        value = body.ljust(4, b"\0")
        if len(body) > 4:
            value = struct.pack("<I", len(data))
            data += body + b"\0" * (len(body) % 2)
        records.append(struct.pack("<HHI", tag, kind, number) + value)
    struct.pack_into("<I", data, 4, len(data))
    data += struct.pack("<H", len(records)) + b"".join(records) + b"\0\0\0\0"
    out.write_bytes(data)
    return codes


@pytest.fixture
def plain(scene_path, tmp_path):
    """Return a raw file that is not compressed."""
    path = tmp_path / "plain.dng"
    sensor = "iso=400,bits=14,bayer=grbg"
    pz.render(scene_path, resolution=(WIDTH, HEIGHT), spp=4, sensor=sensor).save(path)
    return path


@pytest.mark.parametrize("components", [1, 2])
@pytest.mark.parametrize("predictor", range(1, 8))
def test_lossless_jpeg_is_developed_as_without_compression(plain, tmp_path, components, predictor):
    packed = tmp_path / "packed.dng"
    codes = repacked(plain, packed, (32, 16), lambda tile: lossless_jpeg(tile, components, predictor))
    with rawpy.imread(str(packed)) as raw:
        np.testing.assert_array_equal(raw.raw_image, codes)
    np.testing.assert_array_equal(pz.develop(packed), pz.develop(plain))


def test_tiles_of_another_encoder_and_without_compression(plain, tmp_path):
    imagecodecs = pytest.importorskip("imagecodecs")
    packed = tmp_path / "packed.dng"
    repacked(plain, packed, (48, 32), lambda tile: imagecodecs.ljpeg_encode(np.ascontiguousarray(tile), bitspersample=16))
    np.testing.assert_array_equal(pz.develop(packed), pz.develop(plain))
    repacked(plain, packed, (16, 48), lambda tile: tile.tobytes(), compression=1)
    np.testing.assert_array_equal(pz.develop(packed), pz.develop(plain))


def test_codes_behind_a_table_are_linear_again(plain, tmp_path):
    packed = tmp_path / "packed.dng"
    # Every fourth code, as a curve of twelve bits.
    table = [4 * i for i in range(4096)]
    codes = repacked(plain, packed, (96, 64), lambda tile: lossless_jpeg(tile // 4, 2, 1), table=table)
    with rawpy.imread(str(packed)) as raw:
        np.testing.assert_array_equal(raw.raw_image, codes // 4 * 4)
    assert np.abs(pz.develop(packed) - pz.develop(plain)).max() < 0.02


def test_damaged_tiles_are_errors_with_their_place(plain, tmp_path):
    packed = tmp_path / "packed.dng"
    repacked(plain, packed, (32, 16), lambda tile: lossless_jpeg(tile, 2, 1)[:-40])
    with pytest.raises(ValueError, match=r"chunk \d+: its data is cut off or damaged"):
        pz.develop(packed)
    repacked(plain, packed, (32, 16), lambda tile: lossless_jpeg(tile[:8], 2, 1))
    with pytest.raises(ValueError, match="found 256 samples; expected 512"):
        pz.develop(packed)
    repacked(plain, packed, (32, 16), lambda tile: tile.tobytes(), compression=52546)
    with pytest.raises(ValueError, match="compressed by the method 52546; expected none or lossless JPEG"):
        pz.develop(packed)


def test_white_of_fewer_bits_is_their_last_code(plain, tmp_path):
    packed = tmp_path / "packed.dng"
    # The codes of the sensor have 14 bits, and so has the file without its own white.
    repacked(plain, packed, (32, 16), lambda tile: lossless_jpeg(tile, 2, 1), bits=14)
    np.testing.assert_allclose(pz.develop(packed), pz.develop(plain), atol=1e-5)


def test_chunks_that_share_their_bytes_are_refused(plain, tmp_path):
    packed = tmp_path / "packed.dng"
    repacked(plain, packed, (32, 16), lambda tile: lossless_jpeg(tile, 2, 1))
    data = bytearray(packed.read_bytes())
    (directory,) = struct.unpack_from("<I", data, 4)
    (count,) = struct.unpack_from("<H", data, directory)
    for i in range(count):
        tag, _, number, at = struct.unpack_from("<HHII", data, directory + 2 + 12 * i)
        if tag == 325:
            struct.pack_into(f"<{number}I", data, at, *[len(data) // 2] * number)
    packed.write_bytes(data)
    with pytest.raises(ValueError, match="cut off"):
        pz.develop(packed)
