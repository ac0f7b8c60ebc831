// The studio's page: one document, its controls, its text and its picture, kept in step with the server, which knows what is true.

import { CameraHandle } from "./camera.js";
import { Connection, fetchSchema } from "./connection.js";
import { Controls } from "./controls.js";
import { Editor } from "./editor.js";
import { Plots } from "./plots.js";
import { Schema } from "./schema.js";
import { Steer } from "./steer.js";
import { View } from "./view.js";

const $ = (id) => document.getElementById(id);

class Studio {
  data = null;
  #document = null;
  #connection = new Connection();
  #view = new View(this.#connection);
  #editor = new Editor(this);
  #plots = new Plots();
  #controls = null;
  #steer = new Steer(this, this.#connection);
  #unsaved = null; // the text of this page when the studio was lost, if its file did not have it
  #waiting = null; // values set since the last turn of the screen
  #noticed = 0;
  #first = true; // no picture has been shown yet

  async start() {
    this.#controls = new Controls(this, new Schema(await fetchSchema()));
    new CameraHandle(this);
    const on = (type, take) => this.#connection.addEventListener(type, (event) => take(event.detail));
    on("hello", (hello) => this.#greet(hello));
    on("document", (state) => this.#take(state));
    on("lost", () => this.notice("the studio does not answer; trying again", true));
    on("connected", () => this.notice(this.#first ? "computing the first picture" : "", true));
    on("said", (message) => this.notice(message.text, message.stays));
    on("warning", (message) => this.#problem(message.text, true));
    on("error", (message) => this.#problem(message.text));
    on("status", (status) => this.notice(status.anew === null ? "" : `computing the motion anew: ${Math.round(100 * status.anew)}%`, true));
    on("steering", (message) => this.#steered(message.on));
    on("kept", (message) => this.#steer.kept(message.names));
    on("final", (message) => this.#download(message));
    this.#view.addEventListener("shown", (event) => this.#shown(event.detail));
    this.#buttons();
    this.#tabs();
    document.addEventListener("keydown", (event) => this.#key(event));
    this.#connection.open();
  }

  // Values by path. Those of one turn of the screen go together; with `done` the text takes them over.
  set(values, done) {
    for (const [path, value] of Object.entries(values)) {
      const key = /^camera\.(\w+)$/.exec(path)?.[1];
      if (key && this.data?.camera) this.data.camera[key] = value; // the next drag goes on from here
    }
    if (this.#waiting === null) requestAnimationFrame(() => this.#flush());
    this.#waiting = { values: { ...this.#waiting?.values, ...values }, done: done || (this.#waiting?.done ?? false) };
    if (done) this.#flush();
  }

  settle() { this.set({}, true); }
  remove(path) { this.#flush(); this.#connection.send({ type: "remove", path }); }
  write(text) { this.#flush(); this.#connection.send({ type: "text", text }); }

  notice(words, stays = false) {
    $("notice").textContent = words;
    $("notice").hidden = words === "";
    clearTimeout(this.#noticed);
    if (words && !stays) this.#noticed = setTimeout(() => { $("notice").hidden = true; }, 3000);
  }

  #flush() {
    if (this.#waiting === null) return;
    this.#connection.send({ type: "set", ...this.#waiting });
    this.#waiting = null;
  }

  #greet(hello) {
    document.body.dataset.editor = hello.editor;
    this.#steered(false);
    this.#unsaved = this.#document !== null && !this.#document.saved ? this.#document.text : null;
    if (!this.#first) this.notice("");
    if (this.#document === null) this.#view.frame = hello.frame;
    this.#view.renew();
  }

  #take(state) {
    const mine = this.#unsaved;
    this.#unsaved = null;
    if (mine !== null && state.text !== mine && state.saved && !state.undo) {
      this.notice("the studio was started again; it has your unsaved changes from this page");
      this.write(mine);
      return;
    }
    this.#document = state;
    this.data = state.data;
    $("name").textContent = state.name;
    document.title = `${state.name} - Gen Art studio`;
    const watches = document.body.dataset.editor === "false";
    $("saved").textContent = watches ? "another page edits this preset; this one watches" : state.file === null ? "a preset of gen-art, not saved" : state.saved ? `${state.file}, saved` : `${state.file}, changed`;
    $("save").disabled = state.saved;
    $("undo").disabled = !state.undo;
    $("redo").disabled = !state.redo;
    this.#problem(state.problems.map((one) => `${one.path ? `${one.path}: ` : ""}${one.text}`).join("\n"));
    this.#editor.show(state.text, state.problems);
    this.#controls.show(state);
    this.#steer.take(state);
    this.#view.take(state.data);
  }

  // Whether somebody steers: then nothing else on the page takes keys or the mouse.
  #steered(on) {
    const edits = document.body.dataset.editor !== "false";
    if (on && this.#view.playing) this.#view.toggle(false);
    this.#steer.turn(on, edits);
    for (const part of ["aside", "header"]) document.querySelector(part).inert = on || !edits;
    $("transport").inert = on;
  }

  #shown(shown) {
    document.body.dataset.exact = shown.exact;
    if (this.#first) this.notice("");
    this.#first = false;
    this.#steer.show(shown.steered);
    if (!shown.exact) this.notice("not a frame of the film yet: the particles go on from where they were");
    this.#plots.take(shown, $("picture"));
  }

  #problem(words, isWarning = false) {
    $("problem").classList.toggle("warning", isWarning);
    $("problem").textContent = words;
    $("problem").hidden = words === "";
  }

  #buttons() {
    for (const type of ["undo", "redo", "save"]) $(type).onclick = () => this.#ask(type);
    const choose = (id, action) => { $(id).onclick = () => { $("export").open = false; action(); }; };
    choose("final", () => { this.#editor.flush(); this.#flush(); this.#connection.send({ type: "final", frame: this.#view.frame }); });
    choose("copy-yaml", () => this.#copy(this.#document.text, "the YAML"));
    choose("copy-command", () => this.#copy(this.#command(), "the command", true));
    choose("copy-python", () => this.#copy(this.#python(), "the Python lines", true));
  }

  // Undo, redo or save, after all that was typed and turned has been sent.
  #ask(type) {
    if (document.activeElement !== $("text")) document.activeElement?.blur?.();
    this.#editor.flush();
    this.#flush();
    this.#connection.send({ type });
  }

  #time() { return Number((this.#view.frame / (Number(this.data.clock?.fps) || 30)).toFixed(6)); }
  #source() { return this.#document.file ?? this.#document.name; }
  #command() { return `gen-art still '${this.#source()}' --time ${this.#time()} -o '${this.#document.name}.png'`; }
  #python() { return `import gen_art as ga\n\nga.still("${this.#source()}", "${this.#document.name}.png", ${this.#time()})`; }

  async #copy(text, what, ofFile = false) {
    if (ofFile && !this.#document.saved) {
      this.#problem(this.#document.file === null
        ? "the command would make the preset as it is shipped: copy the YAML, and save it as a file of your own"
        : "the command would make what the file holds: save first");
      return;
    }
    try {
      await navigator.clipboard.writeText(text);
      this.notice(`copied ${what}`);
    } catch {
      this.#problem(`the browser lets nothing be copied; here is ${what}:\n${text}`);
    }
  }

  #download(message) {
    const bytes = Uint8Array.from(atob(message.png), (letter) => letter.charCodeAt(0));
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([bytes], { type: "image/png" }));
    link.download = message.name;
    link.click();
    URL.revokeObjectURL(link.href);
    this.notice(`rendered ${message.name}`);
  }

  #tabs() {
    const tabs = [...document.querySelectorAll("[role=tab]")];
    const choose = (tab) => {
      for (const one of tabs) {
        one.setAttribute("aria-selected", one === tab);
        one.tabIndex = one === tab ? 0 : -1;
        $(one.getAttribute("aria-controls")).hidden = one !== tab;
      }
      this.#connection.send({ type: "view", diagnosed: this.#plots.isOpen });
      this.#plots.clear();
    };
    for (const tab of tabs) {
      tab.onclick = () => choose(tab);
      tab.onkeydown = (event) => {
        const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
        if (step === undefined) return;
        const next = tabs[(tabs.indexOf(tab) + step + tabs.length) % tabs.length];
        choose(next);
        next.focus();
        event.preventDefault();
        event.stopPropagation();
      };
    }
  }

  #key(event) {
    if (document.body.dataset.steering === "true") return;
    const control = event.ctrlKey || event.metaKey;
    if (control && event.key === "s") { event.preventDefault(); this.#ask("save"); return; }
    if (event.target.matches("input, textarea, select, button, summary, [role=tab]")) return;
    const actions = {
      " ": () => this.#view.toggle(), ArrowLeft: () => this.#view.go(this.#view.frame - 1), ArrowRight: () => this.#view.go(this.#view.frame + 1),
      Home: () => this.#view.go(0), End: () => this.#view.go(this.#view.frames - 1),
    };
    if (control && event.key === "z") { event.preventDefault(); this.#ask("undo"); }
    else if (control && event.key === "y") { event.preventDefault(); this.#ask("redo"); }
    else if (!control && !event.shiftKey && actions[event.key]) { event.preventDefault(); actions[event.key](); }
  }
}

new Studio().start();
