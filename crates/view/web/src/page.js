import { WebGLRenderer } from "three";
import { Cameras } from "./camera.js";
import { Drawing } from "./drawing.js";
import { Parameters, Tree, element, problem, rows } from "./panels.js";

const byId = (id) => document.getElementById(id);
const canvas = byId("canvas");
/** Who makes models and knows about them: a program that serves the page, or a worker. */
let server;
const renderer = rendering();
const drawing = new Drawing(renderer);
// (`answers` counts what was said of picks.)
const state = { answers: 0, model: null, account: null, picks: [], measured: [], kept: [], counts: "", cut: { isCut: false, axis: "y", share: 0, isTurned: true } };

function rendering() {
  try {
    return new WebGLRenderer({ canvas, antialias: true, stencil: true, preserveDrawingBuffer: true });
  } catch (error) {
    problem({ message: `This browser cannot draw in 3D (it needs WebGL 2): ${error.message}` });
    throw error;
  }
}

// Drawing, once for all that changed since the last frame.
/** Milliseconds without a move of the camera until all triangles are drawn again. */
const REST = 200;
let isWaiting = false;
let isMoving = false;
let rest = null;
function changed(hasMoved = false) {
  isMoving ||= hasMoved;
  if (isWaiting) return;
  isWaiting = true;
  requestAnimationFrame(() => {
    isWaiting = false;
    clearTimeout(rest);
    if (isMoving) {
      drawing.drawMoving(cameras.current);
      if (drawing.coarseness) rest = setTimeout(changed, REST);
    } else {
      drawing.draw(cameras.current);
    }
    isMoving = false;
    if (!state.model) return;
    for (const picture of document.querySelectorAll(".first")) picture.remove();
    document.documentElement.dataset.revision = String(state.model.revision);
    drawing.measure(cameras.current);
  });
}
const cameras = new Cameras(canvas, () => changed(true));

function resized() {
  const { clientWidth: width, clientHeight: height } = byId("stage");
  if (!width || !height) return;
  renderer.setPixelRatio(window.devicePixelRatio);
  renderer.setSize(width, height, false);
  cameras.resized(width, height);
}
new ResizeObserver(resized).observe(byId("stage"));
resized();

const dark = window.matchMedia("(prefers-color-scheme: dark)");
const themed = () => { drawing.theme(dark.matches); changed(); };
dark.addEventListener("change", themed);
themed();

// What the server tells.
const tree = new Tree((hidden) => { drawing.hide(hidden); changed(); }, (pick) => picked(pick, false));
const parameters = new Parameters((values) => {
  Object.assign(wished, values);
  wish();
});
const wished = {};
let isWishing = false;
async function wish() {
  // One question at a time: a slider that is dragged asks for many.
  if (isWishing) return;
  isWishing = true;
  while (Object.keys(wished).length) {
    const values = { ...wished };
    for (const name of Object.keys(values)) delete wished[name];
    await server.parameters(values).catch((error) => problem({ message: error.message }));
  }
  isWishing = false;
}

let newest = 0;
let isLoading = false;
async function load() {
  if (isLoading) return;
  isLoading = true;
  while (newest > (state.model?.revision ?? 0)) {
    const model = await server.scene().catch(() => null);
    if (!model) break;
    show(model);
    if (model.is_coarse) continue;
    await measureAgain();
    const account = await server.account().catch(() => null);
    if (!account || account.revision === state.model.revision) tell(account);
  }
  isLoading = false;
}

function show(model) {
  const isFirst = !state.model || state.isToFit;
  state.isToFit = false;
  const before = state.model;
  state.model = model;
  byId("name").textContent = document.title = model.name;
  cameras.sized(model.radius);
  drawing.show(model);
  tree.show(model);
  if (isFirst) {
    cameras.look("corner");
    cameras.fit();
  } else if (model.center.some((x, k) => x !== before.center[k])) {
    // Places are about the model's middle: the eye stays where it is in the model.
    const by = before.center.map((x, k) => x - model.center[k]);
    for (const place of [cameras.controls.target, cameras.current.position]) {
      place.set(place.x + by[0], place.y + by[1], place.z + by[2]);
    }
    cameras.controls.update();
  }
  cut();
  picks([]);
  byId("picked").replaceChildren(element("p", { textContent: "Nothing yet." }));
  measuresAreOld(true);
  byId("warnings").replaceChildren(...model.warnings.map((textContent) => element("li", { textContent })));
  changed();
}

