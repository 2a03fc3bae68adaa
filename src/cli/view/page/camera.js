// Scales of a camera, and how their values are written.

// f-numbers in thirds of a stop, as engraved.
const STOPS = [
  1, 1.1, 1.2, 1.4, 1.6, 1.8, 2, 2.2, 2.5, 2.8, 3.2, 3.5, 4, 4.5, 5, 5.6, 6.3, 7.1, 8, 9, 10, 11,
  13, 14, 16, 18, 20, 22, 25, 29, 32,
];

// Engraved f-numbers so close to the widest are left out.
const NEXT = 1.03;

/** The f-numbers of an aperture ring, from the widest of the lens on. */
export function stopsFrom(widest) {
  return widest ? [widest, ...STOPS.filter((stop) => stop > widest * NEXT)] : STOPS;
}

// Exposure times (s) in whole stops, from the shortest.
export const TIMES = [
  ...[8000, 4000, 2000, 1000, 500, 250, 125, 60, 30, 15, 8, 4, 2].map((n) => [1 / n, `1/${n}`]),
  ...[1, 2, 4, 8, 15, 30, 60].map((n) => [n, `${n}`]),
];

// Films by their diagonals (mm).
export const FILMS = [
  ["phone 1/1.3\u2033", 12.3], ["1\u2033", 15.9], ["Four Thirds", 21.6], ["APS-C", 28.2], ["Super 35", 31.1],
  ["full frame", 43.27], ["44 \u00d7 33", 54.8], ["645", 69.7], ["6 \u00d7 7", 89.8], ["4 \u00d7 5 inch", 153.7],
];

// Sensitivities; the first is a film without noise.
export const SPEEDS = [0, 50, 100, 200, 400, 800, 1600, 3200, 6400, 12800, 25600];

/** Distances in focus (m): logarithmic, infinity last. */
export const FOCUS_STEPS = 200;

export function focusAt(step) {
  return step >= FOCUS_STEPS ? Infinity : 0.1 * 1000 ** (step / FOCUS_STEPS);
}

export function focusStep(metres) {
  if (!(metres < 100)) return FOCUS_STEPS;
  return Math.max(0, Math.min(FOCUS_STEPS - 1, Math.round((FOCUS_STEPS * Math.log10(metres / 0.1)) / 3)));
}

/** The nearest index of a list of numbers, by ratio. */
export function nearest(list, value) {
  let best = 0;
  list.forEach((one, i) => {
    if (Math.abs(Math.log(one / value)) < Math.abs(Math.log(list[best] / value))) best = i;
  });
  return best;
}

export function metres(value) {
  if (value === null || value === undefined) return "";
  if (!Number.isFinite(value) || value > 1e4) return "\u221e";
  return `${value.toFixed(value < 1 ? 3 : value < 10 ? 2 : 1)} m`;
}

/** A time, as a fraction where it is one. */
export function seconds(value) {
  if (!value) return "";
  const part = Math.round(1 / value);
  if (part > 2 && Math.abs(part * value - 1) < 0.005) return `1/${part} s`;
  return `${+value.toPrecision(3)} s`;
}

export function fNumber(value) {
  return value ? `f/${value < 10 ? value.toFixed(1) : +value.toFixed(1)}` : "";
}

export function tNumber(value) {
  return value ? `T${value.toFixed(1)}` : "";
}

/** A stop with the light that the lens passes. */
export function aperture(fStop, tStop) {
  return [fNumber(fStop), tNumber(tStop)].filter(Boolean).join("  ");
}

export function speed(iso) {
  return iso ? `ISO ${Math.round(iso)}` : "";
}

export function millimetres(value) {
  return value ? `${value.toFixed(1)} mm` : "";
}

export function stops(value) {
  const text = Math.abs(value) < 0.005 ? "0" : value.toFixed(1);
  return `${value > 0 ? "+" : ""}${text} EV`;
}
