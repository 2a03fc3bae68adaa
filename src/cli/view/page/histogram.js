// Histogram of the picture in stops, by channel, and the shares that are clipped.

const BINS = 128;
// The brightest bin is this many stops above white, the darkest this many below.
const ABOVE = 2;
const BELOW = 10;
const COLOURS = ["#ff5a5a", "#4fd36b", "#6d8dff"];

/** Counts a frame. `gain` is the brightness of the display. */
export function count(frame, gain) {
  const { light, width, height } = frame;
  const bins = COLOURS.map(() => new Float32Array(BINS));
  const pixels = width * height;
  const stride = Math.max(1, Math.floor(pixels / 120000));
  let [white, black, seen] = [0, 0, 0];
  for (let i = 0; i < pixels; i += stride, seen++) {
    let highest = 0;
    for (let c = 0; c < 3; c++) {
      const value = light[3 * i + c] * gain;
      highest = Math.max(highest, value);
      const bin = Math.floor(((Math.log2(Math.max(value, 1e-9)) + BELOW) / (ABOVE + BELOW)) * BINS);
      bins[c][Math.max(0, Math.min(BINS - 1, bin))]++;
    }
    if (highest >= 1) white++;
    if (highest <= 1 / 1024) black++;
  }
  return { bins, white: white / seen, black: black / seen };
}

export function draw(canvas, { bins }) {
  const context = canvas.getContext("2d");
  const { width, height } = canvas;
  context.clearRect(0, 0, width, height);
  const at = (stop) => ((stop + BELOW) / (ABOVE + BELOW)) * width;
  context.fillStyle = "#ffffff22";
  for (let stop = -BELOW; stop <= ABOVE; stop += 2) context.fillRect(at(stop), 0, 1, height);
  context.fillStyle = "#ff9a4d";
  context.fillRect(at(0) - 1, 0, 2, height);
  const inner = bins.map((bin) => bin.slice(1, -1));
  const highest = Math.max(1, ...inner.map((bin) => Math.max(...bin)));
  context.globalCompositeOperation = "lighter";
  bins.forEach((bin, c) => {
    context.fillStyle = COLOURS[c];
    context.globalAlpha = 0.75;
    bin.forEach((n, i) => {
      const high = Math.min(1, Math.sqrt(n / highest)) * (height - 4);
      context.fillRect((i * width) / BINS, height - high, width / BINS + 0.5, high);
    });
  });
  context.globalAlpha = 1;
  context.globalCompositeOperation = "source-over";
}
