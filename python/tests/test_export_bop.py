"""Export of data sets to BOP, judged by the equations of its toolkit, Pillow, and positions and depths of the layers."""

import json

import numpy as np
import pytest

import petzval as pz
from export_sets import BALL, CARD, WALL, render_set, rows_of
from petzval.export.layers import read_layers

FRAMES = {
    "pbrt": ("", "", 1.0, [1, -1, 1]),
    "a unit of 2 m": ("Scale 2 2 2", "", 2.0, [1, -1, 1]),
    "a mirror": ("Scale -1 1 1", "", 1.0, [1, 1, 1]),
    "a crop": ("", '"integer pixelbounds" [3 21 2 13]', 1.0, [1, -1, 1]),
}


def project(camera, points):
    """Return pixels and depths of points of BOP's world (mm): the equations of its toolkit and OpenCV's distortion."""
    matrix, rotation = (np.reshape(camera[name], (3, 3)) for name in ("cam_K", "cam_R_w2c"))
    seen = points @ rotation.T + camera["cam_t_w2c"]
    x, y = seen[:, 0] / seen[:, 2], seen[:, 1] / seen[:, 2]
    k = camera.get("cam_distortion", {})
    r2 = x * x + y * y
    radial = 1 + r2 * (k.get("k1", 0) + r2 * (k.get("k2", 0) + r2 * k.get("k3", 0)))
    pixels = np.stack([matrix[0, 0] * x * radial + matrix[0, 2], matrix[1, 1] * y * radial + matrix[1, 2]], -1)
    assert matrix[2].tolist() == [0, 0, 1] and matrix[0, 1] == matrix[1, 0] == 0
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-6)
    assert np.linalg.det(rotation) > 0
    return pixels, seen[:, 2]


@pytest.mark.parametrize("frame", FRAMES)
def test_bop_cameras_project_positions_to_their_pixels(frame, tmp_path, lens_path):
    world, film, unit, axes = FRAMES[frame]
    draw = "move = 0.05\nturn = [6.0, 4.0, 40.0]"
    folder = render_set(tmp_path, lens_path, world=world, film=film, draw=draw)
    for picture in ("clean", "degraded"):
        out = tmp_path / picture / "train_pbr"
        pz.export.bop(folder, out, picture=picture)
        cameras = json.loads((out / "000000" / "scene_camera.json").read_text())
        assert list(cameras) == ["0", "1"]
        for row in rows_of(folder):
            layers = read_layers(folder / row["files"][picture]["file"])
            width, height = layers.size
            assert (layers.size, layers.origin) == (((18, 11), (3, 2)) if film else ((24, 16), (0, 0)))
            covered = layers.channel("depth", "coverage") > 0
            assert 100 < covered.sum() < covered.size
            points = layers.arrays["position"].astype(float)[covered] * axes * 1000 * unit
            camera = cameras[str(row["pair"])]
            pixels, depths = project(camera, points)
            rows, columns = np.nonzero(covered)
            # Samples lie within half a pixel, and in a lens a little blur adds to it.
            assert np.abs(pixels - np.stack([columns, rows], -1)).max() < (0.51 if picture == "clean" else 1.0)
            stored = png(out / "000000" / "depth" / f"{row['pair']:06d}.png")
            assert stored.dtype == np.uint16 and (stored[~covered] == 0).all()
            np.testing.assert_allclose(stored[covered] * camera["depth_scale"], depths, atol=0.06)
            rgb = pz.read_image(out / "000000" / "rgb" / f"{row['pair']:06d}.png")
            colours = np.clip(pz.read_image(folder / row["files"][picture]["file"]), 0, 1)
            np.testing.assert_allclose(rgb, colours, atol=0.006)


def png(path):
    """Return the numbers of a grey PNG as a foreign reader finds them."""
    pillow = pytest.importorskip("PIL.Image")
    with pillow.open(path) as image:
        assert image.mode in ("L", "I;16", "I")
        values = np.array(image)
    return values.astype(np.uint8 if image.mode == "L" else np.uint16)


