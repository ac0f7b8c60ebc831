// Orbit, pan and dolly: drags over the picture become numbers of `camera`.

import { number } from "./view.js";

const round = (x) => Number(x.toPrecision(5));
const add = (a, b, s = 1) => a.map((x, k) => x + s * b[k]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const scaled = (a, s) => a.map((x) => x * s);
const unit = (a) => scaled(a, 1 / (Math.hypot(...a) || 1));

// v turned about the unit axis by an angle (Rodrigues)
const turned = (v, axis, angle) =>
  add(add(scaled(v, Math.cos(angle)), cross(axis, v), Math.sin(angle)), axis, dot(axis, v) * (1 - Math.cos(angle)));

export class CameraHandle {
  #studio;
  #drag = null;
  #rest = 0;
  #burst = null; // the pose to which turns of the wheel and keys add up, until the text has taken them over

  constructor(studio) {
    this.#studio = studio;
    const holder = document.getElementById("frame-holder");
    holder.addEventListener("pointerdown", (event) => this.#begin(event, holder));
    holder.addEventListener("pointermove", (event) => this.#move(event));
    for (const type of ["pointerup", "pointercancel"]) holder.addEventListener(type, () => this.#end());
    holder.addEventListener("wheel", (event) => { event.preventDefault(); this.#dolly(Math.exp(event.deltaY * 0.001)); }, { passive: false });
    holder.addEventListener("keydown", (event) => this.#key(event));
  }

  // The camera as numbers; null where something else moves it.
  #pose() {
    const camera = this.#studio.data?.camera ?? {};
    if (camera.path !== undefined || camera.orbit !== undefined) {
      this.#studio.notice("this camera moves by its path or orbit: change those among the controls");
      return null;
    }
    if (this.#studio.data?.camera === undefined) {
      this.#studio.notice("this preset has no camera: add one among the controls, and it can be moved");
      return null;
    }
    if (JSON.stringify([camera.position, camera.target, camera.up, camera.fov, camera.height]).includes("$")) {
      this.#studio.notice("this camera goes by knobs: turn those");
      return null;
    }
    const vector = (value, otherwise) => (Array.isArray(value) ? value.map((x) => number(x, 0)) : otherwise);
    return {
      position: vector(camera.position, [0, 0, 10]), target: vector(camera.target, [0, 0, 0]),
      up: unit(vector(camera.up, [0, 1, 0])), fov: number(camera.fov, 40), height: camera.height,
    };
  }

  #begin(event, holder) {
    if (event.button !== 0 && event.button !== 1) return;
    const pose = this.#pose();
    if (pose === null) return;
    holder.setPointerCapture(event.pointerId);
    this.#drag = { x: event.clientX, y: event.clientY, pose, pans: event.shiftKey || event.button === 1, rows: document.getElementById("picture").clientHeight };
  }

  #move(event) {
    const drag = this.#drag;
    if (drag === null) return;
    const [dx, dy] = [event.clientX - drag.x, event.clientY - drag.y];
    this.#set(drag.pans ? this.#panned(drag, dx, dy) : this.#orbited(drag.pose, -0.008 * dx, -0.008 * dy), false);
    drag.moved = true;
  }

  #end() {
    if (this.#drag?.moved) this.#studio.settle();
    this.#drag = null;
  }

  #orbited(pose, around, over) {
    let line = turned(add(pose.position, pose.target, -1), pose.up, around);
    const right = unit(cross(pose.up, line));
    const height = Math.asin(Math.max(-1, Math.min(1, dot(unit(line), pose.up))));
    const limited = Math.max(-1.5, Math.min(1.5, height - over)) - height;
    line = turned(line, right, -limited);
    return { "camera.position": add(pose.target, line).map(round) };
  }

  #panned(drag, dx, dy) {
    const { pose } = drag;
    const line = add(pose.position, pose.target, -1);
    const right = unit(cross(pose.up, line));
    const up = cross(unit(line), right);
    const rows = pose.height === undefined ? 2 * Math.hypot(...line) * Math.tan((pose.fov * Math.PI) / 360) : number(pose.height, 1);
    const move = add(scaled(right, (-dx * rows) / drag.rows), up, (dy * rows) / drag.rows);
    return { "camera.position": add(pose.position, move).map(round), "camera.target": add(pose.target, move).map(round) };
  }

  #dolly(factor) {
    const pose = this.#burst ?? this.#pose();
    if (pose === null) return;
    if (pose.height !== undefined) {
      const height = round(number(pose.height, 1) * factor);
      this.#inBurst({ ...pose, height }, { "camera.height": height });
    } else {
      const position = add(pose.target, add(pose.position, pose.target, -1), factor).map(round);
      this.#inBurst({ ...pose, position }, { "camera.position": position });
    }
  }

  #inBurst(pose, values) {
    this.#burst = pose;
    this.#set(values, false);
    clearTimeout(this.#rest);
    this.#rest = setTimeout(() => { this.#burst = null; this.#studio.settle(); }, 250);
  }

  #key(event) {
    if (event.target.id !== "frame-holder" || !event.shiftKey) return;
    const turns = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[event.key];
    if (turns !== undefined) {
      event.preventDefault();
      event.stopPropagation();
      const pose = this.#burst ?? this.#pose();
      if (pose === null) return;
      const values = this.#orbited(pose, ...turns);
      this.#inBurst({ ...pose, position: values["camera.position"] }, values);
    }
  }

  #set(values, done) {
    this.#studio.set(values, done);
  }
}
