#!/usr/bin/env python3
"""Tests the page of `petzval view` in Chromium, by the DevTools protocol. Needs Python's library alone.

    python3 tests/view/browser.py target/release/petzval [--screens FOLDER]

It checks that the page loads and refines, that a click changes the focus and a ring the exposure, that rings and
readout say the same, that the wipe shows two pictures, that the keyboard moves the camera, that drawings follow the
theme, that fingers can meet the controls, that these stop with the connection and come back with it, that the
console stays empty, and that no request leaves the machine. With --screens it writes screenshots in two sizes, light
and dark.
"""

import argparse
import base64
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
import urllib.request

from websocket import WebSocket

BROWSERS = ["chromium", "chromium-browser", "google-chrome"]
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
# The longest wait for anything (s). Only a page that hangs reaches it.
HANG = 60


class DevTools:
    """A page of the browser: commands and events."""

    def __init__(self, address):
        self.socket = WebSocket(address, HANG)
        self.number = 0
        self.events = []

    def call(self, method, **parameters):
        self.number += 1
        self.socket.send(json.dumps({"id": self.number, "method": method, "params": parameters}).encode())
        while True:
            message = json.loads(self.socket.receive()[1])
            if message.get("id") == self.number:
                assert "error" not in message, (method, message)
                return message["result"]
            self.events.append(message)

    def run(self, script):
        result = self.call("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in result, result
        return result["result"].get("value")

    def wait(self, what, script):
        start = time.time()
        while not (value := self.run(script)):
            assert time.time() - start < HANG, f"waited in vain for {what}"
            time.sleep(0.02)
        return value

    def press(self, key, code=0, text=""):
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, windowsVirtualKeyCode=code,
                      text=text if kind == "keyDown" else "")

    def drag(self, points):
        for i, (x, y) in enumerate(points):
            kind = "mousePressed" if i == 0 else "mouseMoved"
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=1, clickCount=1)
        x, y = points[-1]
        self.call("Input.dispatchMouseEvent", type="mouseReleased", x=x, y=y, button="left", clickCount=1)


def start_view(petzval, scene, *options, folder=ROOT):
    command = [petzval, "view", scene, "--no-open", *options]
    child = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    return child, child.stdout.readline().strip()


