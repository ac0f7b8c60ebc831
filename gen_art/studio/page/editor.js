// The YAML pane: the text with numbers of its lines, and the problems at theirs.

export class Editor {
  #text = document.getElementById("text");
  #lines = document.getElementById("lines");
  #problems = document.getElementById("problems");
  #pause = 0;
  #sent = "";
  #unsent = null; // what sends the text that was typed last

  constructor(studio) {
    this.#text.addEventListener("input", () => {
      this.#number([]);
      clearTimeout(this.#pause);
      this.#unsent = () => {
        this.#unsent = null;
        this.#sent = this.#text.value;
        studio.write(this.#text.value);
      };
      this.#pause = setTimeout(() => this.flush(), 300);
    });
    this.#text.addEventListener("scroll", () => { this.#lines.scrollTop = this.#text.scrollTop; });
    this.#text.addEventListener("keydown", (event) => {
      if (event.key === "Tab" && !event.shiftKey && !event.ctrlKey && !event.altKey && this.#text.selectionStart !== this.#text.selectionEnd) {
        event.preventDefault();
        document.execCommand("insertText", false, "  ");
      }
    });
  }

  // Send what was typed and is not sent yet.
  flush() {
    clearTimeout(this.#pause);
    this.#unsent?.();
  }

  show(text, problems) {
    if (this.#unsent !== null) return; // of a text that is being typed on
    if (this.#text.value !== text) {
      const [start, end, top] = [this.#text.selectionStart, this.#text.selectionEnd, this.#text.scrollTop];
      this.#text.value = text;
      this.#text.setSelectionRange(start, end);
      this.#text.scrollTop = top;
    }
    this.#sent = this.#text.value;
    this.#number(problems.map((problem) => problem.line));
    this.#problems.replaceChildren(...problems.map((problem) => this.#problem(problem)));
  }

  #number(bad) {
    const count = this.#text.value.split("\n").length;
    this.#lines.replaceChildren(...Array.from({ length: count }, (_, k) => {
      const line = document.createElement("span");
      line.textContent = `${k + 1}\n`;
      if (bad.includes(k + 1)) line.className = "bad";
      return line;
    }));
    this.#lines.scrollTop = this.#text.scrollTop;
  }

  #problem(problem) {
    const item = document.createElement("li");
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = `${problem.line ? `line ${problem.line}: ` : ""}${problem.path ? `${problem.path}: ` : ""}${problem.text}`;
    button.onclick = () => this.#go(problem.line, problem.column);
    item.append(button);
    return item;
  }

  #go(line, column) {
    const before = this.#text.value.split("\n").slice(0, Math.max(0, line - 1));
    const at = before.reduce((sum, one) => sum + one.length + 1, 0) + Math.max(0, column - 1);
    this.#text.focus();
    this.#text.setSelectionRange(at, at);
    this.#text.scrollTop = (line - 6) * 18;
  }
}
