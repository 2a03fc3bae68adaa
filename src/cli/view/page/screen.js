// Screen: turns linear light into the picture on the display, with its warnings and overlays.

// The upper 16 bits of a float choose its value on the display: 128 steps in each octave.
const CODES = 1 << 16;
const BITS = new Uint32Array(1);
const FLOAT = new Float32Array(BITS.buffer);

function table(gain) {
  const codes = new Uint8ClampedArray(CODES);
  for (let i = 0; i < CODES / 2; i++) {
    BITS[0] = (i << 16) | 0x8000;
    const v = Math.max(0, Math.min(1, FLOAT[0] * gain || 0));
    codes[i] = Math.round(255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));
  }
  return codes;
}

// False colours by stops from middle grey (18 %), as on cine cameras.
const BANDS = [
  [-6, [92, 28, 120]], [-4.5, [30, 60, 200]], [-3, [20, 130, 200]], [-2, [60, 100, 110]],
  [-0.4, [110, 110, 110]], [0.4, [60, 180, 75]], [0.8, [150, 150, 150]], [1.3, [240, 150, 170]],
  [2, [200, 200, 200]], [2.47, [250, 225, 60]], [Infinity, [235, 40, 40]],
];

const luminance = (light, i) => 0.2126 * light[i] + 0.7152 * light[i + 1] + 0.0722 * light[i + 2];

export class Screen {
  constructor(picture, overlay, loupe) {
    Object.assign(this, { picture, overlay, loupe });
    this.exposure = 0;
    this.options = { clip: false, false: false, peak: false, grid: false, loupe: false };
    this.frame = null;
    this.blur = null;
    this.kept = null;
    this.wipe = null;
    this.cursor = null;
    this.source = document.createElement("canvas");
    this.keptSource = document.createElement("canvas");
    this.codes = table(1);
  }

  get gain() {
    return 2 ** this.exposure;
  }

  setExposure(stops) {
    this.exposure = stops;
    this.codes = table(this.gain);
    if (this.kept) this.develop(this.kept, this.keptSource);
    this.redraw();
  }

  show(frame) {
    this.frame = frame;
    this.redraw();
  }

  redraw() {
    if (!this.frame) return;
    this.develop(this.frame, this.source);
    this.draw();
  }

  /** Keeps the picture as A. */
  keep() {
    this.kept = this.frame;
    this.develop(this.kept, this.keptSource);
  }

  /** Writes a frame into a canvas of its size. */
  develop(frame, canvas) {
    const { width, height, light } = frame;
    canvas.width = width;
    canvas.height = height;
    const context = canvas.getContext("2d");
    const image = context.createImageData(width, height);
    const { data } = image;
    const bits = new Uint16Array(light.buffer, light.byteOffset, 2 * light.length);
    const { codes, options, gain } = this;
    for (let i = 0, to = 0; i < light.length; i += 3, to += 4) {
      data[to] = codes[bits[2 * i + 1]];
      data[to + 1] = codes[bits[2 * i + 3]];
      data[to + 2] = codes[bits[2 * i + 5]];
      data[to + 3] = 255;
    }
    if (options.false) this.paintBands(light, data, gain);
    else if (options.clip) this.paintClipping(light, data, width, gain);
    if (options.peak) this.paintFocus(data, width, height);
    context.putImageData(image, 0, 0);
  }

  paintBands(light, data, gain) {
    for (let i = 0, to = 0; i < light.length; i += 3, to += 4) {
      const stop = Math.log2(Math.max(luminance(light, i) * gain, 1e-9) / 0.18);
      const [, colour] = BANDS.find(([most]) => stop <= most);
      [data[to], data[to + 1], data[to + 2]] = colour;
    }
  }

  /** Hatches pixels whose channels are all above white, in red. */
  paintClipping(light, data, width, gain) {
    const white = 1 / gain;
    for (let i = 0, to = 0, pixel = 0; i < light.length; i += 3, to += 4, pixel++) {
      if (light[i] < white || light[i + 1] < white || light[i + 2] < white) continue;
      const [x, y] = [pixel % width, Math.floor(pixel / width)];
      if ((x + y) % 8 < 3) [data[to], data[to + 1], data[to + 2]] = [230, 30, 30];
    }
  }