/** Whether measures and report are of a model that was shown before. */
function measuresAreOld(areOld) {
  for (const id of ["measures", "report"]) byId(id).setAttribute("aria-busy", String(areOld));
}

function tell(account) {
  state.account = account;
  rows(byId("measures"), account?.measures ?? [{ label: "", text: "They could not be told." }]);
  rows(byId("report"), account?.report ?? []);
  measuresAreOld(false);
  mass();
}

function mass() {
  const { account } = state;
  const density = byId("density").valueAsNumber;
  byId("mass").textContent = "";
  if (!account || !(density >= 0)) return;
  // From grams a cubic centimetre, which is a millionth of a cubic metre.
  const factor = density * (100 * account.metres) ** 3;
  // (Rounded up.)
  const bound = (error) => (error + 0.5 * 10 ** Math.floor(Math.log10(error))).toExponential(0);
  const error = account.volume_error ? ` ± ${bound(factor * account.volume_error)}` : "";
  const digits = account.volume_error ? Math.min(15, Math.max(1, Math.floor(Math.log10(Math.abs(account.volume) / account.volume_error)))) : 9;
  byId("mass").textContent = `Mass ${Number((factor * account.volume).toPrecision(digits))}${error} g`;
}
byId("density").oninput = mass;

function heard(status) {
  if (!status) {
    byId("state").textContent = "The program has ended.";
    return;
  }
  byId("state").textContent = status.is_working ? "Meshing…" : status.problem ? "There is a mistake." : "";
  problem(status.problem);
  parameters.show(status.parameters, status.values);
  newest = status.revision;
  load();
}
/** Shows all of the next model, whatever its size. */
export function fit() {
  state.isToFit = true;
}
export function start(answering) {
  server = answering;
  server.listen(heard);
  // What is there already need not wait for being told of.
  newest ||= 1;
  load();
}

// Picking and measuring.
function picks(list) {
  state.picks = list;
  state.measured = [];
  drawing.pick(list);
  dimensions();
}

async function picked(pick, isSecond) {
  await say(pick, isSecond);
  state.answers++;
}

async function say(pick, isSecond) {
  const { model } = state;
  if (!model) return;
  const box = byId("picked");
  if (!pick) {
    picks([]);
    box.replaceChildren(element("p", { textContent: "Nothing." }));
    return;
  }
  const list = isSecond && state.picks.length ? [state.picks.at(-1), pick] : [pick];
  picks(list);
  if (!model.is_exact) {
    const said = model.is_coarse ? "The exact boundary is not there yet." : "There is no exact boundary to ask.";
    const face = pick.kind === "face" ? model.faces[pick.id] : null;
    box.replaceChildren(element("p", { textContent: face ? `${model.parts[face.part].name}: ${face.kind}. ${said}` : said }));
    return;
  }
  try {
    const plain = list.map(({ kind, id }) => ({ kind, id }));
    const answers = await Promise.all([
      ...plain.map((one) => server.describe(model.revision, one)),
      ...(plain.length === 2 ? [server.between(model.revision, plain)] : []),
    ]);
    if (state.picks !== list) return;
    // Of two picks what is between them, and of one what it measures itself.
    const row = answers.at(-1).find(({ dimension }) => dimension);
    state.measured = row ? [measured(plain, row)] : [];
    dimensions();
    const titles = plain.length === 2 ? ["First", "Second", "Between them"] : [""];
    box.replaceChildren(...answers.flatMap((answer, k) => {
      const table = element("table", { "aria-label": titles[k] || "Picked" });
      const of = plain.length === 2 && k < 2 ? [plain[k]] : plain;
      rows(table, answer.length ? answer : [{ label: "", text: "Nothing can be measured between these." }], (row) => keep(measured(of, row)));
      return titles[k] ? [element("h3", { textContent: titles[k] }), table] : [table];
    }));
  } catch (error) {
    if (state.picks === list) box.replaceChildren(element("p", { textContent: `It could not be told: ${error.message}` }));
  }
}

// Dimensions: those of what is shown, of what is picked, and the ones that are kept.
/** The share of the picture that they may need around the model. */
const ROOM = 0.14;
const isDimensioned = () => byId("dimensions").getAttribute("aria-pressed") === "true";
const measured = (picks, { label, text, value, dimension }) => ({ ...dimension, picks, label, text, value });

function dimensions() {
  drawing.dimensions.isShown = isDimensioned();
  const keys = new Set(state.kept.map(keyOf));
  drawing.dimensions.measured = [...state.kept, ...state.measured.filter((one) => !keys.has(keyOf(one)))];
  changed();
}

