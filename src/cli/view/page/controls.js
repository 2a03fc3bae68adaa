// Controls: rings, switches and lists, bound to the settings of the camera.

import { FOCUS_STEPS, SPEEDS, STOPS, TIMES, focusAt, focusStep, metres, nearest, seconds, stops } from "./camera.js";

export const by = (id) => document.getElementById(id);

/** Binds a range to a scale: `write` formats a step, `send` is called with it. */
function ring(id, steps, write, send) {
  const input = by(id);
  if (steps) [input.min, input.max] = [0, steps - 1];
  const say = () => {
    const words = write(Number(input.value));
    by(`${id}-value`).textContent = words;
    input.setAttribute("aria-valuetext", words);
  };
  input.addEventListener("input", () => {
    say();
    send(Number(input.value));
  });
  say();
  return {
    input,
    say,
    // A ring in the hand does not jump.
    show(step) {
      if (document.activeElement !== input || !input.matches(":active")) input.value = step;
      say();
    },
  };
}

export class Controls {
  constructor(link, screen) {
    Object.assign(this, { link, screen, lenses: [], state: null });
    const set = (options) => link.set(options);
    this.rings = {
      stop: ring("stop", STOPS.length, (i) => `f/${STOPS[i]}${this.tNumber(STOPS[i])}`, (i) => set({ fstop: String(STOPS[i]) })),
      time: ring("time", TIMES.length, (i) => `${TIMES[i][1]} s`, (i) => set({ shutter: `time=${TIMES[i][1]}` })),
      iso: ring("iso", SPEEDS.length, (i) => (SPEEDS[i] ? `${SPEEDS[i]}` : "no noise"), (i) => set({ sensor: SPEEDS[i] ? `iso=${SPEEDS[i]}` : null })),
      exposure: ring("exposure", 0, (i) => stops(i / 3), (i) => screen.setExposure(i / 3)),
      focus: ring("focus", FOCUS_STEPS + 1, (i) => metres(focusAt(i)), (i) => {
        const distance = focusAt(i);
        set({ focus: Number.isFinite(distance) ? distance.toPrecision(5) : "inf" });
      }),
      zoom: ring("zoom", 0, (i) => `${i} mm`, (i) => set({ zoom: String(i) })),
    };
    this.pair("tilt-x", "tilt-y", "film-tilt", (i) => i / 2, "\u00b0");
    this.pair("shift-x", "shift-y", "film-shift", (i) => i / 2, " mm");
    this.bindDrawer();
    this.load();
  }

  /** Binds two ranges to an option of two numbers. */
  pair(first, second, option, value, unit) {
    const inputs = [first, second].map(by);
    const send = () => {
      const numbers = inputs.map((input) => value(Number(input.value)));
      this.link.set({ [option]: numbers.some(Boolean) ? numbers.join(",") : null });
    };
    this.rings[first] = ring(first, 0, (i) => `${value(i)}${unit}`, send);
    this.rings[second] = ring(second, 0, (i) => `${value(i)}${unit}`, send);
  }

  tNumber(fNumber) {
    const lens = this.state?.lens;
    if (!lens?.t_number) return "";
    return `  T${((fNumber * lens.t_number) / lens.f_number).toFixed(1)}`;
  }

  async load() {
    this.lenses = await (await fetch("lenses.json")).json();
    if (this.state) this.showLens();
  }

  bindDrawer() {
    const drawer = by("drawer");
    by("open-drawer").addEventListener("click", () => {
      this.fillDrawer();
      drawer.showModal();
    });
    by("close-drawer").addEventListener("click", () => drawer.close());
    drawer.addEventListener("click", (event) => {
      if (event.target === drawer) drawer.close();
    });
  }

  /** The lens on the camera, as the drawer knows it. */
  get lens() {
    const path = this.state?.options.lens;
    return this.lenses.find((lens) => (path ? lens.path === path : lens.scene));
  }

  fillDrawer() {
    const card = (lens) => {
      const [item, button, image, name, facts] = ["li", "button", "img", "b", "span"].map((tag) => document.createElement(tag));
      [image.src, image.alt] = [lens.section, ""];
      name.textContent = lens.name;
      const opening = lens.f_number ? `, f/${lens.f_number.toFixed(1)}` : "";
      facts.textContent = `${lens.focal_length.toFixed(1)} mm${opening} \u00b7 ${lens.file}`;
      button.type = "button";
      button.setAttribute("aria-pressed", String(lens === this.lens));
      button.append(image, name, facts);
      button.addEventListener("click", () => {
        // The stop and the zoom of the old lens may not exist on the new one.
        this.link.set({ lens: lens.scene ? null : lens.path, fstop: null, zoom: null });
        by("drawer").close();
      });
      item.append(button);
      return item;
    };
    by("lenses").replaceChildren(...this.lenses.map(card));
  }

