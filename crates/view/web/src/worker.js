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
    self.postMessage({ id, problem: error.message });
  }
};
