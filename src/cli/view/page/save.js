// Save: the command, the scene, the picture as it is shown, and the final picture.

import { by } from "./controls.js";

/** Saves a file of the browser or of the camera. */
function download(address, name) {
  const anchor = document.createElement("a");
  [anchor.href, anchor.download] = [address, name];
  anchor.click();
}

const say = (words) => { by("said").textContent = words; };

export class Save {
  constructor(link, screen) {
    this.link = link;
    by("copy").addEventListener("click", () => this.copy());
    by("save-png").addEventListener("click", async () => {
      const address = URL.createObjectURL(await screen.png());
      download(address, "picture.png");
      setTimeout(() => URL.revokeObjectURL(address), 10000);
      say("Saved as picture.png, as it is shown here.");
    });
    by("save-exr").addEventListener("click", () => download("picture.exr", "picture.exr"));
    by("save-scene").addEventListener("click", () => {
      say("");
      link.send({ type: "save", name: by("scene-name").value });
    });
    by("render").addEventListener("click", () => {
      if (this.running) {
        link.send({ type: "cancel" });
        return;
      }
      say("");
      link.send({ type: "render", name: by("final-name").value });
    });
  }

  async copy() {
    try {
      await navigator.clipboard.writeText(by("command").value);
      say("Copied.");
    } catch {
      by("command").select();
      say("Press Ctrl-C to copy.");
    }
  }

  saved({ file }) {
    say(`Saved as ${file}.`);
  }

  /** Shows the state of the final render. */
  show({ status, file, share, seconds, problem, checkpoint }) {
    this.running = status === "preparing" || status === "running";
    by("render").textContent = this.running ? "Cancel" : "Render final";
    by("final-progress").hidden = !this.running;
    // Without a value, it shows that something goes on.
    if (status === "running") by("final-progress").value = share;
    else by("final-progress").removeAttribute("value");
    const left = share > 0.01 ? `, about ${Math.ceil((seconds / share) * (1 - share))} s left` : "";
    say({
      preparing: `Preparing ${file}.`,
      running: `Rendering ${file}: ${Math.round(100 * share)} %${left}.`,
      finished: `Rendered ${file} in ${seconds.toFixed(1)} s.`,
      cancelled: `Cancelled. Render ${file} again to go on from ${checkpoint}.`,
      failed: `${file}: ${problem}`,
    }[status]);
  }
}
