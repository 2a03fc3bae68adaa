#!/usr/bin/env python3
"""Measures how fast `petzval view` follows its user: atelier at 1280 x 853. Needs Python's library alone.

    python3 benches/view.py target/release/petzval

It prints the median and the slowest time to the first frame of a page that opens, from a change of a setting to the
first new frame, both while the picture is refined, and from a change to the picture in full resolution; and the
frames a second while the camera orbits.
"""

import argparse
import json
import math
import os
import statistics
import struct
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "tests", "view"))
from websocket import BINARY, WebSocket  # noqa: E402

CHANGES = 12
ORBIT_SECONDS = 6


class Page:
    def __init__(self, address):
        self.socket = WebSocket(address.replace("http:", "ws:") + "socket", 120)
        self.state = None
        self.next()

    def send(self, message):
        self.socket.send(json.dumps(message).encode())

    def next(self):
        self.send({"type": "next"})

    def message(self):
        kind, data = self.socket.receive()
        if kind != BINARY:
            return json.loads(data)
        if data[:4] != b"PZV1":
            return {"type": "blur"}
        width, height, samples, _, flags, generation = struct.unpack_from("<IIIIIQ", data, 4)
        self.next()
        return {"type": "frame", "size": (width, height), "samples": samples, "draft": flags & 1, "generation": generation}

    def until(self, found):
        while not found(message := self.message()):
            pass
        return message

    def set(self, **options):
        """Sets options. Returns the time to the first frame that shows them (s), and the frame."""
        start, generation = time.perf_counter(), None
        self.send({"type": "set", "options": options})
        while True:
            message = self.message()
            if message["type"] == "set":
                generation = message["generation"]
            if message["type"] == "frame" and generation and message["generation"] == generation:
                return time.perf_counter() - start, message


def say(name, times):
    times = [1e3 * t for t in times]
    print(f"{name:<44}{statistics.median(times):>8.0f} ms median, {max(times):>6.0f} ms slowest of {len(times)}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("petzval")
    parser.add_argument("--scene", default="scenes/atelier.pbrt")
    parser.add_argument("--resolution", default="1280x853")
    arguments = parser.parse_args()
    command = [arguments.petzval, "view", arguments.scene, "--no-open", "--resolution", arguments.resolution]
    view = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        address = view.stdout.readline().strip()
        page = Page(address)
        page.until(lambda message: message["type"] == "frame" and not message["draft"])
        opened = []
        for _ in range(CHANGES):
            start = time.perf_counter()
            other = Page(address)
            other.until(lambda message: message["type"] == "frame")
            opened.append(time.perf_counter() - start)
        say("page to its first frame", opened)
        first, full, draft = [], [], None
        for i in range(CHANGES):
            taken, frame = page.set(fstop=["4", "5.6"][i % 2])
            first.append(taken)
            draft = draft or frame["size"]
            start = time.perf_counter()
            page.until(lambda message: message["type"] == "frame" and not message["draft"])
            full.append(taken + time.perf_counter() - start)
        say(f"change to its first frame ({draft[0]} x {draft[1]})", first)
        say(f"change to the picture in {arguments.resolution}", full)
        page.send({"type": "set", "options": {"fstop": None}})
        state = page.until(lambda message: message["type"] == "state")
        eye, target, up = (state["camera"][key] for key in ("eye", "target", "up"))
        start, frames, sizes = time.perf_counter(), [], []
        while time.perf_counter() - start < ORBIT_SECONDS:
            angle = 0.01 * len(frames)
            x, z = eye[0] - target[0], eye[2] - target[2]
            turned = [target[0] + x * math.cos(angle) - z * math.sin(angle), eye[1],
                      target[2] + x * math.sin(angle) + z * math.cos(angle)]
            taken, frame = page.set(**{"look-at": ",".join(f"{v:.6g}" for v in turned + target + up)})
            frames.append(taken)
            sizes.append(frame["size"])
        say("orbit, step to its frame", frames)
        print(f"{'orbit, frames a second':<44}{len(frames) / (time.perf_counter() - start):>8.1f}, "
              f"from {min(sizes)} to {max(sizes)} pixels")
    finally:
        view.kill()
        view.wait()


if __name__ == "__main__":
    sys.exit(main())
