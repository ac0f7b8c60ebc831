// Controls for the values of a preset, made from its JSON Schema: a row for a value, a group for a mapping, a list of the keys
// that can be added.

import { curveEditor, isCurve } from "./curve.js";
import { number } from "./view.js";

const MOST_OFFERED = 40;

const element = (tag, attributes = {}, ...children) => {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name in node && name !== "list") node[name] = value;
    else node.setAttribute(name, value);
  }
  node.append(...children);
  return node;
};

const joined = (path, key) => (typeof key === "number" ? `${path}[${key}]` : path ? `${path}.${key}` : key);
const isColour = (value) => typeof value === "string" && /^#[0-9a-f]{6}$/i.test(value);
const isMapping = (value) => value !== null && typeof value === "object" && !Array.isArray(value);

export class Controls {
  #studio;
  #schema;
  #tree = document.getElementById("tree");
  #knobs = document.getElementById("knobs");
  #open = new Set(["camera", "develop"]);
  #shapes = "";
  #offers = document.getElementById("offers");

  constructor(studio, schema) {
    this.#studio = studio;
    this.#schema = schema;
    document.getElementById("search").oninput = (event) => this.#filter(event.target.value);
  }

  // Show the values of a document.
  show(document_) {
    const shapes = JSON.stringify([shapeOf(document_.data), Object.values(document_.knobs).map((knob) => [knob.range, knob.unit])]);
    if (shapes === this.#shapes) {
      for (const root of [this.#knobs, this.#tree]) {
        for (const row of root.querySelectorAll("[data-path]")) row.renew?.(valueAt(document_.data, row.dataset.path));
      }
      return;
    }
    this.#shapes = shapes;
    const focused = document.activeElement?.closest?.("[data-path]")?.dataset.path;
    this.#knobs.replaceChildren(...this.#knobRows(document_));
    this.#tree.replaceChildren(...this.#rows(document_.data, this.#schema.root, "", ["version", "knobs"]), this.#adder(document_.data, this.#schema.root, ""));
    if (focused) this.#tree.querySelector(`[data-path="${CSS.escape(focused)}"] input`)?.focus();
    this.#filter(document.getElementById("search").value);
  }

  #knobRows(document_) {
    return Object.entries(document_.knobs).map(([name, knob]) => {
      const written = document_.data.knobs[name];
      const path = isMapping(written) && "value" in written ? `knobs.${name}.value` : `knobs.${name}`;
      return this.#row(path, name, knob.value, {}, { unit: knob.unit, range: knob.range, isKnob: true });
    });
  }

  #rows(data, schema, path, without = []) {
    const keys = Array.isArray(data) ? data.map((_, k) => k) : Object.keys(data).filter((key) => !without.includes(key));
    return keys.map((key) => this.#control(joined(path, key), String(key), data[key], this.#schema.child(schema, key)));
  }

