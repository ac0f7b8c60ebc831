// What a pilot reads, as round dials: speed, height, climb, heading and, of an aeroplane, its attitude.

const RADIUS = 38;
const INK = "#e6e4df", QUIET = "#8b8b86", ACCENT = "#e8a34a", FACE = "#111215", SKY = "#3f7fae", EARTH = "#7a5a34";
const TURN = (3 / 4) * 2 * Math.PI; // of a needle, from its least to its greatest value
const degrees = (angle) => (angle * Math.PI) / 180;

export class Dials {
  #canvas = document.getElementById("dials");
  #ink = this.#canvas.getContext("2d");
  #scales = {}; // by name, the greatest value on a dial

  begin() { this.#scales = {}; }

  draw(steered) {
    const named = Object.fromEntries(steered.inputs.map((input) => [input.name, input.value]));
    const dials = [
      () => this.#gauge("speed", steered.speed, "m/s"),
      () => this.#gauge("height", steered.height, "m"),
      () => this.#gauge("climb", steered.climb, "m/s", true),
      () => this.#compass(steered.heading),
    ];
    if (named.bank !== undefined) dials.push(() => this.#attitude(named.bank, steered.speed, steered.climb, named.angle_of_attack ?? 0));
    const side = 2 * RADIUS + 12, ratio = Math.max(1, window.devicePixelRatio);
    this.#canvas.width = dials.length * side * ratio;
    this.#canvas.height = side * ratio;
    this.#canvas.style.width = `${dials.length * side}px`;
    dials.forEach((draw, k) => {
      this.#ink.setTransform(ratio, 0, 0, ratio, (k + 0.5) * side * ratio, 0.5 * side * ratio);
      this.#face();
      if (steered.speed !== undefined) draw();
    });
  }

  #face() {
    this.#circle(RADIUS);
    this.#ink.fillStyle = FACE;
    this.#ink.fill();
    this.#ink.strokeStyle = QUIET;
    this.#ink.lineWidth = 1.5;
    this.#ink.stroke();
  }

  // A needle from 0, or from minus the greatest value where it is signed.
  #gauge(name, value, unit, signed = false) {
    const most = (this.#scales[name] = scale(Math.max(Math.abs(value), this.#scales[name] ?? 0)));
    const low = signed || value < 0 ? -most : 0;
    const at = (x) => ((x - low) / (most - low) - 0.5) * TURN - Math.PI / 2;
    for (let k = 0; k <= 10; k += 1) this.#mark(at(low + (k / 10) * (most - low)), k % 5 === 0 ? 7 : 4);
    this.#line(at(value), -6, RADIUS - 9, ACCENT, 2.5);
    this.#word(name, 13, QUIET, 9);
    this.#word(`${number(value)} ${unit}`, 25, INK, 10);
  }

  #compass(heading) {
    for (let k = 0; k < 12; k += 1) this.#mark(degrees(30 * k - heading - 90), k % 3 === 0 ? 7 : 4);
    this.#ink.font = "9px system-ui, sans-serif";
    ["x", "z", "-x", "-z"].forEach((word, k) => {
      const angle = degrees(90 * k - heading - 90);
      this.#text(word, (RADIUS - 14) * Math.cos(angle), (RADIUS - 14) * Math.sin(angle), INK, 10);
    });
    this.#line(-Math.PI / 2, 0, 14, ACCENT, 3);
    this.#word(`${((heading % 360) + 360) % 360 | 0}\u00b0`, 9, INK, 10);
  }

  #attitude(bank, speed, climb, attack) {
    const pitch = (Math.asin(Math.max(-1, Math.min(1, climb / Math.max(speed, 1e-9)))) * 180) / Math.PI + attack;
    const ink = this.#ink;
    ink.save();
    this.#circle(RADIUS - 2);
    ink.clip();
    ink.rotate(degrees(-bank));
    const horizon = Math.max(-RADIUS, Math.min(RADIUS, pitch));
    ink.fillStyle = SKY;
    ink.fillRect(-60, -120, 120, 120 + horizon);
    ink.fillStyle = EARTH;
    ink.fillRect(-60, horizon, 120, 120);
    ink.fillStyle = INK;
    ink.fillRect(-60, horizon - 0.5, 120, 1);
    ink.restore();
    for (const side of [-1, 1]) this.#segment(side * 8, 0, side * 22, 0, ACCENT, 3);
    this.#segment(-1.5, 0, 1.5, 0, ACCENT, 3);
  }

  #circle(radius) {
    this.#ink.beginPath();
    this.#ink.arc(0, 0, radius, 0, 2 * Math.PI);
  }

  #mark(angle, length) { this.#line(angle, RADIUS - length, RADIUS - 1, QUIET, 1.2); }

  #line(angle, from, to, colour, width) {
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    this.#segment(from * c, from * s, to * c, to * s, colour, width);
  }

  #segment(x, y, toX, toY, colour, width) {
    this.#ink.strokeStyle = colour;
    this.#ink.lineWidth = width;
    this.#ink.beginPath();
    this.#ink.moveTo(x, y);
    this.#ink.lineTo(toX, toY);
    this.#ink.stroke();
  }

  #word(words, y, colour, size) { this.#text(words, 0, y, colour, size); }

  #text(words, x, y, colour, size) {
    this.#ink.font = `${size}px system-ui, "DejaVu Sans", sans-serif`;
    this.#ink.textAlign = "center";
    this.#ink.textBaseline = "middle";
    this.#ink.fillStyle = colour;
    this.#ink.fillText(words, x, y);
  }
}

// The next of 1, 2, 5, 10, ... above a value.
function scale(value) {
  if (!(value > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 5, 10].map((k) => k * power).find((k) => k >= value);
}

export function number(value) {
  return Math.abs(value) >= 100 ? value.toFixed(0) : Math.abs(value) >= 10 ? value.toFixed(1) : value.toFixed(2);
}
