// Lens bench: the rays and the image of the place under the cursor.

import { showDrawing } from "./drawing.js";

const by = (id) => document.getElementById(id);

// Time that the cursor rests before the image is computed, which takes longer than the rays (ms).
const REST = 200;

/** A dot in the colour of rays in the section. */
const dot = (colour) =>
  `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 10 10"><circle cx="5" cy="5" r="5" fill="${colour}"/></svg>`;

const RIM = "the rim of surface ";

/** Takes the rims of all surfaces together, the one with the most rays first. */
function inGroups(fates) {
  const rims = fates.filter(({ words }) => words.startsWith(RIM)).sort((a, b) => b.share - a.share);
  const others = fates.filter((fate) => !rims.includes(fate)).reverse();
  if (rims.length < 2) return [...others, ...rims];
  const names = rims.map(({ words }) => words.slice(RIM.length));
  const share = rims.reduce((sum, rim) => sum + rim.share, 0);
  return [...others, { words: `the rims of surfaces ${names.join(", ")}`, colour: rims[0].colour, share }];
}

export class Bench {
  constructor() {
    this.place = [0.5, 0.5];
    this.lens = false;
    // What is asked for, by kind: one request at a time, then the latest place.
    this.wanted = {};
    this.busy = {};
    by("bench").addEventListener("toggle", () => this.renew());
  }

  /** Shows another place, in shares of the picture. */
  point({ x, y }) {
    const place = [x, y].map((share) => +Math.max(0, Math.min(1, share)).toFixed(3));
    if (place.join() === this.place.join()) return;
    this.place = place;
    this.renew();
  }

  /** Shows the place again, after the lens has changed. The draft and the picture of a generation have the same. */
  show({ lens, generation }) {
    if (generation === this.generation && Boolean(lens) === this.lens) return;
    Object.assign(this, { lens: Boolean(lens), generation });
    this.renew();
  }

  /** Takes the next lens for another one. */
  forget() {
    this.generation = null;
  }

  renew() {
    clearTimeout(this.timer);
    for (const id of ["lens-section", "rays-words", "rays-fates", "bench"]) by(id).hidden = !this.lens;
    if (!this.lens) return;
    this.ask("rays", (answer) => this.showRays(answer));
    if (!by("bench").open) return;
    this.timer = setTimeout(() => this.ask("image", (answer) => this.showImage(answer)), REST);
  }

  async ask(kind, show) {
    this.wanted[kind] = true;
    if (this.busy[kind]) return;
    this.busy[kind] = true;
    while (this.wanted[kind]) {
      this.wanted[kind] = false;
      try {
        const reply = await fetch(`${kind}/${this.place.join(",")}.json`);
        if (reply.ok) show(await reply.json());
      } catch {
        // The link says that the camera is gone.
      }
    }
    this.busy[kind] = false;
  }

  showRays({ section, height, fates, limits }) {
    const [below, above] = limits ?? [null, null];
    const bounds = below === above ? `Limited by ${below ?? "the rear element"}.`
      : `Limited by ${below ?? "the rear element"} below and ${above ?? "the rear element"} above.`;
    const words = limits ? bounds : "No light reaches this place.";
    by("rays-words").textContent = `${height.toFixed(1)} mm from the axis. ${words}`;
    showDrawing(by("lens-section"), section, `Section of the lens with rays. ${words}`);
    by("rays-fates").replaceChildren(...inGroups(fates).map(({ words: fate, colour, share }) => {
      const [item, swatch] = ["li", "span"].map((tag) => document.createElement(tag));
      showDrawing(swatch, dot(colour), "");
      const percent = share < 0.1 ? (100 * share).toFixed(1) : Math.round(100 * share);
      item.append(swatch, `${percent} % ${fate === "pass" ? "pass" : `end at ${fate}`}`);
      return item;
    }));
    document.documentElement.dataset.rays = this.place.join();
  }

  showImage({ problem, rms, spot, transfer }) {
    by("bench-image").textContent = problem ?? `Spot ${rms.toFixed(rms < 10 ? 2 : 1)} \u00b5m (root mean square)`;
    for (const [id, svg, words] of [["bench-spot", spot, "Spot diagram"], ["bench-transfer", transfer, "Modulation transfer"]]) {
      by(id).hidden = !svg;
      if (svg) showDrawing(by(id), svg, words);
    }
    document.documentElement.dataset.image = this.place.join();
  }
}
