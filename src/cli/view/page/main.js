// The page: connects the link to the camera, the screen and the controls.

import { Accuracy } from "./accuracy.js";
import { Bench } from "./bench.js";
import { Controls, by } from "./controls.js";
import { count, draw } from "./histogram.js";
import { Link } from "./link.js";
import { dolly, orbit, text, walk } from "./orbit.js";
import { Save } from "./save.js";
import { Screen } from "./screen.js";

const screen = new Screen(by("picture"), by("overlay"), by("loupe"));
const canvas = by("picture");
let state = null;
// The viewpoint of the hand, ahead of that of the last state.
let view = null;

function complain(words) {
  by("problem").textContent = words ?? "";
  by("problem").hidden = !words;
  requestAnimationFrame(() => screen.draw());
}

function measure() {
  if (!screen.frame) return;
  const counted = count(screen.frame, screen.gain);
  draw(by("histogram"), counted);
  const share = (part) => `${(100 * part).toFixed(part < 0.1 ? 1 : 0)} %`;
  by("clipped").textContent = `white ${share(counted.white)} \u00b7 black ${share(counted.black)} \u00b7 2 stops a line`;
}

const link = new Link({
  connected(yes) {
    complain(yes ? null : "No connection to the camera. Is petzval view still running? The controls come back with it.");
    document.documentElement.dataset.connection = yes ? "live" : "lost";
    controls.enable(yes);
    canvas.tabIndex = yes ? 0 : -1;
    canvas.setAttribute("aria-disabled", String(!yes));
    if (!yes) bench.forget();
  },
  frame(frame) {
    screen.show(frame);
    measure();
    const { samples, target, draft, finished } = frame;
    by("r-samples").textContent = draft ? "draft" : finished ? `${samples} samples, finished` : `${samples} of ${target} samples`;
    by("progress").value = draft ? 0 : samples / target;
    document.documentElement.dataset.generation = String(frame.generation);
    document.documentElement.dataset.samples = String(draft ? 0 : samples);
  },
  blur(map) {
    screen.blur = map;
    if (screen.options.peak) screen.redraw();
  },
  state(received) {
    state = received;
    if (!moving && received.camera) view = received.camera;
    if (received.size) {
      screen.size = received.size;
      controls.show(received);
      bench.show(received);
    }
    complain(received.error);
  },
  saved: (message) => save.saved(message),
  render: (message) => save.show(message),
  accuracy: (message) => accuracy.show(message),
  refused: complain,
});
const controls = new Controls(link, screen);
const bench = new Bench();
const accuracy = new Accuracy(link);
const save = new Save(link, screen);

// Movement: a drag orbits, a click focuses.
let drag = null;
let moving = 0;

function move(next) {
  if (!link.live) return;
  view = next;
  link.set({ "look-at": text(view) });
  clearTimeout(moving);
  moving = setTimeout(() => { moving = 0; }, 800);
}

const place = (event) => {
  const box = canvas.getBoundingClientRect();
  return { x: (event.clientX - box.left) / box.width, y: (event.clientY - box.top) / box.height };
};

canvas.addEventListener("pointerdown", (event) => {
  canvas.setPointerCapture(event.pointerId);
  drag = { x: event.clientX, y: event.clientY, far: false };
});

canvas.addEventListener("pointermove", (event) => {
  screen.cursor = place(event);
  if (screen.options.loupe) screen.draw();
  if (!drag) bench.point(screen.cursor);
  if (!drag || !view) return;
  const step = [event.clientX - drag.x, event.clientY - drag.y];
  if (!drag.far && Math.hypot(...step) < 5) return;
  Object.assign(drag, { x: event.clientX, y: event.clientY, far: true });
  canvas.classList.add("dragging");
  const [right, down] = step.map((n) => (2.5 * n) / canvas.clientHeight);
  move(event.shiftKey ? walk(view, [-right / 3, down / 3, 0]) : orbit(view, right, -down));
});

canvas.addEventListener("pointerup", (event) => {
  if (drag && !drag.far && state?.lens) focusAt(place(event));
  drag = null;
  canvas.classList.remove("dragging");
});

canvas.addEventListener("pointercancel", () => { drag = null; });

canvas.addEventListener("pointerleave", () => {
  screen.cursor = null;
  screen.draw();
});

function focusAt({ x, y }) {
  if (!link.live) return;
  const pixel = [x, y].map((share, i) => {
    const whole = state.resolution[i];
    return Math.max(0, Math.min(whole - 1, Math.floor(share * state.size[i])));
  });
  screen.markFocus(x, y);
  link.set({ focus: `auto@${pixel.join(",")}` });
}

canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  if (view) move(dolly(view, 1.0015 ** Math.max(-200, Math.min(200, event.deltaY))));
}, { passive: false });

const KEYS = {
  ArrowLeft: (v) => orbit(v, 0.05, 0),
  ArrowRight: (v) => orbit(v, -0.05, 0),
  ArrowUp: (v) => orbit(v, 0, 0.05),
  ArrowDown: (v) => orbit(v, 0, -0.05),
  "+": (v) => dolly(v, 0.95),
  "-": (v) => dolly(v, 1.05),
  w: (v) => walk(v, [0, 0, 0.05]),
  s: (v) => walk(v, [0, 0, -0.05]),
  a: (v) => walk(v, [-0.05, 0, 0]),
  d: (v) => walk(v, [0.05, 0, 0]),
  q: (v) => walk(v, [0, -0.05, 0]),
  e: (v) => walk(v, [0, 0.05, 0]),
};

canvas.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.key === "Enter" && state?.lens) focusAt({ x: 0.5, y: 0.5 });
  const key = KEYS[event.key];
  if (!key || !view) return;
  event.preventDefault();
  move(key(view));
});

by("home").addEventListener("click", () => {
  moving = 0;
  link.set({ "look-at": null });
});

// Assistance.
for (const [id, option] of [["grid", "grid"], ["clip", "clip"], ["peak", "peak"], ["false", "false"], ["use-loupe", "loupe"]]) {
  // A browser may keep the boxes of the last visit.
  screen.options[option] = by(id).checked;
  by(id).addEventListener("change", (event) => {
    screen.options[option] = event.target.checked;
    screen.redraw();
  });
}
by("exposure").addEventListener("input", measure);

function setWipe(on) {
  by("compare").setAttribute("aria-pressed", String(on));
  screen.wipe = on ? by("wipe").value / 1000 : null;
  screen.draw();
  for (const id of ["wipe", "wipe-a", "wipe-b"]) by(id).hidden = !on;
  if (!on) return;
  const { left, top, width, height } = screen.box;
  Object.assign(by("wipe").style, { left: `${left}px`, top: `${top + height - by("wipe").offsetHeight - 8}px`, width: `${width}px` });
  Object.assign(by("wipe-a").style, { left: `${left + 8}px`, top: `${top + 8}px` });
  Object.assign(by("wipe-b").style, { left: `${left + width - 36}px`, top: `${top + 8}px` });
}

by("keep").addEventListener("click", () => {
  screen.keep();
  by("compare").disabled = false;
  setWipe(true);
});
by("compare").addEventListener("click", () => setWipe(screen.wipe === null));
by("wipe").addEventListener("input", () => setWipe(true));
document.addEventListener("keydown", (event) => {
  if (event.key === "Escape" && screen.wipe !== null && !by("drawer").open) setWipe(false);
});

new ResizeObserver(() => {
  screen.draw();
  if (screen.wipe !== null) setWipe(true);
}).observe(by("stage"));

// For tests and for the curious.
window.petzval = { link, screen, accuracy, get frame() { return screen.frame; }, get state() { return state; } };