  /** Paints surfaces green whose circle of confusion is below two pixels, fully below one. */
  paintFocus(data, width, height) {
    const { blur } = this;
    if (!blur) return;
    for (let y = 0, to = 0; y < height; y++) {
      const row = Math.floor((y * blur.height) / height) * blur.width;
      for (let x = 0; x < width; x++, to += 4) {
        const diameter = blur.diameters[row + Math.floor((x * blur.width) / width)];
        if (!(diameter > 0 && diameter < 2)) continue;
        const share = 0.6 * Math.min(1, 2 - diameter);
        data[to] += share * (20 - data[to]);
        data[to + 1] += share * (255 - data[to + 1]);
        data[to + 2] += share * (90 - data[to + 2]);
      }
    }
  }

  /** Fits the canvases into the stage, and draws what is developed. */
  draw() {
    if (!this.frame) return;
    const stage = this.picture.parentElement.getBoundingClientRect();
    const shape = this.size ?? [this.frame.width, this.frame.height];
    const scale = Math.min(stage.width / shape[0], stage.height / shape[1]);
    const box = shape.map((n) => Math.max(1, Math.floor(n * scale)));
    const corner = [(stage.width - box[0]) / 2, (stage.height - box[1]) / 2].map(Math.floor);
    const dense = window.devicePixelRatio || 1;
    for (const canvas of [this.picture, this.overlay]) {
      const size = box.map((n) => Math.round(n * dense));
      if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
      Object.assign(canvas.style, {
        left: `${corner[0]}px`, top: `${corner[1]}px`, width: `${box[0]}px`, height: `${box[1]}px`,
      });
    }
    this.box = { left: corner[0], top: corner[1], width: box[0], height: box[1] };
    const context = this.picture.getContext("2d");
    context.imageSmoothingQuality = "high";
    const { width, height } = this.picture;
    context.drawImage(this.source, 0, 0, width, height);
    if (this.wipe !== null && this.kept) {
      const border = Math.round(this.wipe * width);
      context.save();
      context.beginPath();
      context.rect(0, 0, border, height);
      context.clip();
      context.drawImage(this.keptSource, 0, 0, width, height);
      context.restore();
      context.fillStyle = "#fff";
      context.fillRect(border - 1, 0, 2, height);
    }
    this.drawOverlay(dense);
  }

  drawOverlay(dense) {
    const context = this.overlay.getContext("2d");
    const { width, height } = this.overlay;
    context.clearRect(0, 0, width, height);
    if (this.options.grid) {
      for (const [colour, thick] of [["#0008", 3 * dense], ["#fffc", dense]]) {
        context.fillStyle = colour;
        for (const third of [1 / 3, 2 / 3]) {
          context.fillRect(Math.round(width * third - thick / 2), 0, thick, height);
          context.fillRect(0, Math.round(height * third - thick / 2), width, thick);
        }
      }
    }
    if (this.mark && performance.now() - this.mark.since < 1200) {
      const [x, y, r] = [this.mark.x * width, this.mark.y * height, 14 * dense];
      context.lineWidth = 2 * dense;
      for (const [colour, grow] of [["#000a", dense], ["#ff9a4d", 0]]) {
        context.strokeStyle = colour;
        context.strokeRect(x - r - grow, y - r - grow, 2 * (r + grow), 2 * (r + grow));
      }
    }
    this.drawLoupe(dense);
  }

  /** Shows the pixels under the cursor one to one. */
  drawLoupe(dense) {
    const { loupe, cursor, box } = this;
    loupe.hidden = !this.options.loupe || !cursor;
    if (loupe.hidden) return;
    const side = 180;
    [loupe.width, loupe.height] = [side * dense, side * dense];
    const left = Math.max(0, Math.min(box.width - side, cursor.x * box.width - side / 2));
    // Above the cursor, or below where there is no room.
    const middle = cursor.y * box.height;
    const top = middle > side + 24 ? middle - side - 24 : middle + 24;
    Object.assign(loupe.style, {
      left: `${box.left + left}px`, top: `${box.top + top}px`, width: `${side}px`, height: `${side}px`,
    });
    const context = loupe.getContext("2d");
    context.imageSmoothingEnabled = false;
    const from = [cursor.x * this.source.width, cursor.y * this.source.height];
    context.drawImage(this.source, side * dense / 2 - from[0], side * dense / 2 - from[1]);
  }

  /** Marks the place of a click, in shares of the picture. */
  markFocus(x, y) {
    this.mark = { x, y, since: performance.now() };
    this.draw();
    setTimeout(() => this.draw(), 1250);
  }

  /** Returns the picture as a PNG file, as it is seen, without overlays. */
  png() {
    return new Promise((done) => this.source.toBlob(done, "image/png"));
  }
}