  showLens() {
    const { lens } = this;
    const name = this.state?.lens?.name;
    by("lens-name").textContent = name ?? "No lens of glass";
    by("lens-section").hidden = !lens || !name;
    if (lens && name) by("lens-section").src = lens.section;
    by("open-drawer").disabled = !name;
    const input = this.rings.stop.input;
    input.min = lens?.f_number ? STOPS.findIndex((stop) => stop >= lens.f_number * 0.999) : 0;
    if (this.state?.lens?.f_number) this.rings.stop.show(nearest(STOPS, this.state.lens.f_number));
  }

  /** Shows a state of the camera. */
  show(state) {
    this.state = state;
    const { lens, rings } = { lens: state.lens, rings: this.rings };
    for (const id of ["stop", "focus", "tilt-x", "tilt-y", "shift-x", "shift-y"]) rings[id].input.disabled = !lens;
    if (state.exposure_time) rings.time.show(nearest(TIMES.map(([s]) => s), state.exposure_time));
    rings.iso.show(state.sensor ? nearest(SPEEDS.slice(1), state.iso) + 1 : 0);
    rings.focus.show(focusStep(state.focus ?? Infinity));
    const zoom = lens?.zoom ?? [];
    by("zoom-row").hidden = zoom.length < 2;
    if (zoom.length > 1) {
      const ends = [Math.min(...zoom), Math.max(...zoom)];
      [rings.zoom.input.min, rings.zoom.input.max] = [Math.ceil(ends[0]), Math.floor(ends[1])];
      rings.zoom.show(Math.round(lens.focal_length));
    }
    const numbers = (option) => (state.options[option] ?? "0,0").split(",").map(Number);
    const [tilt, shift] = [numbers("film-tilt"), numbers("film-shift")];
    [rings["tilt-x"], rings["tilt-y"]].forEach((one, i) => one.show(2 * tilt[i]));
    [rings["shift-x"], rings["shift-y"]].forEach((one, i) => one.show(2 * shift[i]));
    this.showLens();
    this.showReadout(state);
    this.showEffects(state);
    by("command").value = state.command;
    by("warnings").replaceChildren(...(state.warnings ?? []).map((warning) => {
      const item = document.createElement("li");
      item.textContent = warning;
      return item;
    }));
  }

  showReadout({ lens, exposure_time: time, exposure_value: ev, iso, focus }) {
    by("r-lens").textContent = lens?.focal_length ? `${lens.focal_length.toFixed(1)} mm` : "no lens";
    const t = lens?.t_number ? `  T${lens.t_number.toFixed(1)}` : "";
    by("r-stop").textContent = lens?.f_number ? `f/${lens.f_number.toFixed(1)}${t}` : "";
    by("r-time").textContent = seconds(time);
    by("r-iso").textContent = iso ? `ISO ${Math.round(iso)}` : "";
    by("r-ev").textContent = ev === null || ev === undefined ? "" : `EV ${ev.toFixed(1)}`;
    by("r-focus").textContent = lens ? `focus ${metres(focus ?? Infinity)}` : "";
  }

  /** Lists the effects of the plan, each with its reason and its price. */
  showEffects({ plan, options }) {
    const given = options.effects ?? "auto";
    const chosen = new Map();
    if (/^[+-]/.test(given)) given.split(",").forEach((word) => chosen.set(word.slice(1), word[0]));
    const row = ({ effect, on, reason, cost }) => {
      const [item, name, choice, why] = ["li", "b", "select", "p"].map((tag) => document.createElement(tag));
      name.textContent = effect.replace("_", " ");
      name.id = `effect-${effect}`;
      choice.setAttribute("aria-labelledby", name.id);
      for (const [value, words] of [["", `auto (${on ? "on" : "off"})`], ["+", "on"], ["-", "off"]]) {
        choice.append(new Option(words, value, false, (chosen.get(effect) ?? "") === value));
      }
      choice.addEventListener("change", () => {
        chosen.delete(effect);
        if (choice.value) chosen.set(effect, choice.value);
        const list = [...chosen].map(([one, sign]) => sign + one).join(",");
        this.link.set({ effects: list || null });
      });
      const price = cost ? ` \u00b7 ${cost.ns_per_ray.toFixed(0)} ns a ray` : "";
      why.textContent = `${on ? "On" : "Off"}: ${reason}${price}`;
      item.append(name, choice, why);
      return item;
    };
    // A list in the hand does not jump.
    if (by("effects").contains(document.activeElement)) document.activeElement.blur();
    by("effects").replaceChildren(...(plan?.effects ?? []).map(row));
  }
}