  #control(path, name, value, schema) {
    const grouped = isMapping(value) || (Array.isArray(value) && value.some((item) => isMapping(item)));
    return grouped ? this.#group(path, name, value, schema) : this.#row(path, name, value, schema, {});
  }

  #group(path, name, value, schema) {
    const words = this.#schema.words(schema);
    const group = element("details", { className: "group", open: this.#open.has(path) });
    group.dataset.words = `${path} ${words}`.toLowerCase();
    const summary = element("summary", { title: words }, name, element("span", { className: "quiet" }, Array.isArray(value) ? ` ${value.length}` : ""), this.#remover(path, "remove"));
    group.append(summary);
    // what nobody has opened is not built: a preset has hundreds of controls
    const fill = () => {
      if (group.children.length > 1) return;
      group.append(...this.#rows(value, schema, path));
      if (!Array.isArray(value)) group.append(this.#adder(value, schema, path));
    };
    group.fill = fill;
    if (group.open) fill();
    group.addEventListener("toggle", () => {
      if (group.open) { this.#open.add(path); fill(); } else this.#open.delete(path);
    });
    return group;
  }

  // A list of the keys that can be added here, or a field for a name.
  #adder(data, schema, path) {
    const missing = Object.entries(this.#schema.keys(schema)).filter(([key]) => !(key in data) && key !== "version");
    const add = element("select", { className: "add" }, element("option", { value: "" }, "add ..."));
    add.setAttribute("aria-label", `add to ${path || "the preset"}`);
    for (const [key, one] of missing) add.append(element("option", { value: key, title: this.#schema.words(one) }, key));
    if (this.#schema.isNamed(schema)) add.append(element("option", { value: "\0" }, "another name ..."));
    add.hidden = add.children.length === 1;
    add.onchange = () => {
      const key = add.value === "\0" ? prompt("Its name") : add.value;
      add.value = "";
      if (!key) return;
      const place = joined(path, key);
      this.#open.add(place);
      this.#studio.set({ [place]: this.#schema.example(this.#schema.child(schema, key)) }, true);
    };
    return add;
  }

  #remover(path, words) {
    const button = element("button", { className: "remove", title: words, type: "button" }, "×");
    button.setAttribute("aria-label", `${words}: ${path}`);
    button.onclick = (event) => { event.preventDefault(); this.#studio.remove(path); };
    return button;
  }

  #row(path, name, value, schema, { unit = this.#schema.unit(schema), range = null, isKnob = false }) {
    const words = this.#schema.words(schema);
    const inputs = element("span", { className: "inputs" });
    const row = element("div", { className: "row" }, element("span", { className: "label", title: words || path }, name), inputs, element("span", { className: "unit" }, unit));
    if (!isKnob) row.lastChild.append(this.#remover(path, "remove"));
    row.dataset.path = path;
    row.dataset.words = `${path} ${words}`.toLowerCase();
    const set = (now, done) => {
      row.value = null; // so that a value which is refused gives way to the one that stays
      if (done) row.isTypedIn = false;
      this.#studio.set({ [path]: now }, done);
    };
    const build = (shown) => {
      row.value = JSON.stringify(shown);
      inputs.replaceChildren(...this.#inputs(shown, schema, path, range, set));
    };
    build(value);
    // What is being typed stays under the hand: a value that comes meanwhile is shown when the field is left.
    inputs.addEventListener("input", (event) => { row.isTypedIn = ["text", "number"].includes(event.target.type); });
    inputs.addEventListener("focusout", () => {
      if (!row.isTypedIn) return;
      row.isTypedIn = false;
      row.renew(row.latest);
    });
    row.renew = (now) => {
      row.latest = now;
      if (row.isTypedIn || now === undefined || JSON.stringify(now) === row.value) return;
      const found = () => [...inputs.querySelectorAll("input, select")];
      const held = document.activeElement;
      const at = found().indexOf(held);
      const isSelected = held.type === "text" && held.selectionStart === 0 && held.selectionEnd === held.value.length;
      build(now);
      if (at < 0) return;
      found()[at]?.focus();
      if (isSelected) found()[at]?.select?.();
    };
    return row;
  }

  #inputs(value, schema, path, range, set) {
    if (typeof value === "boolean") {
      const box = element("input", { type: "checkbox", checked: value, onchange: () => set(box.checked, true) });
      return [labelled(box, path)];
    }
    const choices = this.#schema.choices(schema);
    if (typeof value === "string" && choices.includes(value)) {
      const list = element("select", { onchange: () => set(list.value, true) }, ...choices.map((choice) => element("option", { value: choice, selected: choice === value }, String(choice))));
      return [labelled(list, path)];
    }
    if (isColour(value)) return this.#colour(value, path, set);
    if (typeof value === "number" || (typeof value === "string" && !Number.isNaN(number(value)))) return this.#number(value, schema, path, range, set);
    if (isCurve(value)) return [curveEditor(value, path, set)];
    if (Array.isArray(value) && value.length > 0 && value.every((item) => typeof item === "string")) return this.#colours(value, path, set);
    if (Array.isArray(value) && value.length <= 4 && value.length > 0 && value.every((item) => typeof item === "number")) return this.#vector(value, path, set);
    return [this.#text(value, path, set)];
  }

  #number(value, schema, path, range, set) {
    const now = number(value);
    const [low, high] = range ?? sliderEnds(now, this.#schema.limits(schema));
    const isWhole = this.#schema.has(schema, "integer");
    const step = isWhole ? 1 : (high - low) / 500;
    const slider = element("input", { type: "range", min: low, max: high, step, value: now });
    const field = element("input", { type: "text", inputMode: "decimal", value: String(value) });
    slider.oninput = () => { field.value = neat(Number(slider.value), step); set(Number(field.value), false); };
    slider.onchange = () => set(Number(field.value), true);
    field.onchange = () => set(written(field.value), true);
    const found = [labelled(slider, `${path}, slider`), labelled(field, path)];
    if (path === "seed" || path.endsWith(".seed")) {
      const dice = element("button", { type: "button", title: "another seed" }, "dice");
      dice.onclick = () => set(Math.floor(Math.random() * 100000), true);
      return [labelled(field, path), dice];
    }
    return found;
  }

  #colour(value, path, set) {
    const well = element("input", { type: "color", value });
    const field = element("input", { type: "text", value });
    well.oninput = () => { field.value = well.value; set(well.value, false); };
    well.onchange = () => set(well.value, true);
    field.onchange = () => set(field.value, true);
    return [labelled(well, `${path}, colour`), labelled(field, path)];
  }

  // Colours one after the other, with a bar that shows them as a gradient where they are numbers.
  #colours(value, path, set) {
    const bar = element("span", { className: "gradient" });
    const paint = (colours) => { bar.style.background = `linear-gradient(90deg, ${colours.length > 1 ? colours.join(", ") : `${colours[0]}, ${colours[0]}`})`; };
    paint(value);
    const parts = value.map((colour, k) => {
      const change = (now, done) => { const all = value.with(k, now); paint(all); set(all, done); };
      const input = isColour(colour)
        ? element("input", { type: "color", value: colour, oninput: () => change(input.value, false), onchange: () => change(input.value, true) })
        : element("input", { type: "text", value: colour, onchange: () => change(input.value, true) });
      return labelled(input, `${path}, colour ${k + 1}`);
    });
    const more = element("button", { type: "button", title: "one more colour" }, "+");
    more.onclick = () => set([...value, value.at(-1)], true);
    const fewer = element("button", { type: "button", title: "without the last colour" }, "-");
    fewer.onclick = () => set(value.slice(0, -1), true);
    fewer.disabled = value.length < 2;
    return [bar, ...parts, more, fewer];
  }

  #vector(value, path, set) {
    return value.map((part, k) => {
      const field = element("input", { type: "number", step: "any", value: part });
      const change = (done) => { if (field.value !== "") set(value.with(k, Number(field.value)), done); };
      field.oninput = () => change(false);
      field.onchange = () => change(true);
      return labelled(field, `${path}, ${"xyzw"[k]}`);
    });
  }

  #text(value, path, set) {
    const field = element("input", { type: "text", className: "wide", value: typeof value === "string" ? value : JSON.stringify(value) });
    field.onchange = () => set(typeof value === "string" && !/^\s*[[{]/.test(field.value) ? field.value : written(field.value), true);
    return labelled(field, path);
  }

  // The keys that a search finds, but that the preset does not have: a button for each.
  #offer(wanted) {
    const found = [];
    const visit = (data, schema, path) => {
      if (found.length >= MOST_OFFERED || !isMapping(data)) return;
      for (const [key, one] of Object.entries(this.#schema.keys(schema))) {
        const place = joined(path, key);
        const words = this.#schema.words(one);
        if (key in data) visit(data[key], one, place);
        else if (key !== "version" && `${place} ${words}`.toLowerCase().includes(wanted)) found.push([place, words, one]);
      }
      if (this.#schema.isNamed(schema)) {
        for (const [key, item] of Object.entries(data)) visit(item, this.#schema.child(schema, key), joined(path, key));
      }
    };
    if (wanted.length > 1) visit(this.#studio.data, this.#schema.root, "");
    this.#offers.replaceChildren(...found.slice(0, MOST_OFFERED).map(([place, words, one]) => {
      const button = element("button", { type: "button", title: words }, `add ${place}`);
      button.onclick = () => {
        for (let at = place; at.includes("."); at = at.slice(0, at.lastIndexOf("."))) this.#open.add(at.slice(0, at.lastIndexOf(".")));
        this.#studio.set({ [place]: this.#schema.example(one) }, true);
      };
      return button;
    }));
  }

  #filter(words) {
    const wanted = words.trim().toLowerCase();
    this.#offer(wanted);
    for (const add of this.#tree.querySelectorAll(".add")) add.hidden = wanted !== "" || add.children.length === 1;
    if (wanted) {
      for (let k = 0; k < 8; k += 1) for (const group of this.#tree.querySelectorAll("details.group")) group.fill();
    }
    const keep = (node) => {
      let shown = !wanted || (node.dataset.words ?? "").includes(wanted);
      for (const child of node.children) {
        if (child.matches(".row, details.group")) shown = keep(child) || shown;
      }
      node.hidden = !shown;
      if (wanted && shown && node.matches("details.group")) node.open = true;
      return shown;
    };
    let found = 0;
    for (const root of [this.#knobs, this.#tree]) for (const child of root.children) if (child.matches(".row, details.group")) found += keep(child);
    if (wanted && found + this.#offers.children.length === 0) this.#offers.replaceChildren(element("p", { className: "quiet" }, `nothing is called ${words.trim()}`));
  }
}

// An input with a name for those who do not see it, as wide as what stands in it.
const labelled = (input, path) => {
  input.setAttribute("aria-label", path);
  if (input.matches("input[type=text], input[type=number]")) input.style.width = `calc(${Math.max(4, String(input.value).length + 1)}ch + .8rem)`;
  return input;
};

// Text as a number, a list or a mapping where it is one.
function written(text) {
  const trimmed = text.trim();
  if (/^[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i.test(trimmed)) return Number(trimmed);
  try { return JSON.parse(trimmed); } catch { return trimmed; }
}

// The ends of a slider where nobody has said which values are worth trying: about twice the value, within the limits.
function sliderEnds(value, [low, high]) {
  const reach = value === 0 ? 2 : 2 * Math.abs(value);
  const bottom = value < 0 || (value === 0 && low !== 0) ? -reach : 0;
  return [Math.max(bottom, low ?? bottom), Math.min(reach, high ?? reach)];
}

const neat = (value, step) => String(Number(value.toFixed(Math.max(0, Math.min(12, 1 - Math.floor(Math.log10(step)))))));

// What has to be built anew where it differs: names, and kinds of values, but not the values.
function shapeOf(value) {
  if (isMapping(value)) return Object.fromEntries(Object.entries(value).map(([key, item]) => [key, shapeOf(item)]));
  if (Array.isArray(value)) return value.some((item) => isMapping(item)) ? value.map(shapeOf) : `list${value.length}`;
  return isColour(value) ? "colour" : typeof value;
}

export function valueAt(data, path) {
  let node = data;
  for (const [, key, index] of path.matchAll(/([^.[\]]+)|\[(\d+)\]/g)) node = node?.[index === undefined ? key : Number(index)];
  return node;
}
