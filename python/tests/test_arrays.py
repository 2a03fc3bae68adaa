"""Scenes of arrays: the picture of the same scene in the scene language, and what is refused."""

import gc

import numpy as np
import pytest

import petzval as pz

WALL = dict(
    vertices=[[-3, -3, 4], [3, -3, 4], [3, 3, 4], [-3, 3, 4]],
    faces=[[0, 2, 1], [0, 3, 2]],
    uv=[[0, 0], [1, 0], [1, 1], [0, 1]],
)
SKY = {"type": "infinite", "L": (0.4, 0.45, 0.5)}
VIEW = dict(look_at=((0, 0, 0), (0, 0, 1)), resolution=(48, 32), spp=4, focus=2.0)


def scene(lens, meshes, lights=(SKY,), **changes):
    return pz.Scene.from_arrays(meshes, lens=lens, lights=lights, **{**VIEW, **changes})


def test_arrays_give_the_picture_of_the_same_scene_file(scene_path, lens_path):
    # The scene file has a ball, too: take it out.
    text = "\n".join(line for line in scene_path.read_text().splitlines() if "sphere" not in line)
    scene_path.write_text(text)
    material = {"type": "diffuse", "reflectance": (0.6, 0.3, 0.2)}
    # The default film of the scene language has a diagonal of 35 mm.
    arrays = scene(lens_path, [pz.Mesh(**WALL, material=material)], diagonal=35)
    found = pz.render(arrays, effects="none").pixels
    expected = pz.render(scene_path, effects="none").pixels
    assert expected.mean() > 0
    np.testing.assert_array_equal(found, expected)


def test_textures_of_arrays_are_upright(lens_path):
    texture = np.zeros((64, 64, 3), dtype=np.float32)
    # Red above left, green above right, blue below left.
    texture[:32, :32, 0] = texture[:32, 32:, 1] = texture[32:, :32, 2] = 0.9
    mesh = pz.Mesh(**WALL, material={"type": "diffuse", "reflectance": texture})
    pixels = pz.render(scene(lens_path, [mesh], spp=64, focus=4.0), effects="none").pixels
    corner = {"ul": pixels[2, 2], "ur": pixels[2, -3], "ll": pixels[-3, 2], "lr": pixels[-3, -3]}
    assert np.argmax(corner["ul"]) == 0 and np.argmax(corner["ur"]) == 1
    assert np.argmax(corner["ll"]) == 2
    assert corner["lr"].max() < 0.2 * corner["ul"].max()


def test_meshes_shine_and_normals_shade(lens_path):
    small = np.array(WALL["vertices"]) * [0.1, 0.1, 0.5]
    light = pz.Mesh(small, WALL["faces"], emission=(5, 5, 5))
    pixels = pz.render(scene(lens_path, [light], lights=[]), effects="none").pixels
    assert pixels[16, 24].min() > 0 and pixels[1, 1].max() == 0
    flat = pz.Mesh(**WALL)
    bent = pz.Mesh(**WALL, normals=[[0.6, 0, -0.8]] * 4)
    sun = {"type": "distant", "L": (1, 1, 1), "from": (0, 0, 0), "to": (0, 0, 1)}
    [a, b] = [pz.render(scene(lens_path, [m], lights=[sun]), effects="none").pixels for m in (flat, bent)]
    assert b.mean() / a.mean() == pytest.approx(0.8, rel=0.02)


def test_the_lens_of_a_table_lasts_as_long_as_the_scene():
    def made():
        rows = [(60.0, 6.0, 1.6, 30.0), (-60.0, 2.0, 1.0, 30.0), (0.0, 1.0, 0.0, 12.0)]
        return scene(pz.Lens.from_table(rows), [pz.Mesh(**WALL)])

    kept = made()
    gc.collect()
    assert pz.render(kept, effects="none").pixels.mean() > 0


def test_no_file_is_written_and_the_lens_is_that_of_the_call(lens_path, tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path / "none"))
    monkeypatch.setattr("tempfile.tempdir", None)
    lens = tmp_path / "lens.dat"
    lens.write_bytes(lens_path.read_bytes())
    texture = np.full((2, 2, 3), 0.5)
    kept = scene(lens, [pz.Mesh(**WALL, material={"type": "diffuse", "reflectance": texture})])
    lens.unlink()
    texture[:] = 0
    assert kept.path is None and repr(kept) == "<Scene of arrays>"
    expected = pz.render(scene(lens_path, [pz.Mesh(**WALL)]), effects="none").pixels
    np.testing.assert_allclose(pz.render(kept, effects="none").pixels, expected, rtol=1e-5)
    assert list(tmp_path.iterdir()) == []


