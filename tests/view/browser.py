#!/usr/bin/env python3
"""Tests the page of `petzval view` in Chromium, by the DevTools protocol. Needs Python's library alone.

    python3 tests/view/browser.py target/release/petzval [--screens FOLDER]

It checks that the page loads and refines, that a click changes the focus and a ring the exposure, that the wipe
shows two pictures, that the keyboard moves the camera, that the console stays empty, and that no request leaves the
machine. With --screens it writes screenshots in two sizes, light and dark.
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


def start_view(petzval, scene, *options):
    command = [petzval, "view", scene, "--no-open", *options]
    child = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
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


def test(page):
    page.wait("the finished picture", FINISHED)
    assert page.run(MEAN) > 5, "the picture is black"
    page.wait("the command", "document.getElementById('command').value.startsWith('petzval render')")

    # A click focuses.
    left, top, width, height = box(page, "picture")
    first, focus = page.run(PRINT), page.run("document.getElementById('r-focus').textContent")
    finished_after(page, lambda: page.drag([(left + width * 0.2, top + height * 0.75)]))
    assert page.run(PRINT) != first, "the click has changed nothing"
    assert "auto@" in page.run("document.getElementById('command').value")
    assert page.run("document.getElementById('r-focus').textContent") != focus

    # Rings change the exposure: the shutter halves the light, and so does the display's own ring.
    finished_after(page, lambda: set_range(page, "stop", 18))
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
    page.wait("the lenses", "document.querySelectorAll('#lenses img').length > 3")
    page.press("Escape", 27)
    page.wait("the drawer to close", "!document.getElementById('drawer').open")
    name = page.run("document.getElementById('lens-name').textContent")
    page.run("document.getElementById('open-drawer').click()")
    finished_after(page, lambda: page.run("document.querySelector('#lenses button[aria-pressed=false]').click()"))
    page.wait("the name of the lens", f"document.getElementById('lens-name').textContent !== {json.dumps(name)}")

    # A value that the lens refuses is said, and the page goes on.
    page.run("window.petzval.link.set({ fstop: '0.3' })")
    page.wait("the error", "document.getElementById('problem').textContent.includes('--fstop 0.3')")
    finished_after(page, lambda: page.run("window.petzval.link.set({ fstop: null })"))
    assert page.run("document.getElementById('problem').hidden")
    for name in ("grid", "peak", "false", "use-loupe"):
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
            view, address = start_view(petzval, "scenes/dgauss.pbrt", "--resolution", "240x160", "--spp", "8")
            children.append(view)
            browser, page = start_browser(folder)
            children.append(browser)
            for domain in ("Page", "Runtime", "Log", "Network"):
                page.call(f"{domain}.enable")
            page.call("Emulation.setDeviceMetricsOverride", width=1280, height=800, deviceScaleFactor=1, mobile=False)
            page.call("Page.navigate", url=address)
            page.wait("the page", "document.readyState === 'complete' && !!window.petzval")
            test(page)
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
