// Dimensions in the picture, as in the drawings that `csg drawing` makes: lines beside the model
// with arrows, and a number of one size that is read from the left, or upwards. They are laid out
// anew for each frame, where they are seen best.
import {
  BufferAttribute, BufferGeometry, CanvasTexture, GreaterDepth, Group, LineBasicMaterial, LineSegments,
  SRGBColorSpace, Sprite, SpriteMaterial, Vector3,
} from "three";

/** In pixels: how far lines are from the model, those of its size beyond the others, and from one another; how long
 * arrows are, and how high numbers. */
const OUTER = 50;
const INNER = 24;
const ROW = 24;
const ARROW = 10;
/** How far from what is measured the lines begin that lead to a dimension, and how far beyond it they end. */
const GAP = 6;
const HEIGHT = 14;
/** What goes less than this to the side, of its length, is steep; what goes less than this to the eye is seen from its side. */
const STEEP = 0.3;
/** The least length of a line that is drawn: in pixels, and as a part of what it would be if it were seen from its side. */
const SHORTEST = 8;
const FLATTEST = 0.15;
const FONT = `600 ${HEIGHT}px system-ui, sans-serif`;
/** In so many rows it is tried to lay a dimension out where no other one is in its way. */
const ROWS = 9;
/** How many pixels of a number's texture are one of the page. */
const FINE = 2;
/** An arc is of so many chords. */
const CHORDS = 24;
/** The radius of an angle's arc. */
const ARC = 90;
/** Where a diameter is told: to the right and upwards, or as far around from there as a row says. */
const SLANT = 1.08;
const AROUND = 0.6;
/** The colours of sizes, which are those of drawings, and of what is picked or kept. */
const COLORS = { light: ["#2a5caa", "#a33b00"], dark: ["#8fbcff", "#ffb877"] };

/** A number as drawings have it: six digits at most. */
function decimal(value) {
  const decimals = Math.min(12, Math.max(0, 5 - Math.floor(Math.log10(Math.abs(value) || 1))));
  return String(Number(value.toFixed(decimals)));
}

/** The text of a dimension, in a unit. */
export function textOf({ kind, value }, unit) {
  if (kind === "angle") return `${decimal(value)}°`;
  if (kind === "circle" || kind === "sphere") return `⌀${decimal(2 * value)} ${unit}`;
  return `${decimal(value)} ${unit}`;
}

/** Where things are in the picture. */
class Picture {
  constructor(camera, width, height) {
    camera.updateMatrixWorld();
    Object.assign(this, { camera, width, height });
    [this.right, this.up, this.back] = [0, 1, 2].map((k) => new Vector3().setFromMatrixColumn(camera.matrixWorld, k));
  }

  /** Its place in pixels, from the left and from the top. */
  seen(point) {
    const { x, y } = point.clone().project(this.camera);
    return [(x + 1) * this.width / 2, (1 - y) * this.height / 2];
  }

  /** How long a pixel is there. */
  pixel(point) {
    const { camera } = this;
    if (camera.isOrthographicCamera) return (camera.top - camera.bottom) / camera.zoom / this.height;
    const depth = Math.max(camera.near, camera.position.clone().sub(point).dot(this.back));
    return 2 * depth * Math.tan(camera.fov * Math.PI / 360) / this.height;
  }

  /** The direction to the eye. */
  toEye(point) {
    return this.camera.isOrthographicCamera ? this.back.clone() : this.camera.position.clone().sub(point).normalize();
  }

  /** A direction as it is seen from a point, in parts of its length; y is downwards. */
  direction(point, along) {
    const step = this.pixel(point);
    const [from, to] = [point, point.clone().addScaledVector(along, step)].map((at) => this.seen(at));
    return [to[0] - from[0], to[1] - from[1]];
  }

  /** A direction in the plane of the picture; y is downwards. */
  across([x, y]) {
    return this.right.clone().multiplyScalar(x).addScaledVector(this.up, -y);
  }
}

/** How wide numbers are, with some room. */
const pen = document.createElement("canvas").getContext("2d");
pen.font = FONT;
const widthOf = (text) => Math.ceil(pen.measureText(text).width) + 8;

const length = ([x, y]) => Math.hypot(x, y);
const cross = ([ax, ay], [bx, by], [cx, cy]) => (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);