def test_arrays_of_any_layout_give_the_same_picture(lens_path):
    vertices, faces = np.array(WALL["vertices"], np.float32), np.array(WALL["faces"])
    fixed = vertices.copy()
    fixed.flags.writeable = False
    wide = np.zeros((8, 6), np.float32)
    wide[::2, ::2] = vertices
    layouts = [
        (vertices, faces),
        (fixed, faces.astype(np.uint8)),
        (np.asfortranarray(vertices), np.asfortranarray(faces)),
        (wide[::2, ::2], faces[::-1]),
        (vertices.astype(">f8"), faces.astype(">i4")),
        (vertices.astype(np.int16), WALL["faces"]),
    ]
    pictures = [
        pz.render(scene(lens_path, [pz.Mesh(*arrays, uv=WALL["uv"])]), effects="none").pixels
        for arrays in layouts
    ]
    for picture in pictures[1:]:
        np.testing.assert_array_equal(picture, pictures[0])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"vertices": [[0, 0], [1, 1]]}, "N x 3"),
        ({"faces": [[0, 1, 9]]}, "beyond the 4"),
        ({"faces": [[0.0, 1.0, 2.0]]}, "expected integers"),
        ({"uv": [[0, 0]]}, "1 uv for 4 vertices"),
        ({"faces": [[0, 1, -1]]}, "beyond the 4"),
        ({"faces": np.array([[0, 1, 2**63]], np.uint64)}, "beyond the 4"),
        ({"faces": np.zeros((0, 3), int)}, "mesh 0: the mesh has no vertices or no faces"),
        ({"normals": np.zeros((0, 3))}, "0 normals for 4 vertices"),
        ({"vertices": [[np.nan, 0, 0]] * 4}, "not all finite"),
        ({"vertices": np.full((4, 3), np.inf)}, "mesh 0: vertices are not all finite"),
        ({"material": {"type": "diffuse", "reflectance": np.nan}}, "mesh 0: reflectance=nan: expected a finite"),
        ({"material": {"type": "diffuse", "reflectance": np.full((1, 1, 3), np.nan)}}, "the pixel 0, 0 of"),
        ({"material": {"reflectance": (1, 1, 1)}}, 'no "type"'),
        ({"material": {"type": "marble"}}, "marble"),
        ({"material": {"type": "diffuse", "reflectance": (1, 1)}}, "reflectance"),
        ({"material": {"type": 'diffuse" "x'}}, "the material of mesh 0: unknown Material"),
        # Views of one row, which take no memory.
        ({"faces": np.broadcast_to([0, 1, 2], (10**10, 3))}, "10000000000 faces"),
        ({"vertices": np.broadcast_to([0.0, 1.0, 2.0], (10**10, 3))}, "10000000000 vertices"),
        ({"emission": (1, 2)}, "emission"),
        ({"emission": 3}, "emission=3"),
        ({"material": {"type": "diffuse", "reflectance": np.ones((4, 4, 4))}}, "reflectance"),
        # Bytes are not linear light.
        ({"material": {"type": "diffuse", "reflectance": np.ones((4, 4, 3), np.uint8)}}, "uint8"),
    ],
)
def test_meshes_that_make_no_sense_are_refused(lens_path, changes, message):
    with pytest.raises(ValueError, match=message):
        scene(lens_path, [pz.Mesh(**{**WALL, **changes})])


@pytest.mark.parametrize(
    ("meshes", "settings", "message"),
    [
        ([3], {}, "petzval.Mesh"),
        (pz.Mesh(**WALL), {}, "meshes"),
        ([pz.Mesh(**{**WALL, "vertices": None})], {}, "mesh 0: vertices: .* expected real numbers"),
        ([pz.Mesh(**{**WALL, "uv": np.zeros((4, 2), complex)})], {}, "mesh 0: uv: .* expected real numbers"),
        ([pz.Mesh(**{**WALL, "emission": (1, "a", 1)})], {}, "mesh 0: emission"),
        ([pz.Mesh(**{**WALL, "material": "diffuse"})], {}, "material"),
        ([pz.Mesh(**{**WALL, "material": None})], {}, "material"),
        ([], {"lights": {"type": "infinite"}}, "lights"),
        ([], {"lights": ["infinite"]}, "light 0"),
        ([], {"focus": "auto"}, "focus='auto'"),
        ([], {"diagonal": None}, "diagonal=None"),
        ([], {"spp": None}, "spp=None"),
        ([], {"lens": 3}, "lens=3: expected a petzval.Lens or the path"),
    ],
)
def test_arguments_of_another_type_are_refused(lens_path, meshes, settings, message):
    with pytest.raises(TypeError, match=message):
        scene(**{"lens": lens_path, "meshes": meshes, **settings})


def test_all_errors_of_a_scene_name_the_argument(lens_path):
    meshes = [pz.Mesh(**WALL, material={"type": kind}) for kind in ("diffuse", "marble")]
    with pytest.raises(ValueError) as raised:
        scene(lens_path, meshes, lights=[{"type": "moon"}], focus=0, max_depth=0)
    [light, material, focus] = str(raised.value).splitlines()
    assert light.startswith("light 0: unknown LightSource")
    assert material.startswith("the material of mesh 1: unknown Material")
    assert focus.startswith("focus: ")


def test_files_that_are_missing_are_not_found(lens_path, tmp_path):
    with pytest.raises(FileNotFoundError, match="gone.dat"):
        scene(tmp_path / "gone.dat", [])
    bumps = {"type": "diffuse", "normalmap": str(tmp_path / "gone.png")}
    with pytest.raises(FileNotFoundError, match="the material of mesh 0: .*gone.png"):
        scene(lens_path, [pz.Mesh(**WALL, material=bumps)])
