"""Checkpoints and the limit of memory of renders."""

import signal
import subprocess
import sys
import threading
import time
import _thread

import numpy as np
import pytest

import petzval as pz


def interrupted(path, scene, **settings):
    """Render until a checkpoint is written, then press Ctrl-C."""

    def press():
        end = time.monotonic() + 60
        while time.monotonic() < end and not (path.exists() and path.stat().st_size > 6000):
            time.sleep(0.01)
        _thread.interrupt_main()

    threading.Thread(target=press).start()
    with pytest.raises(KeyboardInterrupt):
        pz.render(scene, checkpoint=path, checkpoint_interval=0.1, **settings)
    assert path.exists()


def test_a_render_that_was_interrupted_goes_on_to_the_same_bits(scene_path, tmp_path):
    path = tmp_path / "a.checkpoint"
    settings = dict(spp=6000, seed=2, effects="none", fstop=4, aov=["depth", "variance"])
    whole = pz.render(scene_path, **settings)
    interrupted(path, scene_path, **settings)
    shares = []
    resumed = pz.render(scene_path, checkpoint=path, resume=True, progress=shares.append, **settings)
    assert shares[0] > 0
    np.testing.assert_array_equal(resumed.pixels, whole.pixels)
    for name, layer in whole.layers.items():
        np.testing.assert_array_equal(resumed.layers[name], layer)
    assert not path.exists()


def test_a_checkpoint_of_another_picture_is_refused(scene_path, tmp_path):
    path = tmp_path / "a.checkpoint"
    settings = dict(spp=6000, effects="none", fstop=4)
    interrupted(path, scene_path, **settings)
    before = path.read_bytes()
    for change, expected in [
        (dict(fstop=8), "fstop was 4.0, and is 8.0 now"),
        (dict(seed=9), "the seed"),
        (dict(spp=7000), "samples"),
        (dict(resolution=(20, 20)), "the resolution"),
        (dict(aov=["depth"]), "the list of layers"),
        (dict(focus=1.0), "focus"),
    ]:
        with pytest.raises(ValueError, match=f"cannot resume from .*{expected}"):
            pz.render(scene_path, checkpoint=path, resume=True, **{**settings, **change})
    text = scene_path.read_text()
    scene_path.write_text(text + "\n# another\n")
    with pytest.raises(ValueError, match="ball.pbrt has changed since"):
        pz.render(scene_path, checkpoint=path, resume=True, **settings)
    assert path.read_bytes() == before
    scene_path.write_text(text)
    # Equal values of other types are the same picture.
    same = dict(spp=np.int64(6000), effects="none", fstop=np.float32(4))
    pz.render(scene_path, checkpoint=path, resume=True, **same)


def test_arrays_are_inputs_of_a_checkpoint(tmp_path):
    path = tmp_path / "a.checkpoint"
    settings = dict(spp=6000, effects="none")

    def scene(height, curved=60.0):
        rows = [(curved, 6.0, 1.6, 30.0), (-60.0, 2.0, 1.0, 30.0), (0.0, 1.0, 0.0, 12.0)]
        wall = pz.Mesh([[-3, -3, 4], [3, -3, 4], [0, height, 4]], [[0, 2, 1]])
        return pz.Scene.from_arrays(
            [wall],
            lens=pz.Lens(rows),
            look_at=((0, 0, 0), (0, 0, 1)),
            lights=[{"type": "infinite", "L": 1.0}],
            resolution=(48, 32),
        )

    interrupted(path, scene(3), **settings)
    for other, message in [
        (scene(4), "the scene of arrays has changed since"),
        (scene(3, 61.0), "the lens table has changed since"),
    ]:
        with pytest.raises(ValueError, match=message):
            pz.render(other, checkpoint=path, resume=True, **settings)
    # Equal arrays and rows go on, also in another process: no name of theirs differs.
    resumed = pz.render(scene(3), checkpoint=path, resume=True, **settings)
    np.testing.assert_array_equal(resumed.pixels, pz.render(scene(3), **settings).pixels)


