// A curve drawn by hand: points that are dragged, added by a double click and removed by another.

export const isCurve = (value) =>
  Array.isArray(value) && value.length > 0 && value.every((point) => Array.isArray(point) && point.length === 2 && point.every((x) => typeof x === "number"));

const NEAR = 9; // pixels

export function curveEditor(value, path, set) {
  const canvas = document.createElement("canvas");
  canvas.className = "curve";
  canvas.width = 320;
  canvas.height = 84;
  canvas.tabIndex = 0;
  canvas.setAttribute("aria-label", `${path}, curve; its numbers are in the YAML`);
  let points = value.map((point) => [...point]);
  const [left, right] = [Math.min(0, points[0][0]), Math.max(1, points.at(-1)[0])];
  const top = Math.max(1e-9, ...points.map((point) => point[1])) * 1.15;
  const bottom = Math.min(0, ...points.map((point) => point[1]));
  const toPixels = ([x, y]) => [6 + ((x - left) / (right - left)) * 308, 78 - ((y - bottom) / (top - bottom)) * 72];
  const toValues = (px, py) => [left + ((px - 6) / 308) * (right - left), bottom + ((78 - py) / 72) * (top - bottom)];
  const round = (x) => Number(x.toPrecision(4));
  let held = -1;

  const paint = () => {
    const pen = canvas.getContext("2d");
    pen.clearRect(0, 0, 320, 84);
    pen.strokeStyle = "#e8a34a";
    pen.lineWidth = 2;
    pen.beginPath();
    pen.moveTo(6, toPixels(points[0])[1]);
    for (const point of points) pen.lineTo(...toPixels(point));
    pen.lineTo(314, toPixels(points.at(-1))[1]);
    pen.stroke();
    pen.fillStyle = "#e6e4df";
    for (const point of points) { pen.beginPath(); pen.arc(...toPixels(point), 4, 0, 7); pen.fill(); }
  };
  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    return [((event.clientX - box.left) * 320) / box.width, ((event.clientY - box.top) * 84) / box.height];
  };
  const nearest = ([px, py]) => points.findIndex((point) => { const [x, y] = toPixels(point); return Math.hypot(x - px, y - py) < NEAR; });

  canvas.onpointerdown = (event) => { held = nearest(place(event)); if (held >= 0) canvas.setPointerCapture(event.pointerId); };
  canvas.onpointermove = (event) => {
    if (held < 0) return;
    let [x, y] = toValues(...place(event));
    const gap = (right - left) / 1000;
    x = Math.max(held > 0 ? points[held - 1][0] + gap : left, Math.min(held < points.length - 1 ? points[held + 1][0] - gap : right, x));
    points[held] = [round(x), round(Math.max(bottom, y))];
    paint();
    set(points, false);
  };
  canvas.onpointerup = canvas.onpointercancel = () => { if (held >= 0) set(points, true); held = -1; };
  canvas.ondblclick = (event) => {
    const at = place(event);
    const found = nearest(at);
    if (found >= 0 && points.length > 1) points.splice(found, 1);
    else if (found < 0) { points.push(toValues(...at).map(round)); points.sort((a, b) => a[0] - b[0]); }
    paint();
    set(points, true);
  };
  paint();
  return canvas;
}
