// Accuracy: error against time of the camera models, drawn while it is measured.

import { by } from "./controls.js";

// Colours that colour-blind readers can tell apart (Okabe & Ito 2008).
const COLOURS = ["#d55e00", "#e69f00", "#cc79a7", "#009e73", "#56b4e9", "#0072b2", "#8c8c8c"];
const AREA = { left: 46, top: 10, right: 10, bottom: 34 };

/** Powers of ten, and 2 and 5 times them, between two numbers. */
function ticks([low, high]) {
  const found = [];
  for (let power = Math.floor(Math.log10(low)); 10 ** power <= high; power++) {
    for (const digit of [1, 2, 5]) {
      const value = digit * 10 ** power;
      if (value >= low && value <= high) found.push(+value.toPrecision(1));
    }
  }
  return found.length > 7 ? found.filter((value) => String(value).replace(/[0.]/g, "").startsWith("1")) : found;
}

/** Returns a range around numbers above zero. */
function range(values) {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  return [low / 1.4, high * 1.4];
}

export class Accuracy {
  constructor(link) {
    this.link = link;
    this.last = null;
    by("measure").addEventListener("click", () => {
      if (this.running) link.send({ type: "cancel" });
      else link.send({ type: "accuracy", budget: Number(by("budget").value) });
    });
    by("accuracy").addEventListener("toggle", () => this.draw());
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.last && this.list(this.last));
  }

  show(message) {
    const { status, activity, seconds, budget, models, recommendation, partial, problem } = message;
    this.running = status === "running";
    by("measure").textContent = this.running ? "Cancel" : "Measure";
    by("measured").textContent = {
      running: `${Math.min(Math.round(seconds), budget)} of ${budget} s: ${activity}`,
      finished: recommendation ?? partial ?? "Measured.",
      cancelled: partial ?? "Cancelled.",
      failed: problem,
    }[status];
    if (!models) return;
    document.documentElement.dataset.points = String(message.points.length);
    this.list(message);
  }

  /** Lists the models, in the colours of the plot, and draws it. A model that has no point there is named so. */
  list(message) {
    this.last = message;
    const { models, points, verdicts, status } = message;
    const words = new Map((verdicts ?? []).map(({ model, sentence }) => [model, `: ${sentence}`]));
    by("models").replaceChildren(...models.map((name, i) => {
      const [item, swatch, title] = ["li", "i", "b"].map((tag) => document.createElement(tag));
      const measured = points.some(({ model }) => model === i);
      item.classList.toggle("unmeasured", !measured);
      if (measured) {
        swatch.style.borderColor = this.colour(i);
        if (!this.repeats(i)) swatch.style.background = this.colour(i);
      }
      title.textContent = name;
      const missing = status === "running" ? ": not measured yet" : ": not measured";
      item.append(swatch, title, measured ? words.get(i) ?? "" : missing);
      return item;
    }));
    this.draw();
  }

  /** The richest model has the colour of the text. */
  colour(model) {
    return model === this.last.models.length - 1 ? getComputedStyle(by("accuracy")).color : COLOURS[model % COLOURS.length];
  }

  /** Models that repeat a colour have dashes. */
  repeats(model) {
    return model >= COLOURS.length && model !== this.last.models.length - 1;
  }

  draw() {
    const canvas = by("accuracy-plot");
    const points = (this.last?.points ?? []).filter(({ seconds, error }) => seconds > 0 && error > 0);
    canvas.hidden = points.length === 0;
    if (!points.length || !by("accuracy").open) return;
    const dense = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    [canvas.width, canvas.height] = [width * dense, height * dense];
    const context = canvas.getContext("2d");
    context.scale(dense, dense);
    const style = getComputedStyle(by("accuracy"));
    context.font = `11px ${style.fontFamily}`;
    const axes = ["seconds", "error"].map((name) => range(points.map((point) => point[name])));
    const share = (value, [low, high]) => Math.log(value / low) / Math.log(high / low);
    const x = (seconds) => AREA.left + share(seconds, axes[0]) * (width - AREA.left - AREA.right);
    const y = (error) => height - AREA.bottom - share(error, axes[1]) * (height - AREA.top - AREA.bottom);
    context.fillStyle = context.strokeStyle = style.color;
    context.lineWidth = 1;
    context.globalAlpha = 0.7;
    context.textAlign = "center";
    for (const value of ticks(axes[0])) context.fillText(value, x(value), height - AREA.bottom + 14);
    context.fillText("time (s)", (AREA.left + width) / 2, height - 4);
    context.textAlign = "right";
    for (const value of ticks(axes[1])) context.fillText(`${value} %`, AREA.left - 4, y(value) + 4);
    context.globalAlpha = 0.18;
    for (const value of ticks(axes[0])) context.fillRect(x(value), AREA.top, 1, height - AREA.top - AREA.bottom);
    for (const value of ticks(axes[1])) context.fillRect(AREA.left, y(value), width - AREA.left - AREA.right, 1);
    context.globalAlpha = 1;
    this.last.models.forEach((_, model) => {
      const own = points.filter((point) => point.model === model).sort((a, b) => a.samples - b.samples);
      context.strokeStyle = context.fillStyle = this.colour(model);
      context.lineWidth = 1.5;
      context.setLineDash(this.repeats(model) ? [5, 3] : []);
      context.beginPath();
      own.forEach(({ seconds, error }) => context.lineTo(x(seconds), y(error)));
      context.stroke();
      for (const { seconds, error, best } of own) {
        context.beginPath();
        context.arc(x(seconds), y(error), best ? 4 : 2.5, 0, 7);
        context.fill();
      }
    });
  }
}
