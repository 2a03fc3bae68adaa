// Movements of the camera. A viewpoint has an eye, a target and the direction up, in the scene's world.

const add = (a, b) => a.map((v, i) => v + b[i]);
const sub = (a, b) => a.map((v, i) => v - b[i]);
const scale = (a, s) => a.map((v) => v * s);
const dot = (a, b) => a.reduce((sum, v, i) => sum + v * b[i], 0);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => scale(a, 1 / Math.hypot(...a));

/** Rotates a vector about a unit axis (Rodrigues). */
function turn(v, axis, angle) {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return add(add(scale(v, c), scale(cross(axis, v), s)), scale(axis, dot(axis, v) * (1 - c)));
}

// Nearest that the axis comes to the vertical (radians).
const POLE = 0.05;

/** Turns the camera around its target. */
export function orbit({ eye, target, up }, right, down) {
  const arm = turn(sub(eye, target), up, right);
  const side = unit(cross(up, arm));
  const height = Math.acos(Math.max(-1, Math.min(1, dot(unit(arm), up))));
  const angle = Math.max(POLE, Math.min(Math.PI - POLE, height - down)) - height;
  return { eye: add(target, turn(arm, side, angle)), target, up };
}

/** Moves the camera towards its target, by a factor of the distance. */
export function dolly({ eye, target, up }, factor) {
  return { eye: add(target, scale(sub(eye, target), factor)), target, up };
}

/** Moves camera and target, in shares of their distance: right, up, forward. */
export function walk({ eye, target, up }, [right, rise, ahead]) {
  const way = sub(target, eye);
  const distance = Math.hypot(...way);
  const forward = unit(way);
  const side = unit(cross(up, forward));
  const step = add(add(scale(side, right * distance), scale(up, rise * distance)), scale(forward, ahead * distance));
  return { eye: add(eye, step), target: add(target, step), up };
}

export function text({ eye, target, up }) {
  return [...eye, ...target, ...up].map((v) => String(+v.toPrecision(9))).join(",");
}
