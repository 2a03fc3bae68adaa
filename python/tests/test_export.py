"""Exports of data sets to COCO, HDF5 and NumPy, judged by pycocotools, h5py and NumPy; and what is refused."""

import json
import re
import sys

import numpy as np
import pytest

import petzval as pz
from conftest import ROOT
from export_sets import BALL, CARD, HEIGHT, LAYERS, WALL, WIDTH, render_set, rows_of
from petzval.export.layers import read_layers


@pytest.fixture(scope="module")
def still(tmp_path_factory):
    """A data set whose camera stands still, so that :func:`petzval.render` takes the same pictures."""
    return render_set(tmp_path_factory.mktemp("still"), ROOT / "lenses" / "dgauss.50mm.dat", psf=True)


def taken(folder, row):
    """Return the degraded picture of a pair by another way than its file."""
    settings = dict(seed=row["seed"], spp=16, effects="none", aov=LAYERS)
    return pz.render(folder.parent / "scene.pbrt", resolution=(WIDTH, HEIGHT), **settings)


def objects_of(image):
    """Return the numbers of shape and instance of the pixels of a picture."""
    assert image.channels["object"] == ["shape", "instance"]
    return image.layers["object"].astype(int)


# Layers


def test_layers_are_those_of_the_render(still, tmp_path):
    for row in rows_of(still):
        image, found = taken(still, row), read_layers(still / row["files"]["degraded"]["file"])
        assert found.size == (WIDTH, HEIGHT) and found.origin == (0, 0)
        assert found.channels == image.channels and list(found.channels["albedo"]) == ["R", "G", "B"]
        for name, values in image.layers.items():
            np.testing.assert_array_equal(found.arrays[name], values, err_msg=name)


def test_more_rows_than_a_block_and_a_crop_are_read(tmp_path, still):
    scene = still.parent / "scene.pbrt"
    image = pz.render(scene, spp=1, resolution=(37, 45), crop=(3, 5, 36, 44), aov=["depth", "samples", "normal"])
    for half in (False, True):
        image.save(tmp_path / "a.exr", half=half)
        found = read_layers(tmp_path / "a.exr")
        assert found.origin == (3, 5) and found.size == (33, 39) and found.channels == image.channels
        for name, values in image.layers.items():
            np.testing.assert_array_equal(found.arrays[name], values, err_msg=name)


