"use strict";
const pieces = JSON.parse(document.getElementById("pieces").textContent);
const tiles = [...document.querySelectorAll(".tile")];
const dialog = document.querySelector("dialog");
const still = dialog.querySelector("img");
const film = dialog.querySelector("video");
const play = dialog.querySelector("[data-play]");
const calm = matchMedia("(prefers-reduced-motion: reduce)");
const points = matchMedia("(hover: hover)");
let shown = 0;

// On the wall a loop is loaded when it is first wanted, and shown once it moves.
function start(tile) {
  if (calm.matches) return;
  const loop = tile.querySelector("video");
  if (!loop.src) loop.src = loop.dataset.source;
  tile.wanted = true;
  loop.play().then(() => tile.classList.toggle("moves", tile.wanted)).catch(() => {});
}

function stop(tile) {
  tile.wanted = false;
  tile.classList.remove("moves");
  tile.querySelector("video").pause();
}

// Where nothing can point, what stands wholly in sight moves.
const sight = new IntersectionObserver((entries) => {
  for (const entry of entries) if (!points.matches) (entry.isIntersecting ? start : stop)(entry.target);
}, { threshold: 0.95 });

for (const tile of tiles) {
  tile.addEventListener("pointerenter", (event) => { if (event.pointerType === "mouse") start(tile); });
  tile.addEventListener("pointerleave", () => { if (points.matches) stop(tile); });
  tile.addEventListener("focus", () => { if (points.matches && tile.matches(":focus-visible")) start(tile); });
  tile.addEventListener("blur", () => { if (points.matches) stop(tile); });
  tile.addEventListener("click", (event) => {
    if (event.ctrlKey || event.metaKey || event.shiftKey) return;
    event.preventDefault();
    open(Number(tile.dataset.number));
  });
  sight.observe(tile);
}

function halt() {
  film.pause();
  film.hidden = true;
  still.hidden = false;
  play.textContent = "Play";
}

function move() {
  if (!film.src.endsWith(pieces[shown].loop)) film.src = pieces[shown].loop;
  film.hidden = false;
  still.hidden = true;
  play.textContent = "Still";
  film.play().catch(() => {});
}

function open(number) {
  shown = (number + pieces.length) % pieces.length;
  const piece = pieces[shown];
  halt();
  still.src = piece.still;
  still.alt = piece.shows;
  film.poster = piece.still;
  dialog.querySelector("h2").textContent = piece.title;
  for (const part of dialog.querySelectorAll("[data-text]")) part.textContent = piece[part.dataset.text];
  dialog.scrollTop = 0;
  if (!dialog.open) {
    tiles.forEach(stop);
    dialog.showModal();
  }
  history.replaceState(null, "", "#" + piece.name);
}

dialog.addEventListener("close", () => {
  halt();
  history.replaceState(null, "", location.pathname + location.search);
  tiles[shown].focus({ focusVisible: false });
});
dialog.addEventListener("keydown", (event) => {
  const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
  if (!step || event.altKey || event.target.closest("pre, video")) return;
  event.preventDefault();
  open(shown + step);
});
dialog.addEventListener("click", (event) => {
  const button = event.target.closest("button");
  if (!button) return;
  if (button.dataset.step) open(shown + Number(button.dataset.step));
  else if ("close" in button.dataset) dialog.close();
  else if ("play" in button.dataset) film.hidden ? move() : halt();
  else copy(button);
});

// A page from the file system may not be allowed to write to the clipboard: then the text is selected instead.
async function copy(button) {
  const text = button.parentElement.querySelector("pre");
  try {
    await navigator.clipboard.writeText(text.textContent);
    button.textContent = "Copied";
  } catch {
    getSelection().selectAllChildren(text);
    button.textContent = "Selected";
  }
  setTimeout(() => { button.textContent = "Copy"; }, 1500);
}

// An address with a piece's name opens it.
function follow() {
  const named = pieces.findIndex((piece) => "#" + piece.name === location.hash);
  if (named >= 0) open(named);
  else if (dialog.open) dialog.close();
}
addEventListener("hashchange", follow);
follow();
