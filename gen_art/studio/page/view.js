// The picture and its transport: which frame is wanted, in which size, playing or not.

export class View extends EventTarget {
  #connection;
  #canvas = document.getElementById("picture");
  #holder = document.getElementById("frame-holder");
  #scrub = document.getElementById("scrub");
  #play = document.getElementById("play");
  #ratio = 16 / 9;
  #own = [1280, 720];
  #fps = 30;
  frame = 0;
  frames = 1;
  playing = false;
  fits = true;

  constructor(connection) {
    super();
    this.#connection = connection;
    connection.addEventListener("picture", (event) => this.#show(event.detail));
    this.#play.onclick = () => this.toggle();
    document.getElementById("back").onclick = () => this.go(this.frame - 1);
    document.getElementById("forth").onclick = () => this.go(this.frame + 1);
    this.#scrub.oninput = () => this.go(Number(this.#scrub.value));
    document.getElementById("fit").onchange = (event) => { this.fits = event.target.checked; this.resize(); };
    new ResizeObserver(() => this.resize()).observe(this.#holder);
  }

  // What the preset says of its picture and its clock.
  take(data) {
    this.#own = data.camera?.size ?? [1280, 720];
    this.#ratio = this.#own[0] / this.#own[1];
    this.#fps = number(data.clock?.fps, 30);
    this.resize();
  }

  toggle(playing = !this.playing) {
    this.playing = playing;
    this.#play.textContent = playing ? "Pause" : "Play";
    this.#play.setAttribute("aria-label", playing ? "Pause" : "Play");
    this.#connection.send({ type: "view", playing, frame: this.frame });
  }

  go(frame) {
    if (this.playing) this.toggle(false);
    this.frame = Math.max(0, Math.min(this.frames - 1, frame));
    this.#connection.send({ type: "view", frame: this.frame });
    this.#tell();
  }

  // Say again what is wanted, to a studio that has forgotten it.
  renew() {
    this.#size = "";
    this.resize();
    this.#connection.send({ type: "view", frame: this.frame, playing: this.playing });
  }

  #size = "";
  #newest = 0;

  resize() {
    this.#holder.classList.toggle("fits", this.fits);
    const room = [this.#holder.clientWidth, this.#holder.clientHeight];
    let width = this.#own[0];
    if (this.fits) width = Math.min(room[0], room[1] * this.#ratio, this.#own[0]);
    // in steps that keep the ratio of width to height, so that a fitted camera stays where it is
    const unit = this.#own[0] / gcd(...this.#own);
    if (unit <= 64) width = Math.max(unit, width - (width % unit));
    const size = [Math.max(16, Math.round(width)), Math.max(16, Math.round(width / this.#ratio))];
    this.#canvas.style.width = `${size[0]}px`;
    this.#canvas.style.height = `${size[1]}px`;
    if (String(size) === this.#size) return;
    this.#size = String(size);
    this.#connection.send({ type: "view", size });
  }

  async #show(shown) {
    try {
      this.#newest += 1;
      const number = this.#newest;
      const bitmap = await createImageBitmap(shown.picture);
      if (number < this.#newest) { // a newer one has come meanwhile, and is shown before this one or after it
        bitmap.close();
        return;
      }
      if (this.#canvas.width !== bitmap.width || this.#canvas.height !== bitmap.height) {
        this.#canvas.width = bitmap.width;
        this.#canvas.height = bitmap.height;
      }
      this.#canvas.getContext("2d").drawImage(bitmap, 0, 0);
      bitmap.close();
    } finally {
      this.#connection.send({ type: "shown" });
    }
    this.frames = shown.frames;
    this.#scrub.max = shown.frames - 1;
    const watches = document.body.dataset.editor === "false";
    this.frame = this.playing || watches || shown.steered ? shown.frame : Math.min(this.frame, shown.frames - 1);
    this.#tell();
    const milliseconds = 1000 * (shown.seconds.draw + shown.seconds.develop);
    document.getElementById("facts").textContent =
      `${shown.particles.toLocaleString("en")} particles, ${shown.width} x ${shown.height}, ${milliseconds.toFixed(0)} ms`;
    this.#canvas.dataset.frame = shown.frame;
    this.#canvas.dataset.exact = shown.exact;
    this.#canvas.dataset.shown = Number(this.#canvas.dataset.shown ?? 0) + 1;
    this.dispatchEvent(new CustomEvent("shown", { detail: shown }));
  }

  #tell() {
    this.#scrub.value = this.frame;
    document.getElementById("clock").textContent =
      `${(this.frame / this.#fps).toFixed(2)} s, frame ${this.frame} of ${this.frames}`;
  }
}

const gcd = (a, b) => (b === 0 ? a : gcd(b, a % b));

export function number(value, otherwise = NaN) {
  if (typeof value === "number") return value;
  const match = /^\s*([-+]?[\d.]+(?:e[-+]?\d+)?)\s*(?:\/\s*([\d.]+(?:e[-+]?\d+)?))?\s*$/i.exec(value ?? "");
  return match ? Number(match[1]) / Number(match[2] ?? 1) : otherwise;
}