def test_damaged_pictures_are_errors_with_their_name(tmp_path, still):
    whole = (still / "000000.clean.exr").read_bytes()
    path = tmp_path / "a.exr"
    for size in [*range(0, 900, 7), len(whole) // 2, len(whole) - 1]:
        path.write_bytes(whole[:size])
        with pytest.raises((ValueError, OSError), match=r"a\.exr"):
            read_layers(path)


# COCO


def test_coco_masks_and_boxes_are_those_of_the_object_layer(still, tmp_path, capsys):
    reader = pytest.importorskip("pycocotools.coco")
    path = tmp_path / "coco" / "annotations.json"
    shares = []
    written = pz.export.coco(still, path, progress=shares.append)
    assert shares == [0.5, 1.0] and written == json.loads(path.read_text())
    coco = reader.COCO(str(path))
    assert [coco.cats[i]["name"] for i in sorted(coco.cats)] == ["shape 2", "shape 3", "shape 4", "two balls"]
    for row in rows_of(still):
        image = taken(still, row)
        objects = objects_of(image)
        # Both balls of an instance are one object.
        objects[..., 0] = np.where(objects[..., 0] == 1, 0, objects[..., 0])
        expected = {tuple(pair) for pair in objects[objects[..., 0] >= 0]}
        annotations = coco.loadAnns(coco.getAnnIds(imgIds=row["pair"]))
        assert len(annotations) == len(expected) == 5
        for annotation in annotations:
            [shape, *more], instance = annotation["shapes"], annotation["instance"]
            expected.remove((shape, instance))
            name = "two balls" if more else f"shape {shape}"
            assert coco.cats[annotation["category_id"]]["name"] == name and more in ([], [1])
            mask = (objects == (shape, instance)).all(-1)
            np.testing.assert_array_equal(coco.annToMask(annotation), mask)
            box = reader.maskUtils.toBbox(coco.annToRLE(annotation))
            assert annotation["bbox"] == box.tolist()
            assert annotation["area"] == mask.sum() and annotation["iscrowd"] == 0
        assert not expected
        # The picture is that of the degraded file, as PNG shows it.
        information = coco.imgs[row["pair"]]
        assert (information["width"], information["height"]) == (WIDTH, HEIGHT)
        shown = pz.read_image(path.parent / information["file_name"])
        np.testing.assert_allclose(shown, np.clip(image.pixels, 0, 1), atol=0.006)
    assert sorted(p.name for p in path.parent.iterdir()) == ["annotations", "annotations.json"]
    pictures = sorted(p.name for p in (path.parent / "annotations").iterdir())
    assert pictures == ["000000.degraded.png", "000001.degraded.png"]
    # COCO's own metric finds them perfect.
    evaluation = pytest.importorskip("pycocotools.cocoeval")
    results = [{**a, "score": 1.0, "segmentation": coco.annToRLE(a)} for a in written["annotations"]]
    for kind in ("bbox", "segm"):
        judged = evaluation.COCOeval(coco, coco.loadRes(results), kind)
        judged.evaluate(), judged.accumulate(), judged.summarize()
        assert judged.stats[0] == 1.0


def test_categories_name_merge_and_leave_out(still, tmp_path):
    names = {WALL: "wall", 0: "ball", 1: "ball", BALL: "ball", 77: "absent"}
    written = pz.export.coco(still, tmp_path / "a.json", categories=names, pictures=False, min_pixels=3)
    assert [(c["id"], c["name"]) for c in written["categories"]] == [(1, "wall"), (2, "ball"), (3, "absent")]
    assert [image["file_name"] for image in written["images"]] == ["000000.degraded.exr", "000001.degraded.exr"]
    first = [a for a in written["annotations"] if a["image_id"] == 0]
    # Both balls of an instance are one object; the ball without an instance is its own.
    found = {(tuple(a["shapes"]), a["instance"], a["category_id"]) for a in first}
    assert found == {((WALL,), -1, 1), ((0, 1), 0, 2), ((0, 1), 1, 2), ((BALL,), -1, 2)}
    assert list(tmp_path.iterdir()) == [tmp_path / "a.json"]
    fewer = pz.export.coco(still, tmp_path / "a.json", pictures=False, min_pixels=40)["annotations"]
    assert fewer and all(a["area"] >= 40 and a["shapes"] == [WALL] for a in fewer)
    clean = pz.export.coco(still, tmp_path / "b" / "a.json", picture="clean", pictures="jpg", exposure="auto")
    assert [i["file_name"] for i in clean["images"]] == ["a/000000.clean.jpg", "a/000001.clean.jpg"]
    assert (tmp_path / "b" / "a" / "000000.clean.jpg").read_bytes().startswith(b"\xff\xd8")


def test_shapes_of_several_scenes_are_not_mixed(tmp_path, lens_path):
    folder = render_set(tmp_path, lens_path, scenes=("a.pbrt", "b.pbrt"), layers=["object", "depth"], pairs=6)
    scenes = {row["scene"] for row in rows_of(folder)}
    assert len(scenes) == 2
    written = pz.export.coco(folder, tmp_path / "a.json", pictures=False)
    names = [category["name"] for category in written["categories"]]
    assert names == [*(f"{scene}.pbrt shape {n}" for scene in "ab" for n in range(2, 5)), "two balls"]
    with pytest.raises(ValueError, match=r"categories: the data set has 2 scenes.*\{'a.pbrt': \{0: 'name'\}\}"):
        pz.export.coco(folder, tmp_path / "b.json", categories={0: "ball"})
    by_scene = {"a.pbrt": {WALL: "wall"}, "b.pbrt": {WALL: "wall", CARD: "card"}}
    written = pz.export.coco(folder, tmp_path / "a.json", categories=by_scene, pictures=False)
    assert [category["name"] for category in written["categories"]] == ["wall", "card"]
    pz.export.bop(folder, tmp_path / "bop")
    pairs = [sorted(json.loads((tmp_path / "bop" / s / "scene_camera.json").read_text())) for s in ("000000", "000001")]
    expected = [[str(r["pair"]) for r in rows_of(folder) if r["scene"] == scene] for scene in sorted(scenes)]
    assert pairs == expected and all(pairs)


# Arrays


def expected_arrays(folder, row):
    """Return the arrays of a pair that exports stack."""
    found = {kind: pz.read_image(folder / row["files"][kind]["file"]) for kind in ("clean", "degraded", "raw")}
    image = taken(folder, row)
    found.update({f"degraded.{name}": image.layers[name] for name in LAYERS if name != "vignetting"})
    return found, image


def test_hdf5_holds_all_pairs(still, tmp_path):
    h5py = pytest.importorskip("h5py")
    path, shares = tmp_path / "set.h5", []
    assert pz.export.hdf5(still, path, progress=shares.append) is None
    assert shares == [0.5, 1.0] and list(tmp_path.iterdir()) == [path]
    rows = rows_of(still)
    with h5py.File(path) as file:
        names = {"clean", "degraded", "raw", "pair", "rows", "psf", "degraded.vignetting"}
        pictures = {f"{p}.{name}" for p in ("clean", "degraded") for name in ("depth", "position", "object", "albedo")}
        assert set(file) == names | pictures
        assert [json.loads(text) for text in file["rows"].asstr()] == rows and list(file["pair"]) == [0, 1]
        assert file["clean"].chunks == (1, HEIGHT, WIDTH, 3) and file["clean"].compression == "gzip"
        assert file["raw"].shape == (2, HEIGHT, WIDTH)
        assert list(file["degraded.depth"].attrs["channels"]) == ["Z", "coverage"]
        for number, row in enumerate(rows):
            arrays, image = expected_arrays(still, row)
            for name, values in arrays.items():
                np.testing.assert_array_equal(file[name][number], values, err_msg=name)
            np.testing.assert_array_equal(file["psf"][f"{number:06d}"], np.load(still / row["files"]["psf"]["file"]))
            vignetting = file["degraded.vignetting"][f"{number:06d}"]
            np.testing.assert_array_equal(vignetting, image.layers["vignetting"])
            assert list(vignetting.attrs["channels"]) == image.channels["vignetting"]


def test_hdf5_names_what_to_install(still, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(ImportError, match="HDF5 files need h5py: .*; pip install h5py"):
        pz.export.hdf5(still, tmp_path / "a.h5")


def test_archives_hold_all_pairs(still, tmp_path):
    rows = rows_of(still)
    for most, names in [(1, ["00000.npz", "00001.npz"]), (64, ["00000.npz"])]:
        shares = []
        out = tmp_path / str(most)
        assert pz.export.npz(still, out, pairs_per_file=most, progress=shares.append) == names
        assert shares == [0.5, 1.0] and sorted(path.name for path in out.iterdir()) == names
        seen = []
        for name in names:
            with np.load(out / name) as file:
                found = [json.loads(text) for text in file["rows"]]
                assert list(file["pair"]) == [row["pair"] for row in found]
                seen += found
                assert json.loads(str(file["channels"]))["clean.depth"] == ["Z", "coverage"]
                for number, row in enumerate(found):
                    for array, values in expected_arrays(still, row)[0].items():
                        np.testing.assert_array_equal(file[array][number], values, err_msg=array)
                    psf = np.load(still / row["files"]["psf"]["file"])
                    np.testing.assert_array_equal(file[f"psf/{row['pair']:06d}"], psf)
        assert seen == rows


# Folders and files


@pytest.mark.filterwarnings("ignore:.*scene_gt")
def test_the_code_of_the_manual_runs(still, root, tmp_path, monkeypatch):
    pytest.importorskip("h5py")
    section = (root / "docs/dataset.md").read_text().split("## Other formats")[1]
    code = re.search(r"```python\n(.*?)```", section, re.S)[1]
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "bokeh").symlink_to(still)
    monkeypatch.chdir(tmp_path)
    exec(code, {"pz": pz})
    for name in ("coco/annotations.json", "bop/train_pbr/000000/scene_camera.json", "npz/00000.npz", "bokeh.h5"):
        assert (tmp_path / "out" / name).is_file(), name


EXPORTS = {
    "coco": lambda folder, out: pz.export.coco(folder, out / "a.json"),
    "bop": lambda folder, out: pz.export.bop(folder, out / "bop"),
    "npz": lambda folder, out: pz.export.npz(folder, out / "npz"),
    "hdf5": lambda folder, out: pz.export.hdf5(folder, out / "a.h5"),
}


@pytest.fixture
def copy(still, tmp_path):
    """A copy of a data set, to spoil."""
    folder = tmp_path / "copy"
    folder.mkdir()
    for path in still.iterdir():
        (folder / path.name).write_bytes(path.read_bytes())
    return folder


@pytest.mark.parametrize("name", EXPORTS)
@pytest.mark.filterwarnings("ignore:.*scene_gt")
def test_what_is_missing_is_named_and_leaves_nothing(name, copy, tmp_path):
    out, export = tmp_path / "out", EXPORTS[name]
    with pytest.raises(FileNotFoundError, match=r"none: there is no manifest\.jsonl"):
        export(tmp_path / "none", out)
    (copy / "000001.clean.exr").rename(copy / "away")
    with pytest.raises(FileNotFoundError, match=r"000001\.clean\.exr: the file is missing.*manifest\.jsonl:2.*again"):
        export(copy, out)
    (copy / "000001.clean.exr").write_bytes(b"short")
    with pytest.raises(ValueError, match=r"000001\.clean\.exr: found 5 bytes, expected \d+ .*manifest\.jsonl:2"):
        export(copy, out)
    # The file has its size, but is damaged: there is an error in the middle of the work.
    size = (copy / "away").stat().st_size
    for kind in ("clean", "degraded"):
        size = (copy / "away").stat().st_size if kind == "clean" else (copy / "000001.degraded.exr").stat().st_size
        (copy / f"000001.{kind}.exr").write_bytes(bytes(size))
    with pytest.raises(ValueError, match="000001"):
        export(copy, out)
    left = list(out.rglob("*")) if out.exists() else []
    assert left == []


def test_shards_are_merged_and_sorted(copy, tmp_path):
    first, second = (copy / "manifest.jsonl").read_text().splitlines()
    (copy / "manifest.jsonl").unlink()
    (copy / "manifest.00001-of-00002.jsonl").write_text(second + "\n")
    # A row that was replaced, one of a lost file, and one that is being written.
    stale = json.loads(first)
    stale["files"]["degraded"] = {"file": "gone.exr", "bytes": 1}
    (copy / "manifest.00002-of-00002.jsonl").write_text(first + "\n" + json.dumps(stale) + '\n{"pair":')
    written = pz.export.coco(copy, tmp_path / "a.json", pictures=False)
    assert [image["id"] for image in written["images"]] == [0, 1]
    other = {**json.loads(second), "spec": "another"}
    (copy / "manifest.00001-of-00002.jsonl").write_text(json.dumps(other) + "\n")
    with pytest.raises(ValueError, match="2 specifications"):
        pz.export.coco(copy, tmp_path / "a.json")
    for text in ("[1]\n", "{\n", '{"pair": 3}\n', '{"pair": 3, "files": {"clean": 4}}\n'):
        (copy / "manifest.00001-of-00002.jsonl").write_text(second + "\n" + text)
        with pytest.raises(ValueError, match=r"manifest\.00001-of-00002\.jsonl:2: "):
            pz.export.coco(copy, tmp_path / "a.json")
    (copy / "manifest.00001-of-00002.jsonl").unlink()
    (copy / "manifest.00002-of-00002.jsonl").write_text('{"pair":')
    with pytest.raises(ValueError, match="no pair is finished"):
        pz.export.coco(copy, tmp_path / "a.json")


@pytest.mark.filterwarnings("ignore:.*scene_gt")
def test_inputs_and_full_folders_are_not_replaced(copy, tmp_path):
    before = {path: path.read_bytes() for path in copy.iterdir()}
    pytest.importorskip("h5py")
    for export in (pz.export.coco, pz.export.hdf5):
        for name in ("manifest.jsonl", "000000.clean.exr", "000001.psf.npy"):
            with pytest.raises(ValueError, match=f"{name}: this is a file of the data set; choose another"):
                export(copy, copy / name)
        with pytest.raises(IsADirectoryError, match="copy: this is a folder"):
            export(copy, copy)
    # Pictures of another export stay.
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "000000.degraded.png").write_bytes(b"other")
    with pytest.raises(FileExistsError, match="a: this exists and is no empty folder"):
        pz.export.coco(copy, tmp_path / "a.json")
    assert not (tmp_path / "a.json").exists() and (tmp_path / "a" / "000000.degraded.png").read_bytes() == b"other"
    with pytest.raises(ValueError, match="expected a name such as .*b.json"):
        pz.export.coco(copy, tmp_path / "b")
    for export in (pz.export.bop, pz.export.npz):
        with pytest.raises(FileExistsError, match="copy: this exists and is no empty folder"):
            export(copy, copy)
        (tmp_path / export.__name__).mkdir()
        export(copy, tmp_path / export.__name__)
        assert any((tmp_path / export.__name__).iterdir())
    assert {path: path.read_bytes() for path in copy.iterdir()} == before