/** How far apart two segments are in the picture. */
function apart([a, b], [c, d]) {
  if (cross(a, b, c) * cross(a, b, d) < 0 && cross(c, d, a) * cross(c, d, b) < 0) return 0;
  const toSegment = (p, [q, r]) => {
    const [x, y] = [r[0] - q[0], r[1] - q[1]];
    const share = Math.min(1, Math.max(0, ((p[0] - q[0]) * x + (p[1] - q[1]) * y) / (x * x + y * y || 1)));
    return Math.hypot(q[0] + share * x - p[0], q[1] + share * y - p[1]);
  };
  return Math.min(...[a, b].map((p) => toSegment(p, [c, d])), ...[c, d].map((p) => toSegment(p, [a, b])));
}

const at = (from, along, by) => from.clone().addScaledVector(along, by);

/** What is drawn of a dimension: segments, and where its number is and how it is turned. */
class Layout {
  constructor(picture) {
    this.picture = picture;
    this.segments = [];
    /** The segments that others keep away from. */
    this.kept = [];
    this.label = null;
  }

  /** What others keep away from: segments in the picture, and how far from each. */
  strokes(text) {
    const { place, turn, side } = this.label;
    const half = widthOf(text) / 2;
    const [x, y] = this.picture.seen(place);
    const [across, down] = [Math.cos(turn), -Math.sin(turn)].map((part) => (half - HEIGHT / 2) * part);
    const middle = x + side * half;
    const number = { ends: [[middle - across, y - down], [middle + across, y + down]], off: HEIGHT / 2 };
    const lines = this.kept.map((both) => {
      const [a, b] = both.map((end) => this.picture.seen(end));
      // (They may meet where they end.)
      const inset = Math.min(0.5, 4 / (Math.hypot(b[0] - a[0], b[1] - a[1]) || 1));
      const part = (share) => [0, 1].map((k) => a[k] + share * (b[k] - a[k]));
      return { ends: [part(inset), part(1 - inset)], off: 1 };
    });
    return [number, ...lines];
  }

  line(from, to) {
    this.segments.push(from, to);
  }

  /** An arrow whose tip is there, along a direction that is seen. */
  arrow(tip, along) {
    const size = ARROW * this.picture.pixel(tip);
    const [x, y] = this.picture.direction(tip, along).map((part, _, all) => part / (length(all) || 1));
    for (const side of [-0.25, 0.25]) this.line(tip, at(tip, this.picture.across([-x + side * y, -y - side * x]), size));
  }

  /** A line with arrows at both ends, and its number above it. */
  measure(from, to) {
    const { picture } = this;
    const along = to.clone().sub(from).normalize();
    const [a, b] = [from, to].map((end) => picture.seen(end));
    let [x, y] = [b[0] - a[0], b[1] - a[1]];
    const long = Math.hypot(x, y);
    // Where there is no room between them, arrows point inwards.
    const isInside = long > 3 * ARROW;
    this.line(from, to);
    this.kept.push([from, to]);
    for (const [tip, sign] of [[from, -1], [to, 1]]) {
      this.arrow(tip, along.clone().multiplyScalar(isInside ? sign : -sign));
      if (!isInside) this.line(tip, at(tip, along, sign * 2 * ARROW * picture.pixel(tip)));
    }
    if (long < 1) [x, y] = [1, 0];
    else [x, y] = [x / long, y / long];
    // From the left to the right; steep ones upwards.
    if (Math.abs(x) < STEEP ? y > 0 : x < 0) [x, y] = [-x, -y];
    const middle = from.clone().add(to).multiplyScalar(0.5);
    this.label = {
      place: at(middle, picture.across([y, -x]), 0.75 * HEIGHT * picture.pixel(middle)), turn: Math.atan2(-y, x), side: 0,
    };
  }

  /** The same beside what is measured, as far as some room and so many pixels, with lines that lead there. */
  beside(ends, { out, long }, room, pixels) {
    const step = this.picture.pixel(ends[0].clone().add(ends[1]).multiplyScalar(0.5)) / long;
    const off = room + pixels * step;
    for (const end of ends) this.line(at(end, out, GAP * step), at(end, out, off + GAP * step));
    this.measure(...ends.map((end) => at(end, out, off)));
  }
}

