// Controls: rings, switches and lists, bound to the settings of the camera.

import {
  FILMS, FOCUS_STEPS, SPEEDS, TIMES, aperture, focusAt, focusStep, metres, millimetres, nearest, seconds, speed, stops,
  stopsFrom,
} from "./camera.js";
import { showWhenSeen } from "./drawing.js";

export const by = (id) => document.getElementById(id);

/** Binds a range to a scale: `write` formats a step, `send` is called with it. */
function ring(id, steps, write, send) {
  const input = by(id);
  const turn = (count) => { [input.min, input.max] = [0, count - 1]; };
  if (steps) turn(steps);
  const say = (words) => {
    by(`${id}-value`).textContent = words;
    input.setAttribute("aria-valuetext", words);
  };
  input.addEventListener("input", () => {
    say(write(Number(input.value)));
    send(Number(input.value));
  });
  return {
    input,
    turn,
    /** Turns to the nearest step, and says the value itself. A ring in the hand does not jump. */
    show(step, words) {
      if (document.activeElement === input && input.matches(":active")) return;
      input.value = step;
      say(words);
    },
  };
}

/** Steps of the zoom ring: about one a millimetre, with both ends. */
const zoomSteps = ([low, high]) => Math.max(1, Math.ceil(high - low));

export class Controls {
  constructor(link, screen) {
    Object.assign(this, { link, screen, lenses: [], state: null, scale: stopsFrom(null), zoom: [0, 1], own: {} });
    const set = (options) => link.set(options);
    this.rings = {
      stop: ring("stop", 0, (i) => this.aperture(this.scale[i]), (i) => set({ fstop: this.option(i) })),
      time: ring("time", TIMES.length, (i) => seconds(TIMES[i][0]), (i) => set({ shutter: `time=${TIMES[i][1]}` })),
      iso: ring("iso", SPEEDS.length, (i) => speed(SPEEDS[i]) || "no noise", (i) => set({ sensor: SPEEDS[i] ? `iso=${SPEEDS[i]}` : null })),
      exposure: ring("exposure", 0, (i) => stops(i / 3), (i) => screen.setExposure(i / 3)),
      focus: ring("focus", FOCUS_STEPS + 1, (i) => metres(focusAt(i)), (i) => {
        const distance = focusAt(i);
        set({ focus: Number.isFinite(distance) ? distance.toPrecision(5) : "inf" });
      }),
      zoom: ring("zoom", 0, (i) => millimetres(this.zoomAt(i)), (i) => set({ zoom: String(this.zoomAt(i)) })),
    };
    this.rings.exposure.show(0, stops(0));
    this.pair(["tilt-x", "tilt-y"], "film-tilt", "tilt", "\u00b0");
    this.pair(["shift-x", "shift-y"], "film-shift", "shift", " mm");
    by("film").addEventListener("change", () => set({ "film-diagonal": by("film").value || null }));
    this.bindDrawer();
  }

  /** Lets the controls work, or stops them all while there is no camera. */
  enable(yes) {
    by("controls").disabled = by("wipe").disabled = !yes;
    if (!yes) by("drawer").close();
    else if (!this.lenses.length) this.load();
  }

  /** Binds two ranges of half units to an option of two numbers, which `of` names in the state of the lens. */
  pair(ids, option, of, unit) {
    const write = (value) => `${+value.toFixed(2)}${unit}`;
    ids.forEach((id, i) => {
      this.rings[id] = ring(id, 0, (step) => write(step / 2), (step) => {
        // The other one of the two stays, also between the steps of its ring.
        this.values[of][i] = step / 2;
        const numbers = this.values[of].join(",");
        this.link.set({ [option]: numbers === this.own[of] ? null : numbers });
      });
    });
    this.pairs = [...(this.pairs ?? []), { ids, option, of, write }];
    this.values = { ...this.values, [of]: [0, 0] };
  }

  showPairs({ lens, options }) {
    for (const { ids, option, of, write } of this.pairs) {
      const numbers = options[option]?.split(",").map(Number);
      const given = numbers?.every(Number.isFinite) ? numbers : null;
      const values = given ?? lens?.[of] ?? [0, 0];
      if (!numbers) this.own[of] = values.join(",");
      this.values[of] = [...values];
      ids.forEach((id, i) => this.rings[id].show(2 * values[i], write(values[i])));
    }
  }

  /** The words of a stop, with the T-number that the lens has there. */
  aperture(stop) {
    const lens = this.state?.lens;
    return aperture(stop, lens?.t_number && (stop * lens.t_number) / lens.f_number);
  }

  /** The option of a step of the aperture ring. The first is the widest stop, which is not rounded up. */
  option(step) {
    return String(Math.floor(this.scale[step] * 1e4) / 1e4);
  }

