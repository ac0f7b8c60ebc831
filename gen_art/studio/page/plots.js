// Live plots: the tones of the picture, and energy, momentum and count from picture to picture.

const LENGTH = 360;

export class Plots {
  #panel = document.getElementById("plots");
  #series = { energy: [], momentum: [], count: [] };
  #scratch = document.createElement("canvas");

  get isOpen() { return !this.#panel.hidden; }

  clear() {
    for (const values of Object.values(this.#series)) values.length = 0;
  }

  take(shown, picture) {
    if (!this.isOpen) return;
    this.#histogram(picture);
    if (shown.diagnostics === undefined) return;
    const { energy, momentum, count } = shown.diagnostics;
    this.#add("energy", energy);
    this.#add("momentum", momentum);
    this.#add("count", count);
  }

  #add(name, value) {
    if (typeof value !== "number") return; // infinite, which JSON has no number for
    const values = this.#series[name];
    values.push(value);
    if (values.length > LENGTH) values.shift();
    document.getElementById(`${name}-now`).textContent = name === "count" ? value.toLocaleString("en") : value.toPrecision(6);
    const canvas = document.getElementById(name);
    const pen = canvas.getContext("2d");
    const [low, high] = [Math.min(...values), Math.max(...values)];
    const reach = high - low || Math.abs(high) || 1;
    pen.clearRect(0, 0, canvas.width, canvas.height);
    pen.strokeStyle = "#e8a34a";
    pen.lineWidth = 1.5;
    pen.beginPath();
    values.forEach((one, k) => pen.lineTo(k, canvas.height - 8 - ((one - low) / reach) * (canvas.height - 16)));
    pen.stroke();
  }

  #histogram(picture) {
    const [width, height] = [160, Math.max(1, Math.round((160 * picture.height) / picture.width))];
    this.#scratch.width = width;
    this.#scratch.height = height;
    const small = this.#scratch.getContext("2d", { willReadFrequently: true });
    small.drawImage(picture, 0, 0, width, height);
    const pixels = small.getImageData(0, 0, width, height).data;
    const canvas = document.getElementById("histogram");
    const pen = canvas.getContext("2d");
    pen.clearRect(0, 0, canvas.width, canvas.height);
    pen.globalCompositeOperation = "lighter";
    ["#c0392b", "#27ae60", "#2e6fd8"].forEach((colour, channel) => {
      const counts = new Array(64).fill(0);
      for (let k = channel; k < pixels.length; k += 4) counts[pixels[k] >> 2] += 1;
      const most = Math.log1p(width * height);
      pen.fillStyle = colour;
      counts.forEach((count, k) => {
        const tall = (Math.log1p(count) / most) * canvas.height;
        pen.fillRect((k * canvas.width) / 64, canvas.height - tall, canvas.width / 64, tall);
      });
    });
    pen.globalCompositeOperation = "source-over";
  }
}