def test_wrong_arguments_are_told(still, tmp_path):
    for call, error, message in [
        (lambda: pz.export.coco(still, tmp_path / "a.json", picture="raw"), ValueError, "picture='raw': expected"),
        (lambda: pz.export.bop(still, tmp_path / "a", picture="raw"), ValueError, "picture='raw': expected"),
        (lambda: pz.export.coco(still, tmp_path / "a.json", pictures="webp"), ValueError, "pictures='webp'"),
        (lambda: pz.export.coco(still, tmp_path / "a.json", min_pixels=0), ValueError, "min_pixels=0"),
        (lambda: pz.export.coco(still, tmp_path / "a.json", categories=["a"]), TypeError, "categories"),
        (lambda: pz.export.coco(still, tmp_path / "a.json", categories={"a": 0}), TypeError, "categories"),
        (lambda: pz.export.coco(still, tmp_path / "a.json", categories={"x.pbrt": {0: "a"}}), ValueError, "x.pbrt"),
        (lambda: pz.export.npz(still, tmp_path / "a", pairs_per_file=0), ValueError, "pairs_per_file=0"),
        (lambda: pz.export.npz(still, tmp_path / "a", progress="yes"), TypeError, "progress"),
    ]:
        with pytest.raises(error, match=message):
            call()
    assert list(tmp_path.iterdir()) == []
