// The page without a server: the text is edited here, and the model made in a worker.
import { fit, start } from "./page.js";
import { element } from "./panels.js";
import { unpack } from "./scene.js";

/** Milliseconds without a key after which the model is made again. */
const QUIET = 200;

class Playground {
  #compiled = WebAssembly.compileStreaming(fetch("playground.wasm"));
  #asked = new Map();
  #count = 0;
  #drawn = null;
  #status = { revision: 0, is_working: false, problem: null, parameters: [], values: {} };
  #told = () => {};

  listen(told) {
    this.#told = told;
  }

  /** Makes another model; what was being done for the one before is given up. */
  async make(text) {
    if (this.#status.is_working) this.#end();
    this.#say({ is_working: true });
    try {
      const problem = JSON.parse(new TextDecoder().decode(await this.#ask({ ask: "make", text })));
      this.#say({ is_working: false, problem });
    } catch (error) {
      if (error !== this.#gone) this.#say({ is_working: false, problem: { message: error.message } });
    }
  }

  async scene() {
    // (A worker that has begun anew counts from the start.)
    return this.#drawn && { ...unpack(this.#drawn), revision: this.revision };
  }

  async account() {
    return { ...(await this.#json({ ask: "account" })), revision: this.revision };
  }

  describe(_, pick) {
    return this.#json({ ask: "describe", pick });
  }

  between(_, picks) {
    return this.#json({ ask: "between", picks });
  }

  async file(format) {
    return new Blob([await this.#ask({ ask: "file", format })]);
  }

  #gone = new Error("another model is made");

  #say(changes) {
    this.#status = { ...this.#status, ...changes };
    this.#told(this.#status);
  }

  async #json(question) {
    return JSON.parse(new TextDecoder().decode(await this.#ask(question)));
  }

  async #ask(question) {
    this.worker ??= await this.#begin();
    return new Promise((done, fail) => {
      this.#asked.set(++this.#count, { done, fail });
      this.worker.postMessage({ id: this.#count, question });
    });
  }

  async #begin() {
    const worker = new Worker("worker.js", { type: "module" });
    worker.onmessage = ({ data: { drawn, id, answer, problem } }) => {
      if (drawn) {
        this.#drawn = drawn;
        this.#say({ revision: ++this.revision });
        return;
      }
      const { done, fail } = this.#asked.get(id);
      this.#asked.delete(id);
      if (answer) done(answer);
      else fail(new Error(problem));
      // What has trapped does not answer again.
      if (problem?.includes("unreachable")) this.#end();
    };
    worker.postMessage({ compiled: await this.#compiled });
    return worker;
  }

  revision = 0;

  #end() {
    this.worker?.terminate();
    this.worker = null;
    for (const { fail } of this.#asked.values()) fail(this.#gone);
    this.#asked.clear();
  }
}

const playground = new Playground();
start(playground);
const models = await (await fetch("models.json")).json();
const text = element("textarea", { id: "text", spellcheck: false, "aria-label": "The scene's text" });
const choice = element("select", { "aria-label": "An example" }, ...models.map((name) => element("option", { textContent: name })));
const section = element("section", {}, element("h2", { textContent: "Scene" }), choice, text);
document.querySelector("aside").prepend(section);
let waiting = null;
text.oninput = () => {
  clearTimeout(waiting);
  waiting = setTimeout(() => playground.make(text.value), QUIET);
};
choice.onchange = async () => {
  fit();
  text.value = await (await fetch(`models/${choice.value}.csg`)).text();
  playground.make(text.value);
};
choice.value = models.includes("flange") ? "flange" : models[0];
choice.onchange();
