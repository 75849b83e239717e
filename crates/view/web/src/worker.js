// Answers the playground's questions beside the page.
import { instance } from "./module.js";

let ready;
self.onmessage = async ({ data: { compiled, id, question } }) => {
  if (compiled) {
    ready = instance(compiled, (drawn) => self.postMessage({ drawn }, [drawn]));
    return;
  }
  try {
    const answer = (await ready)(question);
    self.postMessage({ id, answer }, [answer]);
  } catch (error) {
    // (What the module says itself is an `Error`; all others are how it breaks off.)
    self.postMessage({ id, problem: error.message, isBroken: error.constructor !== Error });
  }
};