def start_browser(folder):
    program = next(filter(shutil.which, BROWSERS), None)
    assert program, f"no browser: expected one of {BROWSERS}"
    child = subprocess.Popen(
        [program, "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
         "--disable-background-networking", "--disable-component-update", "--disable-sync", "--hide-scrollbars",
         "--remote-debugging-port=0", f"--user-data-dir={folder}", "about:blank"],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    port_file, start = os.path.join(folder, "DevToolsActivePort"), time.time()
    while not os.path.exists(port_file) or not open(port_file).read().strip():
        assert time.time() - start < HANG and child.poll() is None, "the browser does not start"
        time.sleep(0.05)
    port = open(port_file).read().split()[0]
    start = time.time()
    while True:
        pages = json.load(urllib.request.urlopen(f"http://127.0.0.1:{port}/json"))
        pages = [page for page in pages if page["type"] == "page"]
        if pages:
            return child, DevTools(pages[0]["webSocketDebuggerUrl"])
        assert time.time() - start < HANG, "the browser has no page"
        time.sleep(0.05)


# A negative group before a positive one: the gap between them zooms.
ZOOM = """name = "two groups"
[[surface]]
radius = -82.688
thickness = 1
diameter = 30
index = 1.5168
[[surface]]
radius = 82.688
thickness = 40
diameter = 30
[[surface]]
stop = true
diameter = 10
thickness = 1
[[surface]]
radius = 51.68
thickness = 3
diameter = 30
index = 1.5168
[[surface]]
radius = -51.68
diameter = 30
[[configuration]]
film_distance = 82
thickness = [[2, 60]]
[[configuration]]
film_distance = 110
thickness = [[2, 20]]
"""


def copy_scene(folder):
    """Copies the scene of this test, with its lenses and a zoom lens, into a folder where it may write."""
    shutil.copytree(os.path.join(ROOT, "lenses"), os.path.join(folder, "lenses"))
    os.mkdir(os.path.join(folder, "scenes"))
    for name in ("dgauss.pbrt", "cones.pbrt", "grid.png"):
        shutil.copy(os.path.join(ROOT, "scenes", name), os.path.join(folder, "scenes"))
    with open(os.path.join(folder, "lenses", "zoom.toml"), "w") as file:
        file.write(ZOOM)


FINISHED = "document.getElementById('r-samples').textContent.endsWith('finished')"
GENERATION = "Number(document.documentElement.dataset.generation)"
# The mean of the canvas, 0 to 255.
MEAN = """(() => {
  const canvas = document.getElementById('picture');
  const data = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
  let sum = 0;
  for (let i = 0; i < data.length; i += 4) sum += data[i] + data[i + 1] + data[i + 2];
  return sum / (data.length / 4 * 3);
})()"""
# The canvas in short: values that change with the picture.
PRINT = "document.getElementById('picture').toDataURL()"


def set_range(page, name, value):
    page.run(f"(() => {{ const input = document.getElementById('{name}'); input.value = {value};"
             " input.dispatchEvent(new Event('input')); })()")


def finished_after(page, act):
    before = page.run(GENERATION)
    act()
    page.wait("the next picture", f"{GENERATION} > {before} && {FINISHED}")


def box(page, name):
    return page.run(f"(() => {{ const b = document.getElementById('{name}').getBoundingClientRect();"
                    " return [b.left, b.top, b.width, b.height]; })()")


def text(page, name):
    return page.run(f"document.getElementById('{name}').textContent")


def same_words(page, ring, readout, before=""):
    """The words of a ring, which those of the readout equal."""
    words = text(page, f"{ring}-value")
    assert words and before + words == text(page, readout), (words, text(page, readout))
    assert page.run(f"document.getElementById('{ring}').getAttribute('aria-valuetext')") == words
    return words


def rings_say_the_values(page):
    """Values between the steps of a ring are said as they are, and the widest stop is on the ring."""
    for options, expected in [
        ({"fstop": "3.0", "focus": "0.745", "shutter": "time=1/24", "sensor": "iso=500"},
         ("f/3.0", "0.745 m", "1/24 s", "ISO 500")),
        ({"fstop": "2", "focus": "123.4", "shutter": "time=0.29", "sensor": "iso=12345"},
         ("f/2.0", "123.4 m", "0.29 s", "ISO 12345")),
        ({"fstop": "33.3", "focus": "inf", "shutter": "time=90", "sensor": "iso=40"},
         ("f/33.3", "\u221e", "90 s", "ISO 40")),
    ]:
        finished_after(page, lambda: page.run(f"window.petzval.link.set({json.dumps(options)})"))
        words = [same_words(page, "stop", "r-stop"), same_words(page, "focus", "r-focus", "focus "),
                 same_words(page, "time", "r-time"), same_words(page, "iso", "r-iso")]
        words[0], t_number = words[0].split()
        assert tuple(words) == expected and t_number.startswith("T"), (words, expected)
    finished_after(page, lambda: page.run("window.petzval.link.set({ sensor: null, focus: '0.741', shutter: 'time=1/60' })"))
    assert text(page, "iso-value") == text(page, "r-iso") + ", no noise"
    finished_after(page, lambda: set_range(page, "stop", 0))
    assert same_words(page, "stop", "r-stop").startswith("f/2.0 "), text(page, "r-stop")
    command = page.run("document.getElementById('command').value")
    assert "--fstop=2.00" in command and not page.run("!!document.querySelector('#warnings li')"), command
    # One ring of a pair leaves the value of the other between its steps.
    finished_after(page, lambda: page.run("window.petzval.link.set({ 'film-tilt': '0.3,0.7' })"))
    assert (text(page, "tilt-x-value"), text(page, "tilt-y-value")) == ("0.3\u00b0", "0.7\u00b0")
    finished_after(page, lambda: set_range(page, "tilt-x", 3))
    assert "--film-tilt=1.5,0.7" in page.run("document.getElementById('command').value")
    finished_after(page, lambda: page.run("window.petzval.link.set({ 'film-tilt': null })"))


def stop_words_of_other_lenses(page):
    """The f-number is that of the marginal ray, as `--fstop` counts it, also where first-order optics differs."""
    for lens, widest in [("wide.22mm.dat", "f/2.8"), ("telephoto.250mm.dat", "f/5.6")]:
        options = {"lens": f"scenes/../lenses/{lens}", "fstop": None, "focus": "20"}
        finished_after(page, lambda: page.run(f"window.petzval.link.set({json.dumps(options)})"))
        finished_after(page, lambda: set_range(page, "stop", 0))
        assert same_words(page, "stop", "r-stop").startswith(widest + " "), text(page, "r-stop")
    finished_after(page, lambda: page.run("window.petzval.link.set({ lens: null, fstop: null, focus: null })"))


# The lightest and the darkest pixel of a drawing: paper and ink.
CONTRAST = """(async () => {
  const drawing = document.querySelector('#NAME svg');
  const colours = [...drawing.querySelectorAll('[fill], [stroke], text')].flatMap((part) => {
    const style = getComputedStyle(part);
    return [style.fill, style.stroke].filter((colour) => colour.startsWith('rgb('));
  });
  const light = (colour) => colour.match(/\\d+/g).slice(0, 3).reduce((sum, n) => sum + Number(n), 0) / 3;
  const paper = light(getComputedStyle(drawing.querySelector('rect')).fill);
  const lines = [...drawing.querySelectorAll('path, circle, text')].flatMap((part) => {
    const style = getComputedStyle(part);
    const shown = part.localName === 'path' ? [style.stroke] : [style.fill];
    return shown.filter((colour) => colour.startsWith('rgb(')).map(light);
  });
  return [paper, Math.min(...lines.map((line) => Math.abs(line - paper))), lines.length];
})()"""


def drawings_follow_the_theme(page):
    for scheme in ("dark", "light"):
        page.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
        for name in ("lens-section", "bench-spot", "bench-transfer", "lenses"):
            paper, least, lines = page.run(CONTRAST.replace("NAME", name))
            assert (paper < 60) == (scheme == "dark") and lines > 5, (scheme, name, paper, lines)
            assert least > 50, f"{name} in the {scheme} theme has lines that cannot be seen: {least}"


def fingers(page):
    """On a touch screen, everything that can be operated is at least 44 px high."""
    page.call("Emulation.setDeviceMetricsOverride", width=390, height=844, deviceScaleFactor=1, mobile=True)
    page.call("Emulation.setTouchEmulationEnabled", enabled=True)
    assert page.run("matchMedia('(pointer: coarse)').matches")
    page.run("document.querySelectorAll('details').forEach((one) => { one.open = true; })")
    low = page.run("""[...document.querySelectorAll('#panel button, #panel select, #panel summary, #panel input, #drawer button')]
      .map((one) => [one.id || one.textContent, one.type === 'checkbox' ? one.closest('label') : one])
      .filter(([, one]) => one.checkVisibility() && one.getBoundingClientRect().height < 44)
      .map(([name, one]) => `${name}: ${one.getBoundingClientRect().height}`)""")
    assert not low, low
    assert page.run("document.documentElement.scrollWidth <= innerWidth"), "the page is wider than the screen"
    page.call("Emulation.setTouchEmulationEnabled", enabled=False)
    page.call("Emulation.setDeviceMetricsOverride", width=1280, height=800, deviceScaleFactor=1, mobile=False)


def unmeasured_models(page):
    """A model without a point is named so."""
    page.run("""window.petzval.accuracy.show({ type: 'accuracy', status: 'finished', seconds: 20, budget: 20,
      models: ['thick', 'real f32', 'real f64'], verdicts: [{ model: 0, sentence: 'fast' }], partial: 'partial',
      points: [{ model: 0, samples: 4, seconds: 1, error: 2, best: true }, { model: 2, samples: 4, seconds: 9, error: 1 }] })""")
    models = page.run("[...document.querySelectorAll('#models li')].map((one) => one.textContent)")
    assert models == ["thick: fast", "real f32: not measured", "real f64"], models
    assert page.run("document.querySelectorAll('#models .unmeasured').length") == 1
    assert text(page, "measured") == "partial"


# Controls that a hand or a key could still operate.
OPERABLE = """[...document.querySelectorAll('input, select, button, textarea, a[href], [tabindex="0"]')]
  .filter((one) => !one.matches(':disabled') && one.checkVisibility()).map((one) => one.id)"""


def lost_connection(page):
    """Without a camera no control works, for the hand or the keyboard; with it they come back in its state."""
    page.run("document.getElementById('open-drawer').click()")
    socket = "window.petzval.link.socket"
    page.run(f"window.petzval.link.connect = () => {{}}; {socket}.close()")
    page.wait("the loss", "!document.getElementById('problem').hidden")
    assert "No connection" in text(page, "problem")
    assert page.run(OPERABLE) == [], page.run(OPERABLE)
    assert not page.run("document.getElementById('drawer').open")
    assert page.run("Number(getComputedStyle(document.getElementById('controls')).opacity)") < 0.7
    command, view = page.run("document.getElementById('command').value"), page.run(GENERATION)
    page.run("document.getElementById('picture').focus()")
    page.press("ArrowLeft", 37)
    left, top, width, height = box(page, "picture")
    page.drag([(left + width * 0.3, top + height * 0.6)])
    page.drag([(left + width / 2 + 10 * i, top + height / 2) for i in range(8)])
    # The second of these would wait for the answer to the first, and so for the connection.
    page.run("window.petzval.link.set({ fstop: '16' }); window.petzval.link.set({ fstop: '22' });"
             " delete window.petzval.link.connect; window.petzval.link.connect()")
    page.wait("the connection", "window.petzval.link.live")
    time.sleep(0.5)
    assert page.run("document.getElementById('problem').hidden") and not page.run("document.getElementById('controls').disabled")
    now = page.run("document.getElementById('command').value")
    assert now == command and page.run(GENERATION) == view, "wishes of the time without a camera are carried out"
    finished_after(page, lambda: set_range(page, "stop", 5))
    page.run("document.getElementById('picture').focus()")
    finished_after(page, lambda: page.press("ArrowLeft", 37))
    page.run("document.getElementById('home').click()")


def film_and_zoom(page):
    """The size of the film, tilt and shift, and the ring of a zoom lens."""
    command = "document.getElementById('command').value"
    finished_after(page, lambda: set_range(page, "shift-x", 6))
    assert "--film-shift=3,0" in page.run(command), page.run(command)
    finished_after(page, lambda: set_range(page, "tilt-y", -4))
    assert "--film-tilt=0,-2" in page.run(command), page.run(command)
    before = page.run(PRINT)
    finished_after(page, lambda: page.run(
        "(() => { const film = document.getElementById('film'); film.value = '28.2';"
        " film.dispatchEvent(new Event('change')); })()"))
    assert "--film-diagonal=28.2" in page.run(command) and page.run(PRINT) != before
    for name, value in [("shift-x", 0), ("tilt-y", 0)]:
        finished_after(page, lambda: set_range(page, name, value))
    assert "--film-shift" not in page.run(command) and "--film-tilt" not in page.run(command)
    finished_after(page, lambda: page.run("window.petzval.link.set({ 'film-diagonal': null, fstop: null })"))

    assert page.run("document.getElementById('zoom-row').hidden"), "a lens without zoom has a zoom ring"
    finished_after(page, lambda: page.run("window.petzval.link.set({ lens: 'scenes/../lenses/zoom.toml', focus: '3' })"))
    page.wait("the zoom ring", "!document.getElementById('zoom-row').hidden")
    # Both ends of the zoom are on the ring.
    low, high = page.run("[Math.min, Math.max].map((end) => end(...window.petzval.state.lens.zoom))")
    assert 20 < low < high < 300, (low, high)
    steps = int(page.run("document.getElementById('zoom').max"))
    prints = []
    for step, expected in [(0, low), (5, low + 5 * (high - low) / steps), (steps, high)]:
        finished_after(page, lambda: set_range(page, "zoom", step))
        said = same_words(page, "zoom", "r-lens")
        assert abs(float(said.split()[0]) - expected) < 0.06, (said, expected)
        assert page.run("Number(document.getElementById('zoom').value)") == step
        prints.append(page.run(PRINT))
    assert len(set(prints)) == 3, "the zoom changes nothing"
    finished_after(page, lambda: page.run("window.petzval.link.set({ lens: null, zoom: null, focus: null })"))


def wipe(page):
    """The wipe between two lenses, and between effects on and off: A stays as it was."""
    lens = "window.petzval.link.set({ lens: 'scenes/../lenses/wide.22mm.dat', fstop: null })"
    for change, back in [(lens, "{ lens: null }"), ("window.petzval.link.set({ effects: 'none', coating: null })", "{ effects: null }")]:
        finished_after(page, lambda: page.run("window.petzval.link.set({ coating: 'none', fstop: null })"))
        page.run("document.getElementById('keep').click()")
        set_range(page, "wipe", 1000)
        kept, a = page.run(MEAN), page.run(PRINT)
        finished_after(page, lambda: page.run(change))
        assert abs(page.run(MEAN) - kept) < 0.5, f"A has changed from {kept} to {page.run(MEAN)}"
        set_range(page, "wipe", 0)
        assert page.run(PRINT) != a and abs(page.run(MEAN) - kept) > 1, (change, kept, page.run(MEAN))
        set_range(page, "wipe", 500)
        assert page.run("!document.getElementById('wipe-a').hidden && !document.getElementById('wipe-b').hidden")
        page.press("Escape", 27)
        finished_after(page, lambda: page.run(f"window.petzval.link.set({back})"))
    finished_after(page, lambda: page.run("window.petzval.link.set({ coating: null })"))


def saving(page, folder):
    """Files that the browser and the server save."""
    downloads = os.path.join(folder, "downloads")
    os.mkdir(downloads)
    page.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=downloads)
    for button, name, magic in [("save-png", "picture.png", b"\x89PNG"), ("save-exr", "picture.exr", b"v/1\x01")]:
        page.run(f"document.getElementById('{button}').click()")
        path, start = os.path.join(downloads, name), time.time()
        while not os.path.exists(path):
            assert time.time() - start < HANG, f"{name} is not saved"
            time.sleep(0.02)
        with open(path, "rb") as file:
            assert file.read(4) == magic, name
    said = "document.getElementById('said').textContent"
    page.run("document.getElementById('save-scene').click()")
    page.wait("the saved scene", f"{said} === 'Saved as scenes/view.pbrt.'")
    assert os.path.exists(os.path.join(folder, "scenes", "view.pbrt"))
    page.run("document.getElementById('save-scene').click()")
    problem = "document.getElementById('problem')"
    page.wait("the refusal of the same name", f"{problem}.textContent.includes('exists already')")
    page.run("document.getElementById('render').click()")
    page.wait("the final picture", f"{said}.startsWith('Rendered final.exr')")
    assert os.path.getsize(os.path.join(folder, "final.exr")) > 1000
    finished_after(page, lambda: page.run("window.petzval.link.set({ fstop: '5.6' })"))
    assert page.run(f"{problem}.hidden"), "an old problem stays"