const keyOf = ({ picks, label }) => JSON.stringify([picks, label]);

function toggleDimensions() {
  cameras.leave(toggle("dimensions") ? ROOM : 0);
  dimensions();
}
byId("dimensions").onclick = toggleDimensions;

function keep(one) {
  if (!state.kept.some((other) => keyOf(other) === keyOf(one))) state.kept.push(one);
  if (!isDimensioned()) toggleDimensions();
  listKept();
}

function listKept() {
  byId("kept-section").hidden = state.kept.length === 0;
  byId("kept").replaceChildren(...state.kept.map((one) => {
    const remove = element("button", { type: "button", textContent: "Remove", "aria-label": `Remove ${one.label}` });
    remove.onclick = () => {
      state.kept = state.kept.filter((other) => other !== one);
      listKept();
    };
    return element("li", {}, element("span", { textContent: `${one.label}: ${one.text}` }), remove);
  }));
  dimensions();
}

/** What is kept, of a model that was made again: none where faces, edges or vertices are others. */
async function measureAgain() {
  const { model } = state;
  const counts = JSON.stringify([model.is_exact, model.faces.length, model.edges.length, model.vertices.length]);
  const kept = counts === state.counts ? state.kept : [];
  state.counts = counts;
  if (!state.kept.length) return;
  const again = await Promise.all(kept.map(async ({ picks, label }) => {
    const answer = picks.length === 2 ? server.between(model.revision, picks) : server.describe(model.revision, picks[0]);
    const row = (await answer.catch(() => [])).find((one) => one.label === label && one.dimension);
    return row ? [measured(picks, row)] : [];
  }));
  if (model !== state.model) return;
  state.kept = again.flat();
  listKept();
}

let pressed = null;
const place = (event) => {
  const box = canvas.getBoundingClientRect();
  return [event.clientX - box.left, event.clientY - box.top];
};
canvas.addEventListener("pointerdown", (event) => {
  pressed = event.button === 0 ? place(event) : null;
});
canvas.addEventListener("pointerup", (event) => {
  const [x, y] = place(event);
  // What was dragged was turned.
  if (pressed && Math.hypot(x - pressed[0], y - pressed[1]) < 4) {
    picked(drawing.at(x, y, cameras.current), event.ctrlKey || event.metaKey);
  }
  pressed = null;
});

// The section plane: by its slider, or dragged in the picture with Alt.
function cut() {
  const { isCut, axis, share, isTurned } = state.cut;
  byId("cut").hidden = !isCut;
  byId("section").setAttribute("aria-pressed", String(isCut));
  if (!state.model) return;
  const { radius, center, unit } = state.model;
  drawing.cut(isCut, axis, share * radius, isTurned);
  // To a millionth of the size: nobody drags it finer.
  const step = 10 ** Math.floor(Math.log10(radius || 1) - 5);
  const at = Math.round((center["xyz".indexOf(axis)] + share * radius) / step) * step;
  byId("cut-at").value = share;
  byId("cut-place").textContent = `${axis} = ${Number(at.toPrecision(9))} ${unit}`;
  changed();
}
function toggleCut() {
  state.cut.isCut = !state.cut.isCut;
  cut();
}
byId("section").onclick = toggleCut;
byId("cut-axis").onchange = ({ target }) => { state.cut.axis = target.value; cut(); };
byId("cut-at").oninput = ({ target }) => { state.cut.share = Number(target.value); cut(); };
byId("cut-turn").onclick = () => { state.cut.isTurned = !state.cut.isTurned; cut(); };
canvas.addEventListener("pointerdown", (event) => {
  if (!event.altKey || !state.cut.isCut || !state.model) return;
  event.stopImmediatePropagation();
  pressed = null;
  canvas.setPointerCapture(event.pointerId);
  // Along the axis as it is seen.
  const along = drawing.plane.normal.clone().set(0, 0, 0);
  along[state.cut.axis] = 1;
  const seen = along.multiplyScalar(state.model.radius).project(cameras.current);
  const middle = drawing.plane.normal.clone().set(0, 0, 0).project(cameras.current);
  const step = [(seen.x - middle.x) * canvas.clientWidth / 2, (middle.y - seen.y) * canvas.clientHeight / 2];
  const square = Math.max(100, step[0] ** 2 + step[1] ** 2);
  const move = ({ movementX, movementY }) => {
    const by = (movementX * step[0] + movementY * step[1]) / square;
    state.cut.share = Math.max(-1, Math.min(1, state.cut.share + by));
    cut();
  };
  canvas.addEventListener("pointermove", move);
  canvas.addEventListener("lostpointercapture", () => canvas.removeEventListener("pointermove", move), { once: true });
}, { capture: true });

