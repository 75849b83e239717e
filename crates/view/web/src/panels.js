// What stands beside the picture: tables, the tree of parts, parameters, what is wrong.

const byId = (id) => document.getElementById(id);

/** An element with properties, attributes (those with a dash, and role) and children. */
export function element(name, properties = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(properties)) {
    if (key.includes("-") || key === "role" || key === "for") made.setAttribute(key, value);
    else made[key] = value;
  }
  made.append(...children);
  return made;
}

/** Fills a table; with `keep` rows that can be drawn in the picture have a button that hands them on. */
export function rows(table, list, keep = null) {
  table.replaceChildren(...list.map((row) => {
    const value = element("td", {}, element("span", { textContent: row.text }));
    if (keep && row.dimension) {
      const button = element("button", { type: "button", textContent: "Keep", title: "Keep it in the picture", "aria-label": `Keep ${row.label} in the picture` });
      button.onclick = () => keep(row);
      value.append(" ", button);
    }
    return element("tr", {}, element("th", { scope: "row", textContent: row.label }), value);
  }));
}

/** Shows what is wrong with the model, with the lines around. */
export function problem(found) {
  const box = byId("problem");
  box.hidden = !found;
  if (!found) return;
  box.replaceChildren(element("strong", { textContent: found.message }));
  if (!found.place) return;
  const { line, column, excerpt } = found.place;
  const text = element("pre");
  for (const [number, content] of excerpt) {
    const row = `${String(number).padStart(5)} │ ${content}\n`;
    text.append(number === line ? element("mark", { textContent: row }) : row);
    if (number === line && column <= content.length + 1) text.append(element("mark", { textContent: `${" ".repeat(7 + column)}^\n` }));
  }
  box.append(text);
}

/** The tree of parts and faces. */
export class Tree {
  constructor(changed, picked) {
    this.changed = changed;
    this.picked = picked;
    this.hidden = new Set();
    byId("show-all").onclick = () => this.#hide(new Set());
  }

  show(model) {
    const before = new Set([...this.hidden].map((face) => this.#key(face)));
    this.model = model;
    this.faces = model.parts.map(() => []);
    model.faces.forEach((face, k) => this.faces[face.part].push(k));
    // What was hidden stays so, by its part's name and its place among the part's faces.
    this.places = new Map();
    this.faces.forEach((faces, part) => faces.forEach((face, k) => this.places.set(face, `${model.parts[part].name}\n${k}`)));
    this.hidden = new Set([...model.faces.keys()].filter((face) => before.has(this.#key(face))));
    const opened = new Set([...byId("parts").querySelectorAll("details[open]")].map(({ dataset }) => dataset.part));
    byId("parts").replaceChildren(...model.parts.map((part, k) => this.#part(part, k, opened)));
    this.#hide(this.hidden);
  }

  #key(face) {
    return this.places?.get(face);
  }

  #part({ name }, k, opened) {
    const faces = this.faces[k];
    const details = element("details", { open: opened.has(name), "data-part": name },
      element("summary", {}, this.#line(name, `${faces.length} ${faces.length === 1 ? "face" : "faces"}`, faces)));
    details.ontoggle = () => {
      if (!details.open || details.querySelector("ul")) return;
      const shown = faces.slice(0, 500).map((face) => {
        const { kind, radius } = this.model.faces[face];
        const label = radius === null ? kind : `${kind}, radius ${Number(radius.toPrecision(12))}`;
        const line = this.#line(label, "", [face]);
        line.querySelector(".named").onclick = () => this.picked({ kind: "face", id: face });
        return element("li", {}, line);
      });
      if (faces.length > shown.length) shown.push(element("li", { textContent: `and ${faces.length - shown.length} more` }));
      details.append(element("ul", {}, ...shown));
      this.#check();
    };
    return element("li", {}, details);
  }

  #line(name, count, faces) {
    const box = element("input", { type: "checkbox", checked: true, "aria-label": `Show ${name}` });
    box.faces = faces;
    box.onchange = () => {
      const hidden = new Set(this.hidden);
      for (const face of faces) box.checked ? hidden.delete(face) : hidden.add(face);
      this.#hide(hidden);
    };
    const only = element("button", { type: "button", textContent: "Only", "aria-label": `Show only ${name}` });
    only.onclick = (event) => {
      event.preventDefault();
      const shown = new Set(faces);
      this.#hide(new Set([...this.model.faces.keys()].filter((face) => !shown.has(face))));
    };
    const label = count ? element("span", { textContent: name }) : element("button", { type: "button", className: "named", textContent: name });
    return element("span", {}, box, label, element("small", { textContent: count }), only);
  }

  #hide(hidden) {
    this.hidden = hidden;
    this.#check();
    this.changed(hidden);
  }

  #check() {
    for (const box of byId("parts").querySelectorAll("input")) {
      const shown = box.faces.filter((face) => !this.hidden.has(face)).length;
      box.checked = shown > 0;
      box.indeterminate = shown > 0 && shown < box.faces.length;
    }
  }
}

/** Sliders, boxes and choices for the model's parameters. */
export class Parameters {
  constructor(changed) {
    this.changed = changed;
    this.known = "";
    byId("parameters").onsubmit = (event) => event.preventDefault();
  }

  show(parameters, values) {
    const known = JSON.stringify(parameters);
    if (known === this.known) return;
    this.known = known;
    byId("parameters-section").hidden = parameters.length === 0;
    byId("parameters").replaceChildren(...parameters.map((parameter) => this.#field(parameter, values[parameter.name] ?? parameter.default)));
  }

  #field({ name, help, kind, choices, default: usual }, value) {
    const send = (text) => this.changed({ [name]: String(text) });
    const label = element("label", {}, element("span", { textContent: name }));
    if (kind === "flag") {
      const box = element("input", { type: "checkbox", name, checked: value === "true" });
      box.onchange = () => send(box.checked);
      label.append(box);
    } else if (kind === "choice") {
      const list = element("select", { name }, ...choices.map((choice) => element("option", { textContent: choice })));
      list.value = value;
      list.onchange = () => send(list.value);
      label.append(list);
    } else if ((kind === "number" || kind === "integer") && Number.isFinite(Number(usual))) {
      // Up to twice what is usual, the other way too if that is below 0.
      const middle = Number(usual) || 1;
      const [low, high] = [Math.min(0, 2 * middle), Math.max(0, 2 * middle)];
      const step = kind === "integer" ? 1 : 10 ** Math.floor(Math.log10(Math.abs(middle)) - 2);
      const slider = element("input", { type: "range", name, min: low, max: high, step, "aria-label": name });
      const exact = element("input", { type: "number", step: kind === "integer" ? 1 : "any", "aria-label": `${name}, as a number` });
      slider.value = exact.value = value;
      slider.oninput = () => { exact.value = slider.value; send(slider.value); };
      exact.onchange = () => { slider.value = exact.value; send(exact.value); };
      label.append(exact, slider);
    } else {
      const text = element("input", { type: "text", name, value });
      text.onchange = () => send(text.value);
      label.append(text);
    }
    if (help) label.append(element("small", { textContent: help }));
    return label;
  }
}
