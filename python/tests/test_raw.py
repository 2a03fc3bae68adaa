"""Raw files: mosaics, levels and colours as libraw and the DNG specification read them; files of 16 bits."""

import subprocess

import numpy as np
import pytest
import rawpy
import tifffile

import petzval as pz

# Linear reflectances: greys, and colours that a print can have.
PATCHES = [
    [0.9, 0.9, 0.9], [0.36, 0.36, 0.36], [0.19, 0.19, 0.19], [0.09, 0.09, 0.09],
    [0.45, 0.18, 0.12], [0.13, 0.25, 0.45], [0.12, 0.3, 0.1], [0.25, 0.2, 0.5],
    [0.1, 0.5, 0.4], [0.7, 0.25, 0.06], [0.5, 0.1, 0.15], [0.8, 0.6, 0.1],
]  # fmt: skip
COLUMNS, PIXELS = 4, 24
# So many electrons that readings have no noise.
QUIET = "iso=100,well=1e10,read=0,bits=16"


@pytest.fixture
def chart(tmp_path):
    """Return a function that writes a chart of patches in even light, behind a camera."""

    def write(camera, white=None):
        balance = f'"float whitebalance" {white}' if white else ""
        sensor = f'"string sensor" "{camera}"' if camera else ""
        light = f'"blackbody L" {white} "float scale" 0.8' if white else '"rgb L" [0.8 0.8 0.8]'
        patches = []
        for i, colour in enumerate(PATCHES):
            x, y = i % COLUMNS, i // COLUMNS
            points = [x, y, 1, x + 1, y, 1, x + 1, y + 1, 1, x, y + 1, 1]
            text = " ".join(str(c) for c in colour)
            patches.append(
                f'Material "diffuse" "rgb reflectance" [{text}] Shape "trianglemesh" "point3 P" '
                f"[{' '.join(map(str, points))}] \"integer indices\" [0 1 2 0 2 3]"
            )
        rows = len(PATCHES) // COLUMNS
        path = tmp_path / "chart.pbrt"
        path.write_text(
            f"""
            Film "rgb" "integer xresolution" {COLUMNS * PIXELS} "integer yresolution" {rows * PIXELS}
                {sensor} {balance}
            PixelFilter "box"
            Scale 1 -1 1
            Camera "orthographic" "float screenwindow" [0 {COLUMNS} {-rows} 0]
            Sampler "independent" "integer pixelsamples" 16
            WorldBegin
            LightSource "infinite" {light}
            """
            + "\n".join(patches)
        )
        return path

    return write


def means(picture):
    """Return the mean of the middle of each patch of a picture, height x width x channels, without NaN."""
    inside = slice(4, PIXELS - 4)
    blocks = [
        picture[row * PIXELS : (row + 1) * PIXELS, column * PIXELS : (column + 1) * PIXELS][inside, inside]
        for row in range(len(PATCHES) // COLUMNS)
        for column in range(COLUMNS)
    ]
    return np.array([np.nanmean(block.reshape(-1, picture.shape[-1]), 0) for block in blocks], dtype=float)


SRGB_TO_XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)
D50 = np.array([0.9642, 1.0, 0.8249])
BRADFORD = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])


def lab(rgb):
    """Return CIE L*, a* and b* of linear sRGB."""
    share = rgb @ SRGB_TO_XYZ.T / SRGB_TO_XYZ.sum(1)
    f = np.where(share > 216 / 24389, np.cbrt(np.maximum(share, 0)), (24389 / 27 * share + 16) / 116)
    return np.stack([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], -1)


def fractions(value):
    """Return the numbers of a tag of fractions."""
    return np.array(value[::2]) / np.array(value[1::2])


def temperature(xy):
    """Return the correlated colour temperature of chromaticities (McCamy 1992)."""
    n = (xy[0] - 0.3320) / (0.1858 - xy[1])
    return 449 * n**3 + 3525 * n**2 + 6823.3 * n + 5520.33


