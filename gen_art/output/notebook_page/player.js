// The page's half of ga.play: a picture, a slider of the film, the seed and the knobs.

function element(parent, tag, more = {}) {
  const one = Object.assign(document.createElement(tag), more);
  parent.append(one);
  return one;
}

function labelled(parent, text, input) {
  const label = element(parent, "label", { textContent: `${text} ` });
  label.append(input);
  return label;
}

function render({ model, el }) {
  const root = element(el, "div", { className: "gen-art-player" });
  const [width, height] = model.get("_size");
  const picture = element(root, "img", { width, height, alt: model.get("_title") });
  const problem = element(root, "p", { className: "problem" });
  problem.setAttribute("role", "alert");

  const bar = element(root, "div", { className: "bar" });
  const play = element(bar, "button", { type: "button", textContent: "▶", title: "play the film" });
  const slider = element(bar, "input", { type: "range", min: 0, max: model.get("_frames") - 1, step: 1 });
  slider.setAttribute("aria-label", "frame");
  const time = element(bar, "output");
  const seed = document.createElement("input");
  Object.assign(seed, { type: "number", min: 0, step: 1 });
  labelled(bar, "seed", seed);
  const dice = element(bar, "button", { type: "button", textContent: "⚄", title: "another seed" });

  const knobs = element(root, "div", { className: "knobs" });
  const values = new Map();
  for (const { name, low, high, step, unit } of model.get("_sliders")) {
    const input = document.createElement("input");
    Object.assign(input, { type: "range", min: low, max: high, step });
    const label = labelled(knobs, name, input);
    const output = element(label, "output");
    const say = (value) => { output.textContent = `${Number(value.toPrecision(3))} ${unit}`.trim(); };
    input.oninput = () => say(Number(input.value));
    input.onchange = () => send("knobs", { ...model.get("knobs"), [name]: Number(input.value) });
    values.set(name, { input, say });
  }

  let playing = false, asked = 0, address = null, timer = null;

  function send(name, value) {
    if (name !== "frame") root.setAttribute("aria-busy", "true");  // until its picture is there
    model.set(name, value);
    model.save_changes();
  }

  function ask(frame) {
    asked = performance.now();
    if (frame === model.get("frame")) return;
    send("frame", frame);
  }

  function next() {
    timer = null;
    if (playing) ask((model.get("_shown") + 1) % model.get("_frames"));
  }

  function pause() {
    playing = false;
    clearTimeout(timer);
    play.textContent = "▶";
  }

  function showPicture() {
    root.removeAttribute("aria-busy");
    const before = address;
    address = URL.createObjectURL(new Blob([model.get("picture")], { type: "image/jpeg" }));
    picture.src = address;
    if (before) URL.revokeObjectURL(before);
    const shown = model.get("_shown");
    if (document.activeElement !== slider || playing) slider.value = shown;
    time.textContent = `${(shown / model.get("_fps")).toFixed(2)} s`;
    // the next frame is asked for when this one is there: what the machine cannot draw in time is played more slowly
    if (playing) timer = setTimeout(next, Math.max(0, 1000 / model.get("_fps") - (performance.now() - asked)));
  }

  function showNumbers() {
    seed.value = model.get("seed");
    for (const [name, { input, say }] of values) {
      input.value = model.get("knobs")[name];  // which the slider may round to its steps
      say(model.get("knobs")[name]);
    }
  }

  function showProblem() {
    problem.textContent = model.get("problem");
    if (!problem.textContent) return;
    root.removeAttribute("aria-busy");
    pause();
  }

  play.onclick = () => {
    if (playing) { pause(); return; }
    playing = true;
    play.textContent = "❚❚";
    next();
  };
  slider.oninput = () => { pause(); ask(Number(slider.value)); };
  seed.onchange = () => {
    if (/^\d+$/.test(seed.value) && Number.isSafeInteger(Number(seed.value))) send("seed", Number(seed.value));
    else showNumbers();
  };
  dice.onclick = () => send("seed", Math.floor(Math.random() * 2 ** 31));

  const changes = {
    "change:_drawn": showPicture, "change:seed": showNumbers, "change:knobs": showNumbers, "change:problem": showProblem,
  };
  for (const [event, act] of Object.entries(changes)) model.on(event, act);
  showPicture();
  showNumbers();
  showProblem();
  return () => {
    pause();
    for (const [event, act] of Object.entries(changes)) model.off(event, act);
    URL.revokeObjectURL(address);
  };
}

export default { render };
