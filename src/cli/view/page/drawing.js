// Drawings: SVG texts of the camera, put into the page so that they have the colours of its theme.

/** Shows an SVG text in an element. Without words, it is a decoration. */
export function showDrawing(holder, svg, words) {
  const parsed = new DOMParser().parseFromString(svg, "image/svg+xml").documentElement;
  if (parsed.localName !== "svg") return;
  const drawing = document.importNode(parsed, true);
  // The words say more, and a title would follow the pointer.
  drawing.querySelector("title")?.remove();
  if (words) {
    drawing.setAttribute("role", "img");
    drawing.setAttribute("aria-label", words);
  } else {
    drawing.setAttribute("aria-hidden", "true");
  }
  holder.replaceChildren(drawing);
}

const waiting = new WeakMap();

const watch = new IntersectionObserver((entries) => {
  for (const { isIntersecting, target } of entries) {
    if (!isIntersecting) continue;
    watch.unobserve(target);
    load(target, waiting.get(target));
  }
});

async function load(holder, path) {
  try {
    const reply = await fetch(path);
    if (reply.ok) showDrawing(holder, await reply.text(), "");
  } catch {
    // The link says that the camera is gone.
  }
}

/** Loads a drawing into an element once it is in view. */
export function showWhenSeen(holder, path) {
  waiting.set(holder, path);
  watch.observe(holder);
}
