// The websocket to the studio: messages as JSON, pictures as bytes, and a new try when it breaks.

const token = new URLSearchParams(location.search).get("token") ?? "";

export class Connection extends EventTarget {
  #socket = null;
  #pause = 250;

  open() {
    const socket = new WebSocket(`ws://${location.host}/ws?token=${encodeURIComponent(token)}`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => { this.#pause = 250; this.#say("connected"); };
    socket.onmessage = (event) => this.#take(event.data);
    socket.onclose = () => {
      this.#socket = null;
      this.#say("lost");
      setTimeout(() => this.open(), this.#pause);
      this.#pause = Math.min(4000, this.#pause * 1.6);
    };
    this.#socket = socket;
  }

  send(message) {
    if (this.#socket?.readyState === WebSocket.OPEN) this.#socket.send(JSON.stringify(message));
  }

  #take(data) {
    if (typeof data === "string") {
      const message = JSON.parse(data);
      this.#say(message.type, message);
      return;
    }
    const length = new DataView(data).getUint32(0);
    const header = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
    this.#say("picture", { ...header, picture: new Blob([new Uint8Array(data, 4 + length)], { type: "image/jpeg" }) });
  }

  #say(type, detail = {}) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }
}

export async function fetchSchema() {
  const answer = await fetch(`schema.json?token=${encodeURIComponent(token)}`);
  return answer.json();
}