def test_nonsense_about_checkpoints_is_refused(scene_path, tmp_path):
    with pytest.raises(ValueError, match="name the file by checkpoint"):
        pz.render(scene_path, resume=True)
    with pytest.raises(ValueError, match="checkpoint_interval"):
        pz.render(scene_path, checkpoint=tmp_path / "a", checkpoint_interval=0)
    # A long render would find out at its first checkpoint.
    with pytest.raises(FileNotFoundError, match="cannot write"):
        pz.render(scene_path, checkpoint=tmp_path / "gone" / "a")
    with pytest.raises(IsADirectoryError, match="cannot write"):
        pz.render(scene_path, checkpoint=tmp_path)
    bad = tmp_path / "bad"
    bad.write_text("no checkpoint")
    with pytest.raises(ValueError, match="bad"):
        pz.render(scene_path, checkpoint=bad, resume=True)
    # Without a checkpoint there, the render begins.
    image = pz.render(scene_path, checkpoint=tmp_path / "none", resume=True)
    np.testing.assert_array_equal(image.pixels, pz.render(scene_path).pixels)
    assert not (tmp_path / "none").exists()


def test_a_render_that_would_take_too_much_memory_is_refused(scene_path):
    scene = pz.Scene(scene_path)
    for limit in (1_000_000, "1MB"):
        with pytest.raises(MemoryError, match="memory allows 1 MB; to take less"):
            pz.render(scene, memory=limit)
    # A picture of 8000 x 8000 pixels with layers takes gigabytes.
    with pytest.raises(MemoryError, match="arrays"):
        pz.render(scene, resolution=(8000, 8000), aov=["depth", "normal"], memory="2GiB")
    pz.render(scene, memory="4GiB")
    with pytest.raises(ValueError, match="memory"):
        pz.render(scene, memory="much")


def test_a_scene_that_declares_too_much_is_refused(scene_path, tmp_path):
    # The text is half as large as the mesh.
    rows = " ".join("0 0 1" for _ in range(20_000))
    mesh = f'Shape "trianglemesh" "integer indices" [0 1 2] "point3 P" [{rows}]\n'
    path = tmp_path / "large.pbrt"
    path.write_text(scene_path.read_text() + mesh)
    with pytest.raises(MemoryError, match="there are 200"):
        pz.Scene(path, memory=200_000)
    with pytest.raises(MemoryError):
        pz.render(path, memory="200kB")
    assert pz.Scene(path, memory="1GiB").path
    # Also a file that is larger than all of it, and a texture.
    with pytest.raises(MemoryError, match="there are 10 B"):
        pz.Scene(scene_path, memory=10)
    pz.write_image(tmp_path / "large.png", np.zeros((500, 500, 3), np.float32))
    path.write_text(
        'WorldBegin Texture "t" "spectrum" "imagemap" "string filename" "large.png"\n'
    )
    with pytest.raises(MemoryError, match="large.png"):
        pz.Scene(path, memory=100_000)
    for memory, error in [(-1, ValueError), (2**70, ValueError), (1.5, TypeError)]:
        with pytest.raises(error, match="memory=.*: expected a whole number of bytes"):
            pz.Scene(scene_path, memory=memory)


WAITS = """
import sys, time
import petzval as pz
print("begins", flush=True)
start = time.monotonic()
try:
    {work}
except KeyboardInterrupt:
    print("interrupted", time.monotonic() - start, flush=True)
    time.sleep(0.2)
    sys.exit(7)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="needs signals")
def test_ctrl_c_ends_the_reading_of_a_scene(tmp_path):
    # The lexer takes longer than a second for so many numbers.
    count = 400_000
    with open(tmp_path / "large.pbrt", "w") as file:
        file.write("WorldBegin\n")
        rows = " ".join("0.125 0.25 0.5" for _ in range(count))
        for _ in range(12):
            file.write(f'Shape "trianglemesh" "integer indices" [0 1 2] "point3 P" [{rows}]\n')
    seconds = seconds_until_interrupt(f'pz.Scene({str(tmp_path / "large.pbrt")!r})')
    assert seconds < 1


@pytest.mark.skipif(sys.platform == "win32", reason="needs signals")
def test_ctrl_c_ends_the_preparation_of_a_scene(root):
    # Its lamps and its diffraction take seconds.
    scene = root / "scenes" / "night.pbrt"
    seconds = seconds_until_interrupt(f"pz.prepare(pz.Scene({str(scene)!r}))")
    assert seconds < 1


def seconds_until_interrupt(work):
    """Run work in a process, press Ctrl-C soon after its beginning, and return when it ended."""
    process = subprocess.Popen(
        [sys.executable, "-c", WAITS.format(work=work)], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout.readline() == "begins\n"
    time.sleep(0.2)
    process.send_signal(signal.SIGINT)
    answer = process.stdout.readline().split()
    assert process.wait(60) == 7 and answer[0] == "interrupted", answer
    return float(answer[1])