  /** The focal length of a step of the zoom ring (mm). */
  zoomAt(step) {
    const [low, high] = this.zoom;
    const steps = zoomSteps(this.zoom);
    return step < steps ? low + ((high - low) * step) / steps : high;
  }

  async load() {
    try {
      this.lenses = await (await fetch("lenses.json")).json();
      if (by("drawer").open) this.fillDrawer();
    } catch {
      // The link says that the camera is gone.
    }
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
      const [item, button, section, name, facts] = ["li", "button", "span", "b", "span"].map((tag) => document.createElement(tag));
      section.className = "plate";
      showWhenSeen(section, lens.section);
      name.textContent = lens.name;
      const words = [millimetres(lens.focal_length), aperture(lens.f_number)].filter(Boolean).join(", ");
      facts.textContent = `${words} \u00b7 ${lens.file}`;
      button.type = "button";
      button.setAttribute("aria-pressed", String(lens === this.lens));
      button.append(section, name, facts);
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
    const lens = this.state?.lens;
    by("lens-name").textContent = lens?.name ?? "No lens of glass";
    by("open-drawer").disabled = !lens;
    this.scale = stopsFrom(lens?.widest_f_number);
    this.rings.stop.turn(this.scale.length);
    if (lens?.f_number) this.rings.stop.show(nearest(this.scale, lens.f_number), aperture(lens.f_number, lens.t_number));
    else this.rings.stop.show(0, "");
  }

  /** Shows a state of the camera. */
  show(state) {
    this.state = state;
    const { lens, rings } = { lens: state.lens, rings: this.rings };
    for (const id of ["stop", "focus", "tilt-x", "tilt-y", "shift-x", "shift-y"]) rings[id].input.disabled = !lens;
    rings.time.show(nearest(TIMES.map(([s]) => s), state.exposure_time || 1), seconds(state.exposure_time));
    if (state.sensor) rings.iso.show(nearest(SPEEDS.slice(1), state.iso) + 1, speed(state.iso));
    else rings.iso.show(0, [speed(state.iso), "no noise"].filter(Boolean).join(", "));
    rings.focus.show(focusStep(state.focus ?? Infinity), lens ? metres(state.focus ?? Infinity) : "");
    const zoom = lens?.zoom ?? [];
    by("zoom-row").hidden = zoom.length < 2;
    if (zoom.length > 1) {
      this.zoom = [Math.min(...zoom), Math.max(...zoom)];
      const [low, high] = this.zoom;
      const steps = zoomSteps(this.zoom);
      rings.zoom.turn(steps + 1);
      rings.zoom.show(Math.round((steps * (lens.focal_length - low)) / (high - low)), millimetres(lens.focal_length));
    }
    this.showPairs(state);
    this.showFilm(state);
    this.showLens();
    this.showReadout(state);
    this.showSharp(state.depth_of_field);
    this.showEffects(state);
    by("command").value = state.command;
    by("warnings").replaceChildren(...(state.warnings ?? []).map((warning) => {
      const item = document.createElement("li");
      item.textContent = warning;
      return item;
    }));
  }

  /** Lists the sizes of films; one that has no name here is listed, too. */
  showFilm({ lens, film, options }) {
    const select = by("film");
    select.disabled = !lens;
    if (!lens || document.activeElement === select) return;
    const given = options["film-diagonal"];
    const listed = given && !FILMS.some(([, diagonal]) => String(diagonal) === given) ? [[`${given} mm`, given], ...FILMS] : FILMS;
    const own = given ? "as the scene" : `as the scene (${Math.hypot(...film).toFixed(1)} mm)`;
    const choices = listed.map(([name, diagonal]) => new Option(`${name}, ${diagonal} mm`, diagonal, false, String(diagonal) === given));
    select.replaceChildren(new Option(own, "", false, !given), ...choices);
  }

  /** Shows the depth of field beside the focus ring, on its scale. */
  showSharp(depth) {
    by("sharp").hidden = by("sharp-words").hidden = !depth;
    if (!depth) return;
    const far = depth.far ?? Infinity;
    const [from, to] = [depth.near, far].map((distance) => (100 * focusStep(distance)) / FOCUS_STEPS);
    Object.assign(by("sharp").firstElementChild.style, { left: `${from}%`, width: `${to - from}%` });
    const range = `Sharp from ${metres(depth.near)} to ${metres(far)}`;
    by("sharp-words").textContent = `${range}: blur up to ${depth.circle.toFixed(3)} mm, the film's diagonal / 1500.`;
  }

  showReadout({ lens, exposure_time: time, exposure_value: ev, iso, focus }) {
    by("r-lens").textContent = lens ? millimetres(lens.focal_length) : "no lens";
    by("r-stop").textContent = aperture(lens?.f_number, lens?.t_number);
    by("r-time").textContent = seconds(time);
    by("r-iso").textContent = speed(iso);
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
