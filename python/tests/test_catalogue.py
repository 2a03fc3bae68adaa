"""Glass catalogues of makers, for lenses and for renders."""

import pytest

import petzval as pz

# n^2 = 4 at all wavelengths.
CATALOGUE = "CC mine\nNM MYGLASS 1 0 2.0 50 0 1\nCD 4 0 0 0 0 0\nLD 0.3 2.5\n"
LENS = """
[[surface]]
radius = 50
thickness = 5
diameter = 20
glass = "myglass"
[[surface]]
radius = -50
thickness = 1
diameter = 20
[[surface]]
diameter = 10
stop = true
"""


@pytest.fixture
def files(tmp_path):
    folder = tmp_path / "catalogues"
    folder.mkdir()
    (folder / "mine.agf").write_text(CATALOGUE)
    (tmp_path / "lens.toml").write_text(LENS)
    return tmp_path / "lens.toml", folder


def test_a_lens_takes_glasses_from_catalogues(files):
    lens, folder = files
    with pytest.raises(ValueError, match="myglass"):
        pz.Lens(lens)
    for catalogue in (folder / "mine.agf", str(folder), [folder / "mine.agf"]):
        assert pz.Lens(lens, catalogue=catalogue).surfaces[0]["index"] == pytest.approx(2.0)
    with pytest.raises(ValueError, match="no glass in the file"):
        pz.Lens(lens, catalogue=lens)
    with pytest.raises(OSError, match="none.agf"):
        pz.Lens(lens, catalogue=lens.parent / "none.agf")


def test_a_render_takes_the_catalogues_of_its_lens_and_of_its_settings(files, scene_path):
    lens, folder = files
    settings = dict(spp=1, effects="none", focus=2.0)
    with pytest.raises(ValueError, match="myglass"):
        pz.render(scene_path, lens=lens, **settings)
    one = pz.render(scene_path, lens=lens, catalogue=folder, **settings)
    other = pz.render(scene_path, lens=pz.Lens(lens, catalogue=folder), **settings)
    assert one.pixels.mean() > 0 and (one.pixels == other.pixels).all()
    none = pz.render(scene_path, lens=pz.Lens(lens, catalogue=folder), catalogue=None, **settings)
    assert (none.pixels == one.pixels).all()
    camera = pz.Camera(lens=pz.Lens(lens, catalogue=folder))
    assert (pz.render(scene_path, camera, **settings).pixels == one.pixels).all()
