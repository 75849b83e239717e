// Questions to the program that serves the page.
import { unpack } from "./scene.js";

async function asked(path, body) {
  const options = body === undefined ? {} : {
    method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(body),
  };
  const response = await fetch(path, options);
  if (!response.ok) throw new Error((await response.text()) || `${response.status} ${response.statusText}`);
  return response;
}

export class Server {
  /** Calls back with each status, and with null where the program has ended. */
  listen(told) {
    const events = new EventSource("events");
    events.onmessage = ({ data }) => told(JSON.parse(data));
    events.onerror = () => told(null);
  }

  async scene() {
    const response = await asked("scene");
    return response.status === 204 ? null : unpack(await response.arrayBuffer());
  }

  async account() {
    return (await asked("account")).json();
  }

  async describe(revision, pick) {
    return (await asked("describe", { revision, pick })).json();
  }

  async between(revision, picks) {
    return (await asked("between", { revision, picks })).json();
  }

  async parameters(values) {
    await asked("parameters", values);
  }

  async file(format) {
    return (await asked(`download/${format}`)).blob();
  }
}
