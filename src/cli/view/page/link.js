// Link to the camera: one WebSocket, frames on demand, and settings at the pace of the frames.

const HEADER = 32;

// Longest time that settings wait for the frame of those before (ms).
const PACE = 250;

/** Reads a blur map; see blur_map in the source for its layout. A picture without one has an empty message. */
function blurOf(buffer) {
  if (buffer.byteLength === 0) return null;
  const view = new DataView(buffer);
  const [width, height] = [4, 8].map((at) => view.getUint32(at, true));
  return { width, height, diameters: new Float32Array(buffer, 20, width * height) };
}

const isBlur = (buffer) => buffer.byteLength === 0 || new DataView(buffer).getUint32(0, false) === 0x505a4331;

/** Reads a frame of the server; see ViewFrame in the source for its layout. */
function frameOf(buffer) {
  const view = new DataView(buffer);
  if (view.getUint32(0, false) !== 0x505a5631) throw new Error("not a frame of petzval");
  const [width, height, samples, target, flags] = [4, 8, 12, 16, 20].map((at) => view.getUint32(at, true));
  return {
    width, height, samples, target,
    draft: (flags & 1) !== 0,
    finished: (flags & 2) !== 0,
    generation: Number(view.getBigUint64(24, true)),
    // Little-endian, as every machine that has a browser today.
    light: new Float32Array(buffer, HEADER, 3 * width * height),
  };
}

export class Link {
  /** `on` has the methods frame, blur, state, saved, render, accuracy, refused and connected. */
  constructor(on) {
    this.on = on;
    // Whether the camera has told its state since the connection was made.
    this.live = false;
    this.pending = null;
    this.inFlight = false;
    this.awaited = 0;
    this.delay = 250;
    this.connect();
  }

  connect() {
    const address = new URL("socket", location.href);
    address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
    this.socket = new WebSocket(address);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => {
      this.delay = 250;
      this.next();
    };
    this.socket.onmessage = ({ data }) => {
      if (data instanceof ArrayBuffer && isBlur(data)) this.on.blur(blurOf(data));
      else if (data instanceof ArrayBuffer) this.receive(frameOf(data));
      else this.hear(JSON.parse(data));
    };
    this.socket.onclose = () => {
      this.live = false;
      // Wishes that the camera has not heard do not surprise it later.
      this.pending = null;
      this.arrived();
      this.on.connected(false);
      setTimeout(() => this.connect(), this.delay);
      this.delay = Math.min(2 * this.delay, 5000);
    };
  }

  send(message) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  next() {
    this.send({ type: "next" });
  }

  receive(frame) {
    this.on.frame(frame);
    // The next one once this is on the screen.
    requestAnimationFrame(() => this.next());
    if (this.inFlight && frame.generation >= this.awaited) this.arrived();
  }

  hear(message) {
    if (message.type === "set") this.awaited = message.generation;
    if (message.type === "state") {
      if (!this.live) {
        this.live = true;
        this.on.connected(true);
      }
      this.on.state(message);
      if (message.error) this.arrived();
    }
    if (message.type === "saved") this.on.saved(message);
    if (message.type === "render") this.on.render(message);
    if (message.type === "accuracy") this.on.accuracy(message);
    if (message.type === "refused") {
      this.arrived();
      this.on.refused(message.problem);
    }
  }

  /** Sets options, and merges those that come faster than frames. */
  set(options) {
    if (!this.live) return;
    this.pending = { ...this.pending, ...options };
    if (!this.inFlight) this.flush();
  }

  flush() {
    if (!this.pending) return;
    this.inFlight = true;
    this.awaited = Infinity;
    this.send({ type: "set", options: this.pending });
    this.pending = null;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.arrived(), PACE);
  }

  arrived() {
    clearTimeout(this.timer);
    this.inFlight = false;
    this.flush();
  }
}