def accuracy(page):
    """The plot of error against time appears while it is measured."""
    page.run("document.getElementById('accuracy').open = true")
    page.run("document.getElementById('budget').value = '20'")
    page.run("document.getElementById('measure').click()")
    page.wait("the measurement", "document.getElementById('measure').textContent === 'Cancel'")
    page.wait("its end", "document.getElementById('measure').textContent === 'Measure'")
    assert page.run("Number(document.documentElement.dataset.points)") > 3
    assert page.run("document.querySelectorAll('#models li').length") > 3
    drawn = """(() => { const plot = document.getElementById('accuracy-plot');
      return plot.getContext('2d').getImageData(0, 0, plot.width, plot.height).data.some(Boolean); })()"""
    assert page.run(drawn), "the plot is empty"


def test(page, folder):
    page.wait("the finished picture", FINISHED)
    assert page.run(MEAN) > 5, "the picture is black"
    assert not page.run("document.getElementById('clip').checked || window.petzval.screen.options.clip"), "clipping is on"
    page.wait("the command", "document.getElementById('command').value.startsWith('petzval render')")

    # The lens shows the rays of the place under the cursor, and its image.
    left, top, width, height = box(page, "picture")
    for x, y in [(0.9, 0.8), (0.5, 0.5)]:
        page.call("Input.dispatchMouseEvent", type="mouseMoved", x=left + width * x, y=top + height * y)
        for kind in ("rays", "image"):
            page.wait(f"the {kind}", f"(document.documentElement.dataset.{kind} ?? '').startsWith('{x}')")
        away = float(page.run("document.getElementById('rays-words').textContent").split()[0])
        assert (away > 10) == (x > 0.5), away
    for name in ("lens-section", "bench-spot", "bench-transfer"):
        page.wait(f"the drawing {name}", f"document.querySelector('#{name} svg')?.getBoundingClientRect().width > 0")
    page.wait("the depth of field", "document.getElementById('sharp-words').textContent.startsWith('Sharp from')")

    # A click focuses.
    first, focus = page.run(PRINT), page.run("document.getElementById('r-focus').textContent")
    finished_after(page, lambda: page.drag([(left + width * 0.2, top + height * 0.75)]))
    assert page.run(PRINT) != first, "the click has changed nothing"
    assert "auto@" in page.run("document.getElementById('command').value")
    assert page.run("document.getElementById('r-focus').textContent") != focus

    # Rings change the exposure: the shutter halves the light, and so does the display's own ring.
    finished_after(page, lambda: set_range(page, "stop", 12))
    linear = "(() => { const f = window.petzval.frame.light; let s = 0; for (const v of f) s += v; return s; })()"
    before, shutter = page.run(linear), page.run("Number(document.getElementById('time').value)")
    finished_after(page, lambda: set_range(page, "time", shutter - 1))
    ratio = before / page.run(linear)
    assert 1.9 < ratio < 2.2, f"a step of the shutter ring changes the light by {ratio}"
    bright = page.run(MEAN)
    set_range(page, "exposure", 6)
    assert page.run(MEAN) > bright * 1.2, "the brightness ring does nothing"
    set_range(page, "exposure", 0)

    # The wipe shows A on the left of its border and B on the right.
    page.run("document.getElementById('keep').click()")
    set_range(page, "wipe", 1000)
    kept = page.run(MEAN)
    finished_after(page, lambda: set_range(page, "time", shutter + 2))
    # The browser may scale a canvas in two ways, which differ by less than a code.
    assert abs(page.run(MEAN) - kept) < 0.5, f"A has changed from {kept} to {page.run(MEAN)}"
    set_range(page, "wipe", 0)
    assert page.run(MEAN) > 1.5 * kept, "B is not brighter"
    page.press("Escape", 27)
    assert page.run("document.getElementById('wipe').hidden"), "Escape does not end the wipe"

    # The keyboard moves the camera, a drag orbits, and a button goes back.
    page.run("document.getElementById('picture').focus()")
    finished_after(page, lambda: page.press("ArrowLeft", 37))
    assert "--look-at" in page.run("document.getElementById('command').value")
    middle = (left + width / 2, top + height / 2)
    finished_after(page, lambda: page.drag([(middle[0] + 10 * i, middle[1]) for i in range(8)]))
    page.run("document.getElementById('home').click()")
    page.wait("the first viewpoint", "!document.getElementById('command').value.includes('--look-at')")

    # Another lens.
    page.run("document.getElementById('open-drawer').click()")
    page.wait("the lenses", "document.querySelectorAll('#lenses svg').length > 3")
    drawings_follow_the_theme(page)
    page.press("Escape", 27)
    page.wait("the drawer to close", "!document.getElementById('drawer').open")
    name = page.run("document.getElementById('lens-name').textContent")
    page.run("document.getElementById('open-drawer').click()")
    finished_after(page, lambda: page.run("document.querySelector('#lenses button[aria-pressed=false]').click()"))
    page.wait("the name of the lens", f"document.getElementById('lens-name').textContent !== {json.dumps(name)}")

    finished_after(page, lambda: page.run("window.petzval.link.set({ lens: null, fstop: null })"))

    rings_say_the_values(page)
    stop_words_of_other_lenses(page)
    film_and_zoom(page)
    wipe(page)
    saving(page, folder)
    accuracy(page)
    unmeasured_models(page)
    fingers(page)
    lost_connection(page)

    # A value that the lens refuses is said, and the page goes on.
    page.run("window.petzval.link.set({ fstop: '0.3' })")
    page.wait("the error", "document.getElementById('problem').textContent.includes('--fstop 0.3')")
    finished_after(page, lambda: page.run("window.petzval.link.set({ fstop: null })"))
    assert page.run("document.getElementById('problem').hidden")
    for name in ("grid", "clip", "peak", "false", "use-loupe"):
        page.run(f"document.getElementById('{name}').click()")
    time.sleep(0.2)