def adaptation(light, white):
    """Return the matrix of X, Y and Z that makes a light white (Bradford)."""
    gains = (BRADFORD @ white) / (BRADFORD @ light)
    return np.linalg.inv(BRADFORD) @ np.diag(gains) @ BRADFORD


def difference(a, b):
    """Return the largest colour difference of linear sRGB (CIEDE2000; Sharma, Wu & Dalal 2005)."""
    (l1, a1, b1), (l2, a2, b2) = lab(a).T, lab(b).T
    mean = (np.hypot(a1, b1) + np.hypot(a2, b2)) / 2
    stretch = 1.5 - 0.5 * np.sqrt(mean**7 / (mean**7 + 25.0**7))
    c1, c2 = np.hypot(stretch * a1, b1), np.hypot(stretch * a2, b2)
    h1, h2 = (np.degrees(np.arctan2(y, stretch * x)) % 360 for x, y in ((a1, b1), (a2, b2)))
    turn = (h2 - h1 + 180) % 360 - 180
    hue = (h1 + turn / 2) % 360
    light, chroma = (l1 + l2) / 2, (c1 + c2) / 2
    cos = lambda factor, shift: np.cos(np.radians(factor * hue - shift))  # noqa: E731
    t = 1 - 0.17 * cos(1, 30) + 0.24 * cos(2, 0) + 0.32 * cos(3, -6) - 0.2 * cos(4, 63)
    s_l = 1 + 0.015 * (light - 50) ** 2 / np.sqrt(20 + (light - 50) ** 2)
    s_c, s_h = 1 + 0.045 * chroma, 1 + 0.015 * chroma * t
    rotation = -2 * np.sqrt(chroma**7 / (chroma**7 + 25.0**7))
    rotation *= np.sin(np.radians(60 * np.exp(-(((hue - 275) / 25) ** 2))))
    d_l, d_c = (l2 - l1) / s_l, (c2 - c1) / s_c
    d_h = 2 * np.sqrt(c1 * c2) * np.sin(np.radians(turn / 2)) / s_h
    return np.sqrt(d_l**2 + d_c**2 + d_h**2 + rotation * d_c * d_h).max()


def test_codes_and_levels_are_those_of_the_sensor(chart, tmp_path):
    for pattern, crop, bits, black in [
        ("rggb", None, 14, 512),
        ("gbrg", (3, 5, 40, 30), 12, 64),
        ("bggr", (4, 1, 31, 24), 16, 0),
        ("grbg", None, 8, 9),
    ]:
        # Electrons of the full well at ISO 50, which is half of white.
        sensor = f"iso=50,pixel=2,bits={bits},black={black},read=2,bayer={pattern}"
        settings = {"crop": crop} if crop else {}
        image = pz.render(chart(None), sensor=sensor, **settings)
        path = tmp_path / "a.dng"
        image.save(path)
        last = 2**bits - 1
        codes = np.rint(image.pixels.astype(float) * (last - black) + black)
        x, y = (crop or (0, 0))[:2]
        filters = np.array(["rgb".index(c) for c in pattern]).reshape(2, 2)
        filters = np.roll(filters, (-y, -x), (0, 1))
        with rawpy.imread(str(path)) as raw:
            assert (raw.raw_image == codes).all(), pattern
            assert len(np.unique(codes)) > 20
            # libraw calls the second green 3.
            found = np.where(raw.raw_pattern == 3, 1, raw.raw_pattern)
            assert (found == filters).all(), f"{pattern} {found}"
            assert raw.black_level_per_channel == [black] * 4
            assert raw.white_level == black + (last - black + 1) // 2
            assert raw.camera_whitebalance[:3] == [1, 1, 1]