/** The lines that measure a box along each axis: at edges beside which there is nothing of it. */
function ofBox([low, high], picture) {
  const corner = (sides) => new Vector3(...sides.map((side, k) => (side > 0 ? high : low)[k]));
  const isFront = (axis, side) => {
    const middle = [0, 0, 0];
    middle[axis] = side;
    const on = corner(middle.map((value) => value || -1));
    return side * picture.toEye(on).getComponent(axis) > 1e-6;
  };
  const sizes = [];
  for (let axis = 0; axis < 3; axis++) {
    const others = [(axis + 1) % 3, (axis + 2) % 3];
    let best = null;
    for (const sides of [[-1, -1], [-1, 1], [1, -1], [1, 1]]) {
      const fronts = others.map((other, k) => isFront(other, sides[k]));
      if (fronts[0] === fronts[1]) continue;
      const ends = [-1, 1].map((end) => {
        const place = [0, 0, 0];
        place[axis] = end;
        others.forEach((other, k) => { place[other] = sides[k]; });
        return corner(place);
      });
      const middle = ends[0].clone().add(ends[1]).multiplyScalar(0.5);
      // Outwards along a face that is seen, or along one that is not: whichever is seen longer.
      const outs = others.map((other, k) => {
        const out = new Vector3().setComponent(other, sides[k]);
        return { out, long: length(picture.direction(middle, out)) };
      });
      const way = outs[0].long > outs[1].long ? outs[0] : outs[1];
      const [a, b] = ends.map((end) => picture.seen(end));
      const [x, y] = [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
      if (Math.hypot(b[0] - a[0], b[1] - a[1]) < SHORTEST || way.long < 0.05) continue;
      // Below, or on the left.
      const rank = Math.abs(b[0] - a[0]) >= Math.abs(b[1] - a[1]) ? y : -x;
      if (!best || rank > best.rank) best = { rank, ends, way };
    }
    if (!best) continue;
    sizes.push({
      axis,
      inRow: (row) => {
        const layout = new Layout(picture);
        layout.beside(best.ends, best.way, 0, OUTER + row * ROW);
        return layout;
      },
    });
  }
  return sizes;
}

/** A distance beside the model's box, or where it is if that is far. */
function ofDistance(ends, [low, high], picture, row) {
  const layout = new Layout(picture);
  const along = ends[1].clone().sub(ends[0]);
  const size = along.length();
  along.normalize();
  const middle = ends[0].clone().add(ends[1]).multiplyScalar(0.5);
  let best = null;
  for (let axis = 0; axis < 3; axis++) {
    for (const side of [-1, 1]) {
      const out = new Vector3().setComponent(axis, side);
      out.addScaledVector(along, -out.dot(along));
      if (out.length() < 0.1) continue;
      out.normalize();
      const long = length(picture.direction(middle, out));
      if (long < 0.35) continue;
      // From the line to the farthest corner.
      const far = new Vector3(...[0, 1, 2].map((k) => (out.getComponent(k) > 0 ? high : low).getComponent(k)));
      const room = Math.max(0, far.sub(middle).dot(out));
      // (On the other side the model is before it.)
      const isBehind = out.dot(picture.toEye(middle)) < -1e-6;
      if (!isBehind && !(best?.room <= room)) best = { room, out, long };
    }
  }
  const reach = Math.max(2 * size, 0.3 * high.distanceTo(low));
  if (best && best.room <= reach) layout.beside(ends, best, best.room, INNER + row * ROW);
  else layout.measure(...ends);
  return layout;
}

/** The diameter of a circle, or of a sphere if it has no axis: at its end that is nearer. */
function ofCircle(centers, axis, radius, picture, row) {
  const layout = new Layout(picture);
  const center = centers.length > 1 && centers[1].clone().sub(centers[0]).dot(picture.toEye(centers[0])) > 0 ? centers[1] : centers[0];
  const slant = SLANT + row * AROUND;
  const across = picture.across([Math.cos(slant), -Math.sin(slant)]);
  const out = across.clone();
  if (axis) out.addScaledVector(axis, -out.dot(axis));
  if (out.length() < 1e-3) out.copy(picture.right);
  out.normalize();
  const rim = at(center, out, radius);
  // Away from the centre; of a circle that is seen from its side out of its plane.
  const way = axis && Math.abs(axis.dot(picture.toEye(center))) < STEEP ? across : out;
  const [x, y] = picture.direction(rim, way);
  const end = at(rim, way, 1.5 * INNER * picture.pixel(rim) / Math.max(0.3, Math.hypot(x, y)));
  layout.line(rim, end);
  layout.kept.push([rim, end]);
  layout.arrow(rim, way.clone().negate());
  const side = x < 0 ? -1 : 1;
  layout.label = { place: at(end, picture.right, side * 4 * picture.pixel(end)), turn: 0, side };
  return layout;
}

function ofAngle(vertex, [one, other], picture, row) {
  const layout = new Layout(picture);
  const pixel = picture.pixel(vertex);
  const radius = (ARC + row * ROW) * pixel;
  const angle = one.angleTo(other);
  const off = other.clone().addScaledVector(one, -other.dot(one)).normalize();
  const direction = (share) => one.clone().multiplyScalar(Math.cos(share * angle)).addScaledVector(off, Math.sin(share * angle));
  const tangent = (share) => off.clone().multiplyScalar(Math.cos(share * angle)).addScaledVector(one, -Math.sin(share * angle));
  for (const side of [one, other]) layout.line(vertex, at(vertex, side, 1.15 * radius));
  const arc = Array.from({ length: CHORDS + 1 }, (_, k) => at(vertex, direction(k / CHORDS), radius));
  for (let k = 0; k < CHORDS; k++) layout.line(arc[k], arc[k + 1]);
  const third = CHORDS / 3;
  for (let k = 0; k < CHORDS; k += third) layout.kept.push([arc[k], arc[k + third]]);
  layout.arrow(at(vertex, one, radius), tangent(0).negate());
  layout.arrow(at(vertex, other, radius), tangent(1));
  const [x, y] = picture.direction(vertex, direction(0.5));
  layout.label = { place: at(vertex, direction(0.5), radius + 6 * pixel / Math.max(0.3, Math.hypot(x, y))), turn: 0, side: x < 0 ? -1 : 1 };
  return layout;
}

export class Dimensions {
  constructor() {
    this.group = new Group();
    this.isShown = false;
    /** Of each face the box around it, about the model's middle. */
    this.extents = [];
    this.unit = "";
    /** What is measured, as the server tells it, with `value`. */
    this.measured = [];
    /** What is drawn: for tests. */
    this.drawn = [];
    // In front of the model, and faint behind it.
    const ways = [{}, { opacity: 0.25, depthFunc: GreaterDepth }];
    this.lines = [0, 1].map(() => ways.map((way) => {
      const material = new LineBasicMaterial({ depthWrite: false, transparent: true, ...way });
      return Object.assign(new LineSegments(new BufferGeometry(), material), { frustumCulled: false, renderOrder: 5 });
    }));
    this.labels = new Map();
    this.group.add(...this.lines.flat());
  }

  theme(isDark, behind) {
    this.colors = isDark ? COLORS.dark : COLORS.light;
    this.behind = behind;
    this.lines.forEach((both, k) => { for (const { material } of both) material.color.set(this.colors[k]); });
    for (const label of this.labels.values()) this.#dispose(label);
    this.labels.clear();
  }

  /** Another model, or more or fewer of its faces. */
  of(model, hidden) {
    const { center, extents, faces, is_coarse: isCoarse } = model;
    this.unit = model.unit;
    this.center = new Vector3(...center);
    const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
    // (What is coarse is not as large as it says.)
    for (let face = 0; face < faces.length && !isCoarse; face++) {
      if (hidden.has(face)) continue;
      for (let k = 0; k < 3; k++) {
        low[k] = Math.min(low[k], extents[6 * face + k]);
        high[k] = Math.max(high[k], extents[6 * face + 3 + k]);
      }
    }
    this.sizes = low.map((least, k) => high[k] - least);
    this.box = this.sizes.every((size) => size >= 0) ? [low, high].map((end) => new Vector3(...end).sub(this.center)) : null;
  }

  /** Lays all of them out as a camera sees them. */
  layOut(camera, width, height) {
    this.group.visible = this.isShown && Boolean(this.box);
    this.drawn = [];
    if (!this.group.visible) return;
    const picture = new Picture(camera, width, height);
    const box = this.box.map((end) => end.toArray());
    const sizes = ofBox(box, picture).filter(({ axis }) => this.sizes[axis] > 0).map(({ axis, inRow }) =>
      ({ rank: 2, text: textOf({ kind: "distance", value: this.sizes[axis] }, this.unit), color: 0, inRow }));
    const measured = this.measured.map((dimension) =>
      ({ rank: dimension.kind === "distance" ? 0 : 1, value: dimension.value, text: textOf(dimension, this.unit), color: 1, inRow: this.#inRow(dimension, picture) }));
    // (The sides of a narrow angle may meet far away.)
    const reach = 4 * this.box[0].distanceTo(this.box[1]);
    this.drawn = [...sizes, ...measured].filter(({ inRow }) => inRow?.(0).segments[0].length() < reach);
    // Distances come first, short ones nearer to the model; sizes are beyond all others.
    const strokes = [];
    for (const one of this.drawn.toSorted((a, b) => a.rank - b.rank || (a.value ?? 0) - (b.value ?? 0))) {
      const tried = Array.from({ length: ROWS }, (_, row) => one.inRow(row)).map((layout) => ({ layout, own: layout.strokes(one.text) }));
      const isFree = ({ own }) => own.every((a) => strokes.every((b) => apart(a.ends, b.ends) >= a.off + b.off));
      const { layout, own } = tried.find(isFree) ?? tried[0];
      strokes.push(...own);
      Object.assign(one, { layout, seen: picture.seen(layout.label.place) });
    }
    this.lines.forEach((both, k) => {
      const points = this.drawn.flatMap(({ layout, color }) => (color === k ? layout.segments : []));
      const places = new Float32Array(points.flatMap((point) => point.toArray()));
      for (const lines of both) {
        lines.geometry.dispose();
        lines.geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(places, 3));
        lines.visible = points.length > 0;
      }
    });
    this.#write(picture);
  }

  /** What lays something that is measured out in a row; nothing for a distance at whose end one looks. */
  #inRow(dimension, picture) {
    const { kind, value } = dimension;
    const place = (point) => new Vector3(...point).sub(this.center);
    switch (kind) {
      case "distance": {
        const ends = dimension.ends.map(place);
        const along = ends[1].clone().sub(ends[0]);
        const middle = at(ends[0], along, 0.5);
        if (length(picture.direction(middle, along.normalize())) < FLATTEST) return null;
        return (row) => ofDistance(ends, this.box, picture, row);
      }
      case "angle": {
        const [vertex, along] = [place(dimension.at), dimension.along.map((side) => new Vector3(...side))];
        return (row) => ofAngle(vertex, along, picture, row);
      }
      case "circle": {
        const [centers, axis] = [dimension.centers.map(place), new Vector3(...dimension.axis)];
        return (row) => ofCircle(centers, axis, value, picture, row);
      }
      case "sphere": {
        const centers = [place(dimension.center)];
        return (row) => ofCircle(centers, null, value, picture, row);
      }
    }
  }

  /** The numbers. */
  #write(picture) {
    const unused = new Map(this.labels);
    this.drawn.forEach(({ text, color, layout: { label } }, k) => {
      const key = `${k} ${color} ${text}`;
      unused.delete(key);
      const sprite = this.labels.get(key) ?? this.#label(text, this.colors[color]);
      this.labels.set(key, sprite);
      const pixel = picture.pixel(label.place);
      const { width, height } = sprite.userData;
      sprite.scale.set(width * pixel, height * pixel, 1);
      sprite.center.set(0.5 - 0.5 * label.side, 0.5);
      sprite.position.copy(label.place);
      sprite.material.rotation = label.turn;
    });
    for (const [key, sprite] of unused) {
      this.#dispose(sprite);
      this.labels.delete(key);
    }
  }

  #label(text, color) {
    const context = document.createElement("canvas").getContext("2d");
    const [width, height] = [widthOf(text), HEIGHT + 8];
    Object.assign(context.canvas, { width: FINE * width, height: FINE * height });
    context.scale(FINE, FINE);
    Object.assign(context, {
      font: FONT, textAlign: "center", textBaseline: "middle", lineJoin: "round", lineWidth: 5,
      strokeStyle: this.behind, fillStyle: color,
    });
    // What is behind a number does not disturb it.
    context.strokeText(text, width / 2, height / 2);
    context.fillText(text, width / 2, height / 2);
    const map = new CanvasTexture(context.canvas);
    Object.assign(map, { colorSpace: SRGBColorSpace, premultiplyAlpha: true });
    const sprite = new Sprite(new SpriteMaterial({ map, premultipliedAlpha: true, depthTest: false, depthWrite: false, transparent: true }));
    Object.assign(sprite, { renderOrder: 6, frustumCulled: false, userData: { width, height } });
    this.group.add(sprite);
    return sprite;
  }

  #dispose(sprite) {
    this.group.remove(sprite);
    sprite.material.map.dispose();
    sprite.material.dispose();
  }
}
