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
  /** Counts what was drawn by all workers: one that has begun anew counts from the start. */
  #revision = 0;
  #worker = null;
  #gone = new Error("another model is made");

  listen(told) {
    this.#told = told;
  }

  /** Makes another model; what was being done for the one before is given up. */
  async make(text) {
    if (this.#status.is_working) this.#end(this.#gone);
    this.#say({ is_working: true });
    try {
      const problem = JSON.parse(new TextDecoder().decode(await this.#ask({ ask: "make", text })));
      this.#say({ is_working: false, problem });
    } catch (error) {
      if (error !== this.#gone) this.#say({ is_working: false, problem: { message: error.message } });
    }
  }

  async scene() {
    return this.#drawn && { ...unpack(this.#drawn), revision: this.#revision };
  }

  async account() {
    return { ...(await this.#json({ ask: "account" })), revision: this.#revision };
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

  #say(changes) {
    this.#status = { ...this.#status, ...changes };
    this.#told(this.#status);
  }

  async #json(question) {
    return JSON.parse(new TextDecoder().decode(await this.#ask(question)));
  }

  #ask(question) {
    return new Promise((done, fail) => {
      const id = ++this.#count;
      this.#asked.set(id, { done, fail });
      this.#worker ??= this.#begin();
      this.#worker.then((worker) => worker.postMessage({ id, question }), (error) => this.#end(error));
    });
  }

  async #begin() {
    const compiled = await this.#compiled;
    const worker = new Worker("worker.js", { type: "module" });
    worker.onerror = () => this.#end(new Error("the page's worker.js does not run"));
    worker.onmessage = ({ data: { drawn, id, answer, problem, isBroken } }) => {
      if (drawn) {
        this.#drawn = drawn;
        this.#say({ revision: ++this.#revision });
        return;
      }
      // What has broken off does not answer again.
      if (isBroken) return this.#end(new Error(`the work broke off: ${problem}`));
      const { done, fail } = this.#asked.get(id);
      this.#asked.delete(id);
      if (answer) done(answer);
      else fail(new Error(problem));
    };
    worker.postMessage({ compiled });
    return worker;
  }

  /** Gives up all that is asked; what is asked next begins another worker. */
  #end(why) {
    // (Nor is heard what it had sent before.)
    this.#worker?.then((worker) => Object.assign(worker, { onmessage: null }).terminate(), () => {});
    this.#worker = null;
    for (const { fail } of this.#asked.values()) fail(why);
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