def test_the_command_and_its_parts_write_the_same_codes(chart, tmp_path, command):
    scene, crop = chart("nikon_d850"), "5,2,90,61"
    render = [command, "render", str(scene), "--sensor", "well=20000,read=4", "--bayer", "--crop", crop, "-q", "-o"]
    parts = [str(tmp_path / f"{n}.petzval") for n in (1, 2)]
    for n, part in enumerate(parts, 1):
        subprocess.run([*render, part, "--shard", f"{n}/2"], check=True)
    files = [str(tmp_path / name) for name in ("whole.dng", "merged.dng", "python.dng")]
    subprocess.run([*render, files[0]], check=True)
    subprocess.run([command, "merge", *parts, "-q", "-o", files[1]], check=True)
    image = pz.render(scene, sensor="well=20000,read=4,bayer", crop=[int(c) for c in crop.split(",")])
    image.save(files[2])
    codes = []
    for file in files:
        with rawpy.imread(file) as raw:
            codes.append(raw.raw_image.copy())
            assert raw.raw_pattern.tolist() == [[1, 0], [2, 3]]
    assert codes[0].shape == (59, 85)
    assert (codes[0] == codes[1]).all() and (codes[0] == codes[2]).all()
    with tifffile.TiffFile(files[0]) as file:
        tags = {tag.code: tag.value for tag in file.pages[0].tags}
    assert tags[271] == "petzval" and tags[50708] == "petzval nikon_d850"
    assert "commandLine: petzval render" in tags[270]
    exif = tags[34665]
    assert exif["ISOSpeed"] == exif["ISOSpeedRatings"] == 100 and exif["ExifVersion"] == "0232"
    # The noise of the readings is that of the profile: variance = signal * S + O.
    signal, dark = tags[51041]
    assert abs(1 / signal - 20_000) < 1 and abs(dark / signal**2 - 16) < 0.5


def test_colours_of_libraw_are_those_of_the_picture(chart, tmp_path):
    slow = QUIET.replace("iso=100", "iso=80")
    for camera, sensor in [(None, QUIET), ("canon_eos_100d", QUIET), ("nikon_d850", slow), ("sony_ilce_9", QUIET)]:
        scene = chart(camera)
        reference = means(pz.render(scene, sensor=QUIET).pixels)
        path = tmp_path / "a.dng"
        pz.render(scene, sensor=sensor + ",bayer").save(path)
        with tifffile.TiffFile(path) as file:
            # libraw stretches up to the full well, and leaves BaselineExposure to others.
            stretch = 2 ** fractions(file.pages[0].tags[50730].value)[0]
        assert abs(stretch - (0.8 if sensor == slow else 1)) < 1e-4
        with rawpy.imread(str(path)) as raw:
            shown = raw.postprocess(
                demosaic_algorithm=rawpy.DemosaicAlgorithm.LINEAR,
                use_camera_wb=True,
                no_auto_bright=True,
                adjust_maximum_thr=0,
                gamma=(1, 1),
                output_bps=16,
                output_color=rawpy.ColorSpace.sRGB,
            )
            if camera:
                assert max(raw.camera_whitebalance[:3]) > 1.2
        found = difference(stretch * means(shown) / 65535, reference)
        print(f"{camera}: libraw differs by {found:.2f}")
        assert found < 0.1, camera
        assert difference(reference[:, ::-1], reference) > 20


def test_bit_depths_that_a_format_does_not_have_are_refused(chart, tmp_path):
    image = pz.render(chart(None))
    for name, bits in [("a.jpg", 16), ("a.tif", 8), ("a.exr", 16), ("a.png", 12)]:
        with pytest.raises(ValueError, match="bit_depth"):
            image.save(tmp_path / name, bit_depth=bits)
    image.save(tmp_path / "a.png", bit_depth=16)
    image.save(tmp_path / "a.tif")
    deep, tiff = (tmp_path / name for name in ("a.png", "a.tif"))
    assert (pz.read_image(deep) == pz.read_image(tiff)).all()
    assert abs(pz.read_image(deep) - image.pixels).max() < 3e-5
    with pytest.raises(ValueError, match="bayer"):
        image.save(tmp_path / "a.dng")