// The bar.
for (const button of document.querySelectorAll("[data-view]")) button.onclick = () => cameras.look(button.dataset.view);
byId("fit").onclick = () => cameras.fit();
function toggle(id) {
  const button = byId(id);
  const isOn = button.getAttribute("aria-pressed") !== "true";
  button.setAttribute("aria-pressed", String(isOn));
  return isOn;
}
function toggleParallel() {
  cameras.project(toggle("parallel"));
}
function toggleDrawn(id) {
  toggle(id);
  const [edges, faces] = ["edges", "faces"].map((name) => byId(name).getAttribute("aria-pressed") === "true");
  drawing.showing(edges, faces);
  changed();
}
byId("parallel").onclick = toggleParallel;
byId("edges").onclick = () => toggleDrawn("edges");
byId("faces").onclick = () => toggleDrawn("faces");

function save(blob, name) {
  const link = element("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
function screenshot() {
  drawing.draw(cameras.current);
  canvas.toBlob((blob) => save(blob, `${state.model?.name ?? "model"}.png`));
}
byId("screenshot").onclick = screenshot;
const FORMATS = { step: "STEP, exact", glb: "GLB", gltf: "glTF", "3mf": "3MF", stl: "STL", obj: "OBJ", ply: "PLY", off: "OFF", csg: "scene, .csg" };
byId("download").append(...Object.entries(FORMATS).map(([value, textContent]) => element("option", { value, textContent })));
byId("download").onchange = async ({ target }) => {
  const format = target.value;
  target.value = "";
  if (!format || !state.model) return;
  byId("state").textContent = `Making .${format}…`;
  try {
    save(await server.file(format), `${state.model.name}.${format}`);
    byId("state").textContent = "";
  } catch (error) {
    byId("state").textContent = error.message;
  }
};

// Keys, wherever nothing else takes them: a field, or what Enter presses.
const turnBy = Math.PI / 36;
const keys = {
  1: () => cameras.look("front"), 2: () => cameras.look("back"), 3: () => cameras.look("right"),
  4: () => cameras.look("left"), 5: () => cameras.look("top"), 6: () => cameras.look("bottom"),
  0: () => cameras.look("corner"), Home: () => { cameras.look("corner"); cameras.fit(); }, f: () => cameras.fit(),
  p: toggleParallel, e: () => toggleDrawn("edges"), a: () => toggleDrawn("faces"), x: toggleCut, s: screenshot,
  "+": () => cameras.nearer(1.1), "=": () => cameras.nearer(1.1), "-": () => cameras.nearer(1 / 1.1),
  Escape: () => picked(null), d: toggleDimensions,
  Enter: () => picked(drawing.at(canvas.clientWidth / 2, canvas.clientHeight / 2, cameras.current), false),
};
const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const takes = event.key === "Enter" ? "input, select, textarea, button, summary" : "input:not([type=checkbox]), select, textarea";
  if (event.target.closest?.(takes)) return;
  // (With the shift key or its lock letters are others.)
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  const arrow = arrows[key];
  if (arrow && event.shiftKey) cameras.move(-0.05 * arrow[0], -0.05 * arrow[1]);
  else if (arrow) cameras.turn(turnBy * arrow[0], -turnBy * arrow[1]);
  else if (keys[key]) keys[key]();
  else return;
  event.preventDefault();
});

/** For tests: what is drawn where. */
globalThis.stereotomy = {
  state,
  seen: (point) => {
    cameras.current.updateMatrixWorld();
    const at = drawing.plane.normal.clone().fromArray(point.map((x, k) => x - state.model.center[k])).project(cameras.current);
    return [(at.x + 1) * canvas.clientWidth / 2, (1 - at.y) * canvas.clientHeight / 2];
  },
  eye: () => cameras.current.position.toArray().map((x, k) => x + (state.model?.center[k] ?? 0)),
  drawing,
  camera: () => cameras.current,
  picked: (x, y) => drawing.at(x, y, cameras.current),
  turn: (across) => cameras.turn(across, 0),
  /** Milliseconds a frame takes, drawn and read back, of so many in turn; `isMoving` as in `draw`. */
  frames: (count, isMoving = false) => {
    const gl = renderer.getContext();
    const start = performance.now();
    for (let k = 0; k < count; k++) {
      cameras.turn(0.01, 0);
      drawing.draw(cameras.current, isMoving);
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
    }
    return (performance.now() - start) / count;
  },
};
