// Steering: keyboard, mouse and gamepad become keys that are pressed more or less, and the studio answers with pictures.

import { Dials, number } from "./dials.js";

const $ = (id) => document.getElementById(id);
const DEAD = 0.12; // of a gamepad's stick, which never rests at 0
const ARROWS = { ArrowLeft: "\u2190", ArrowRight: "\u2192", ArrowUp: "\u2191", ArrowDown: "\u2193", " ": "Space", mouse: "mouse button" };

// A gamepad's axes (standard layout) as [key below 0, key above 0], and its buttons as keys.
const AXES = [["ArrowLeft", "ArrowRight"], ["ArrowUp", "ArrowDown"], [], ["w", "s"]];
const BUTTONS = { 0: "mouse", 1: "x", 4: "e", 5: "q", 6: "f", 7: "r", 12: "ArrowUp", 13: "ArrowDown", 14: "ArrowLeft", 15: "ArrowRight" };

export class Steer {
  #studio;
  #connection;
  #dials = new Dials();
  #canvas = $("picture");
  #isOn = false;
  #isMine = false; // this page steers, rather than watches
  #held = {};
  #pad = {};
  #pointer = null; // where the mouse has moved since the last message
  #sent = "";
  #keys = new Set();

  constructor(studio, connection) {
    this.#studio = studio;
    this.#connection = connection;
    $("steer").onclick = () => this.#begin();
    $("again").onclick = () => this.#begin();
    $("keep").onclick = () => connection.send({ type: "keep" });
    $("leave").onclick = () => connection.send({ type: "steer", on: false });
    for (const type of ["keydown", "keyup"]) document.addEventListener(type, (event) => this.#key(event), true);
    for (const type of ["pointerdown", "pointermove", "pointerup", "pointercancel", "wheel"]) {
      document.addEventListener(type, (event) => this.#mouse(event), { capture: true, passive: false });
    }
    window.addEventListener("blur", () => { this.#held = {}; });
  }

  // What the document says of it.
  take(state) {
    $("steer").hidden = !state.steers;
    $("keep").disabled = state.file === null;
    $("keep").title = state.file === null
      ? `a preset of gen-art keeps nothing: gen-art new mine --from ${state.name} makes a copy of your own`
      : "Write what was steered beside the preset, as a film";
  }

  // It stays until the next run: other words in the picture come and go.
  kept(names) {
    $("kept").textContent = `kept as ${names.join(" and ")}, by which the film goes now: save the preset, and it renders as it was steered`;
    $("kept").hidden = false;
  }

  turn(on, isMine) {
    const begins = on && !this.#isOn;
    this.#isOn = on;
    this.#isMine = isMine;
    document.body.dataset.steering = on;
    $("cockpit").hidden = !on;
    for (const button of document.querySelectorAll("#cockpit button")) button.hidden = !isMine;
    if (!on) return;
    $("kept").hidden = true;
    this.#held = {};
    this.#pad = {};
    this.#pointer = null;
    this.#sent = "";
    this.#dials.begin();
    $("inputs").replaceChildren();
    $("frame-holder").focus({ preventScroll: true });
    if (begins) requestAnimationFrame(() => this.#turnOfScreen());
  }

  // The instruments of a picture; nothing of one that was not steered.
  show(steered) {
    if (!this.#isOn || !steered) return;
    this.#dials.draw(steered);
    this.#inputs(steered.inputs);
    this.#studio.notice(this.#words(steered), true);
    $("cockpit").dataset.frame = steered.seconds;
  }

  #words(steered) {
    if (steered.done) return this.#isMine ? "the film ends here: again, keep or leave" : "the film ends here";
    if (!steered.begun) return this.#isMine ? "any of the keys below, or the mouse over the picture, begins" : "somebody is about to steer";
    if (steered.speed === undefined) return `no particle of ${steered.of} is left: again?`;
    if (steered.pace === null) return "";
    const size = steered.coarseness > 1 ? `, drawn at 1/${steered.coarseness} of the size` : "";
    if (steered.pace >= 0.95) return size && `real time${size}`;
    return `${steered.pace.toFixed(2)} of real time${size}: this machine cannot do more`;
  }

  #begin() {
    this.#connection.send({ type: "steer", on: true });
  }

  #inputs(inputs) {
    const list = $("inputs");
    if (list.children.length !== 4 * inputs.length) {
      list.replaceChildren(...inputs.flatMap((input) => this.#row(input)));
      this.#keys = new Set(inputs.flatMap((input) => [...input.less, ...input.more]));
      if (inputs.some((input) => input.kind === "pointer")) for (const key of Object.keys(ARROWS)) this.#keys.add(key);
    }
    inputs.forEach((input, k) => {
      const meter = list.children[4 * k + 1].firstChild;
      if (meter !== null) meter.value = input.value;
      list.children[4 * k + 2].textContent = `${number(input.value)} ${input.unit}`;
    });
  }

  #row(input) {
    const cell = (tag, ...content) => {
      const made = document.createElement(tag);
      made.append(...content);
      return made;
    };
    const bar = cell("dd");
    if (Number.isFinite(input.low) && Number.isFinite(input.high)) {
      const meter = document.createElement("meter");
      [meter.min, meter.max] = [input.low, input.high];
      meter.setAttribute("aria-label", input.name);
      bar.append(meter);
    }
    const keys = (which) => which.map((key) => ARROWS[key] ?? key.toUpperCase()).join(" ");
    const how = input.kind === "pointer" ? "the mouse" : [input.less, input.more].filter((which) => which.length).map(keys).join(" / ");
    return [cell("dt", input.name.replaceAll("_", " ")), bar, cell("dd"), cell("dd", cell("kbd", how))];
  }

  #key(event) {
    if (!this.#isOn || !this.#isMine || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "Escape" && event.type === "keydown") {
      this.#connection.send({ type: "steer", on: false });
    } else {
      const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
      if (!this.#keys.has(key)) return;
      if (event.type === "keydown") this.#held[key] = 1;
      else delete this.#held[key];
    }
    event.preventDefault();
    event.stopPropagation();
  }

  #mouse(event) {
    if (!this.#isOn || !this.#isMine) return;
    if (["pointerup", "pointercancel"].includes(event.type)) delete this.#held.mouse;
    if (!$("frame-holder").contains(event.target)) return;
    event.stopPropagation();
    if (event.type === "wheel") { event.preventDefault(); return; }
    if (event.type === "pointerdown") this.#held.mouse = 1;
    const box = this.#canvas.getBoundingClientRect();
    this.#pointer = [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  }

  // Once for each turn of the screen, what the hands do is sent if it is other than before.
  #turnOfScreen() {
    if (!this.#isOn || !this.#isMine) return;
    this.#pad = gamepad();
    const held = { ...this.#held };
    for (const [key, far] of Object.entries(this.#pad)) held[key] = Math.max(far, held[key] ?? 0);
    const said = JSON.stringify(held);
    if (said !== this.#sent || this.#pointer !== null) {
      this.#connection.send({ type: "devices", held, ...(this.#pointer ? { pointer: this.#pointer } : {}) });
      this.#sent = said;
      this.#pointer = null;
    }
    requestAnimationFrame(() => this.#turnOfScreen());
  }
}

// The first gamepad's sticks and buttons, by the key that each stands for.
function gamepad() {
  const pad = [...(navigator.getGamepads?.() ?? [])].find((one) => one !== null);
  const held = {};
  if (!pad) return held;
  const press = (key, far) => { if (key !== undefined && far > 0) held[key] = Math.max(held[key] ?? 0, Number(far.toFixed(2))); };
  AXES.forEach(([less, more], k) => {
    const far = pad.axes[k] ?? 0;
    const beyond = (Math.abs(far) - DEAD) / (1 - DEAD);
    press(far < 0 ? less : more, beyond);
  });
  for (const [k, key] of Object.entries(BUTTONS)) press(key, pad.buttons[k]?.value ?? 0);
  return held;
}