def test_colours_of_the_specification_are_those_of_the_picture(chart, tmp_path):
    # "Mapping Camera Color Space to CIE XYZ Space" of the specification, with both matrices.
    for camera in ["canon_eos_100d", "nikon_d850"]:
        for white in [None, 5000, 3200]:
            scene = chart(camera, white)
            reference = means(pz.render(scene, sensor=QUIET).pixels)
            path = tmp_path / "a.dng"
            pz.render(scene, sensor=QUIET + ",bayer").save(path)
            with tifffile.TiffFile(path) as file:
                tags = {tag.code: tag.value for tag in file.pages[0].tags}
                codes = file.pages[0].asarray().astype(float)
            assert [tags[50778], tags[50779]] == [17, 21]
            tungsten, daylight = (fractions(tags[tag]).reshape(3, 3) for tag in (50721, 50722))
            neutral = fractions(tags[50728])
            xy = np.array([0.3457, 0.3585])
            for _ in range(50):
                share = np.clip((1 / temperature(xy) - 1 / 6504) / (1 / 2856 - 1 / 6504), 0, 1)
                matrix = share * tungsten + (1 - share) * daylight
                xyz = np.linalg.solve(matrix, neutral)
                xy = xyz[:2] / xyz.sum()
            forward = share * fractions(tags[50964]).reshape(3, 3) + (1 - share) * fractions(tags[50965]).reshape(3, 3)
            assert abs(forward.sum(1) - D50).max() < 1e-3, "white is D50"
            balance = adaptation(D50, SRGB_TO_XYZ.sum(1))
            to_srgb = np.linalg.inv(SRGB_TO_XYZ) @ balance @ forward @ np.diag(1 / neutral)
            channels = np.full((*codes.shape, 3), np.nan)
            for place, channel in enumerate([0, 1, 1, 2]):
                at = (slice(place // 2, None, 2), slice(place % 2, None, 2))
                channels[*at, channel] = (codes[at] - tags[50714]) / (tags[50717] - tags[50714])
            shown = means(channels) @ to_srgb.T
            found = difference(shown, reference)
            print(f"{camera} {white}: {found:.2f}, {temperature(xy):.0f} K")
            assert found < 1.5, f"{camera} {white}"


def test_developed_colours_are_those_of_the_picture(chart, tmp_path):
    slow = QUIET.replace("iso=100", "iso=80")
    for camera, sensor, light, bound in [
        (None, QUIET, None, 0.05),
        # Forward matrices are fitted for D50, and the picture's for the white of the screen.
        ("canon_eos_100d", slow, None, 1.5),
        ("nikon_d850", QUIET, None, 1.5),
        ("nikon_d850", QUIET, 5000, 1.5),
        ("nikon_d850", QUIET, 3200, 1.5),
    ]:
        scene, path = chart(camera, light), tmp_path / "a.dng"
        reference = means(pz.render(scene, sensor=QUIET).pixels)
        pz.render(scene, sensor=sensor + ",bayer").save(path)
        found = difference(means(pz.develop(path)), reference)
        print(f"{camera} {light}: developed colours differ by {found:.2f}")
        assert found < bound, camera
        if light:
            # The white balance of the file is that of its light.
            balanced = difference(means(pz.develop(path, f"{light}K")), reference)
            assert balanced < bound + 0.3, f"{camera} {light}: {balanced}"
            wrong = difference(means(pz.develop(path, "D65")), reference)
            assert wrong > 5, f"{camera} {light}: {wrong}"


def test_the_command_develops_as_python_does(chart, tmp_path, command):
    path, picture = tmp_path / "a.dng", tmp_path / "a.exr"
    pz.render(chart("nikon_d850"), sensor=QUIET + ",bayer").save(path)
    subprocess.run([command, "develop", path, "-o", picture, "--white-balance", "0.31,0.33", "-q"], check=True)
    assert (pz.read_image(picture) == pz.develop(path, "0.31,0.33")).all()
    assert abs(pz.develop(path, "auto")[..., 1] - pz.develop(path)[..., 1]).max() > 1e-4
    with pytest.raises(ValueError, match=r"white_balance: expected a temperature.*or as-shot, found \"warm\""):
        pz.develop(path, "warm")
    with pytest.raises(ValueError, match=r"a\.exr"):
        pz.develop(picture)


def test_a_turned_file_of_others_is_developed_as_libraw_does(chart, tmp_path):
    # Big-endian, turned, with black levels of each filter, without forward matrices: written by another program.
    codes = np.arange(24 * 36, dtype=">u2").reshape(24, 36) * 40 % 3000 + 256
    codes[2:22, 4:32] = 1600
    matrix = [0.9, -0.2, 0.0, -0.3, 1.2, 0.1, 0.0, 0.2, 0.7]
    neutral = np.reshape(matrix, (3, 3)) @ SRGB_TO_XYZ.sum(1)
    rational = lambda numbers: tuple(n for x in numbers for n in (round(x * 10000), 10000))  # noqa: E731
    path = tmp_path / "b.dng"
    tags = [
        (33421, "H", 2, (2, 2), True), (33422, "B", 4, bytes([1, 0, 2, 1]), True),
        (50706, "B", 4, bytes([1, 4, 0, 0]), True), (50708, "s", 0, "other", True),
        (50713, "H", 2, (2, 2), True), (50714, "H", 4, (256, 256, 256, 256), True), (50717, "H", 1, 4095, True),
        (50721, "2i", 9, rational(matrix), True), (50728, "2I", 3, rational(neutral / neutral.max()), True),
        (50778, "H", 1, 21, True), (274, "H", 1, 6, True),
    ]  # fmt: skip
    with tifffile.TiffWriter(path, byteorder=">") as file:
        file.write(codes, photometric=32803, extratags=tags, metadata=None)
    with rawpy.imread(str(path)) as raw:
        shown = raw.postprocess(
            use_camera_wb=True, no_auto_bright=True, adjust_maximum_thr=0, gamma=(1, 1), output_bps=16
        )
    found = pz.develop(path)
    assert found.shape == shown.shape == (36, 24, 3)
    inside = np.s_[12:24, 9:15]
    even, expected = found[inside].reshape(-1, 3), shown[inside].reshape(-1, 3) / 65535
    assert np.ptp(even, axis=0).max() < 1e-5
    assert abs(even[0] - expected[0]).max() < 0.002 * expected.max(), f"{even[0]} {expected[0]}"


def test_corrections_that_are_left_out_are_a_warning(tmp_path):
    # One opcode, WarpRectilinear, optional, without parameters.
    opcodes = np.array([1, 1, 0x01030000, 1, 0], ">u4").tobytes()
    unity = (1, 1, 0, 1, 0, 1, 0, 1, 1, 1, 0, 1, 0, 1, 0, 1, 1, 1)
    tags = [
        (33421, "H", 2, (2, 2), True), (33422, "B", 4, bytes([0, 1, 1, 2]), True),
        (50706, "B", 4, bytes([1, 4, 0, 0]), True), (50721, "2i", 9, unity, True),
        (50728, "2I", 3, (9505, 10888, 10000, 10888, 1, 1), True), (51022, "B", len(opcodes), opcodes, True),
    ]  # fmt: skip
    path = tmp_path / "a.dng"
    with tifffile.TiffWriter(path) as file:
        file.write(np.full((24, 36), 30000, np.uint16), photometric=32803, extratags=tags, metadata=None)
    with pytest.warns(RuntimeWarning, match=r"a\.dng asks for corrections that are left out: WarpRectilinear"):
        found = pz.develop(path)
    assert found.shape == (24, 36, 3) and np.isfinite(found).all()