def with_objects(folder, poses):
    """Replace the objects in the rows of a data set."""
    rows = rows_of(folder)
    for row in rows:
        row["objects"] = poses
    (folder / "manifest.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))


def posed(angle, *translation):
    """Return a pose of three rows: a rotation about z (degrees), then a translation."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    rotation = [[c, -s, 0], [s, c, 0], [0, 0, 1]]
    return [[*row, t] for row, t in zip(rotation, translation)]


OBJECTS = [
    {"name": "two balls", "shapes": [0, 1], "instance": 0, "world_from_object": posed(0, 0.2, 0.2, 1)},
    {"name": "two balls", "shapes": [0, 1], "instance": 1, "world_from_object": posed(40, 0.0, -0.1, 1)},
    {"name": "ball", "shapes": [BALL], "instance": -1, "world_from_object": posed(0, -0.1, 0.1, 1)},
    {"name": "card", "shapes": [CARD], "instance": -1, "world_from_object": posed(0, 0.25, -0.05, 1.1)},
    {"name": "wall", "shapes": [WALL], "instance": -1, "world_from_object": posed(0, 0, 0, 0)},
]
#: Points of an object and the radius that its surface has about the nearest.
CENTRES = {"two balls": ([[0, 0, 0], [0.09, 0.05, 0]], [50, 40]), "ball": ([[0, 0, 0]], [100])}


@pytest.mark.parametrize("frame", ["pbrt", "a unit of 2 m", "a mirror"])
def test_bop_poses_place_objects_where_the_depth_shows_them(frame, tmp_path, lens_path):
    world, film, unit, _ = FRAMES[frame]
    folder = render_set(tmp_path, lens_path, world=world, draw="turn = [3.0, 2.0, 20.0]", size=(120, 80))
    with_objects(folder, OBJECTS)
    out = tmp_path / "train_pbr"
    numbers = pz.export.bop(folder, out)
    assert numbers == {"ball": 1, "card": 2, "two balls": 3, "wall": 4}
    scene = out / "000000"
    known = json.loads((out / "objects.json").read_text())
    cameras, truth, information = (
        json.loads((scene / f"{name}.json").read_text()) for name in ("scene_camera", "scene_gt", "scene_gt_info")
    )
    for row in rows_of(folder):
        picture = str(row["pair"])
        name = f"{row['pair']:06d}"
        layers = read_layers(folder / row["files"]["clean"]["file"])
        shape, instance = (layers.channel("object", channel) for channel in ("shape", "instance"))
        depth = png(scene / "depth" / f"{name}.png") * cameras[picture]["depth_scale"]
        matrix = np.reshape(cameras[picture]["cam_K"], (3, 3))
        assert len(truth[picture]) == len(information[picture]) == 5
        for number, (pose, known_pixels) in enumerate(zip(truth[picture], information[picture])):
            category = known[str(pose["obj_id"])]["name"]
            rotation = np.reshape(pose["cam_R_m2c"], (3, 3))
            np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-6)
            assert np.linalg.det(rotation) > 0
            mask = png(scene / "mask_visib" / f"{name}_{number:06d}.png")
            assert set(np.unique(mask)) == {0, 255} and known_pixels["px_count_visib"] == (mask > 0).sum()
            rows, columns = np.nonzero(mask)
            box = [columns.min(), rows.min(), np.ptp(columns) + 1, np.ptp(rows) + 1]
            assert known_pixels["bbox_visib"] == box and known_pixels["obj_id"] == pose["obj_id"]
            shown = set(zip(shape[mask > 0], instance[mask > 0]))
            entries = [e for e in OBJECTS if shown <= {(s, e["instance"]) for s in e["shapes"]}]
            assert [e["name"] for e in entries] == [category]
            if category not in CENTRES:
                continue
            # The surfaces that pixels show lie on the spheres of the model.
            covered = (mask > 0) & np.isclose(layers.channel("depth", "coverage"), 1) & inside(mask > 0)
            rows, columns = np.nonzero(covered)
            rays = np.stack([columns, rows, np.ones_like(rows)]).T @ np.linalg.inv(matrix).T
            points = (rays * depth[covered][:, None] - pose["cam_t_m2c"]) @ rotation
            centres, radii = CENTRES[category]
            model = np.array(centres) @ np.array(known[str(pose["obj_id"])]["model_from_object"]).T
            distances = np.linalg.norm(points[:, None] - model, axis=-1) / (np.array(radii) * unit)
            assert len(points) > 20 and np.abs(distances - 1).min(axis=1).max() < 0.05, category


def inside(mask):
    """Return the pixels whose eight neighbours are of the mask too."""
    padded = np.pad(mask, 1)
    return np.all([np.roll(padded, (y, x), (0, 1)) for y in (-1, 0, 1) for x in (-1, 0, 1)], axis=0)[1:-1, 1:-1]


def test_poses_of_some_objects_are_refused(tmp_path, lens_path):
    folder = render_set(tmp_path, lens_path, pairs=1)
    with_objects(folder, OBJECTS[:-1])
    with pytest.raises(ValueError, match=r"pair 0: objects: 'shape 4' \(shapes \[4\], instance -1\) has no entry"):
        pz.export.bop(folder, tmp_path / "bop")
    assert not (tmp_path / "bop").exists() and not list(tmp_path.glob(".*"))
    names = {0: "a", 1: "b", BALL: "c"}
    assert pz.export.bop(folder, tmp_path / "bop", categories=names) == {"a": 1, "b": 2, "c": 3}
    larger = [{**entry, "world_from_object": (np.array(entry["world_from_object"]) * 2).tolist()} for entry in OBJECTS]
    for objects, message in [
        ([OBJECTS[0], larger[1], *OBJECTS[2:]], "'two balls' has several sizes"),
        ([{**OBJECTS[4], "world_from_object": [[1, 0, 0, 0], [0, 2, 0, 0], [0, 0, 1, 0]]}, *OBJECTS[:4]], "one scale"),
    ]:
        with_objects(folder, objects)
        with pytest.warns(UserWarning, match=f"scene_gt.json is left out: .*{message}"):
            pz.export.bop(folder, tmp_path / message)
        assert not list((tmp_path / message).rglob("scene_gt.json"))
        assert "model_from_object" not in (tmp_path / message / "objects.json").read_text()
    with_objects(folder, [{"name": "x"}, *OBJECTS])
    with pytest.raises(ValueError, match=r"objects: found \{'name': 'x'\}; expected name"):
        pz.export.bop(folder, tmp_path / "other")


def test_manifests_list_the_objects_that_pictures_show(tmp_path, lens_path):
    folder = render_set(tmp_path, lens_path, pairs=1)
    [row] = rows_of(folder)
    found = {(tuple(entry["shapes"]), entry["instance"]): entry for entry in row["objects"]}
    assert len(found) == len(row["objects"]) == len(OBJECTS)
    for entry in OBJECTS:
        own = found[tuple(entry["shapes"]), entry["instance"]]
        # Single shapes have no names in a scene of pbrt, and stand in the world.
        assert own["name"] == (entry["name"] if entry["instance"] >= 0 else None)
        expected = entry["world_from_object"] if entry["instance"] >= 0 else posed(0, 0, 0, 0)
        np.testing.assert_allclose(own["world_from_object"], expected, atol=1e-6)
    numbers = pz.export.bop(folder, tmp_path / "bop")
    assert numbers == {"shape 2": 1, "shape 3": 2, "shape 4": 3, "two balls": 4}
    assert (tmp_path / "bop" / "000000" / "scene_gt.json").exists()


def test_bop_names_what_is_missing(tmp_path, lens_path):
    folder = render_set(tmp_path, lens_path, layers=["object"], pairs=1)
    with pytest.raises(ValueError, match="pair 0: the clean picture has no layer 'depth'; add it to 'layers'"):
        pz.export.bop(folder, tmp_path / "bop")
    [row] = rows_of(folder)
    row["degraded"]["camera"] = None
    (folder / "manifest.jsonl").write_text(json.dumps(row) + "\n")
    with pytest.raises(ValueError, match="pair 0: the degraded picture has no camera matrix"):
        pz.export.bop(folder, tmp_path / "bop", picture="degraded")
    assert not (tmp_path / "bop").exists()