def check_quiet(page, address):
    """No console message, and no request to another server."""
    own = address.split("/")[2]
    for event in page.events:
        method, parameters = event.get("method"), event.get("params", {})
        if method == "Log.entryAdded":
            # A warning about the scripts of this test has no address.
            frames = parameters["entry"].get("stackTrace", {}).get("callFrames", [])
            assert frames and not frames[0]["url"], event
        assert method not in ("Runtime.exceptionThrown", "Runtime.consoleAPICalled"), event
        if method == "Network.requestWillBeSent":
            url = parameters["request"]["url"]
            assert url.startswith(("data:", "blob:")) or url.split("/")[2] == own, url


def shoot(page, address, folder):
    os.makedirs(folder, exist_ok=True)
    for width, height in [(1280, 800), (390, 844)]:
        for scheme in ["light", "dark"]:
            page.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1,
                      mobile=width < 600)
            page.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
            page.call("Page.navigate", url=address)
            page.wait("the page", "document.readyState === 'complete' && !!document.getElementById('command')?.value")
            page.wait("samples", "Number(document.documentElement.dataset.samples) >= 8")
            time.sleep(0.5)
            for part, script in [("", ""), ("-drawer", "document.getElementById('open-drawer').click()")]:
                if script:
                    page.run(script)
                    time.sleep(1)
                data = page.call("Page.captureScreenshot", format="png")["data"]
                with open(os.path.join(folder, f"{width}x{height}-{scheme}{part}.png"), "wb") as file:
                    file.write(base64.b64decode(data))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("petzval")
    parser.add_argument("--screens", metavar="FOLDER")
    arguments = parser.parse_args()
    petzval = os.path.abspath(arguments.petzval)
    children = []
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        try:
            copy_scene(folder)
            view, address = start_view(petzval, "scenes/dgauss.pbrt", "--resolution", "240x160", "--spp", "8",
                                       folder=folder)
            children.append(view)
            browser, page = start_browser(folder)
            children.append(browser)
            for domain in ("Page", "Runtime", "Log", "Network"):
                page.call(f"{domain}.enable")
            page.call("Emulation.setDeviceMetricsOverride", width=1280, height=800, deviceScaleFactor=1, mobile=False)
            page.call("Page.navigate", url=address)
            page.wait("the page", "document.readyState === 'complete' && !!window.petzval")
            test(page, folder)
            check_quiet(page, address)
            if arguments.screens:
                atelier, address = start_view(petzval, "scenes/atelier.pbrt")
                children.append(atelier)
                shoot(page, address, arguments.screens)
        finally:
            for child in children:
                child.kill()
                child.wait()
    print("the page works in the browser")


if __name__ == "__main__":
    sys.exit(main())
