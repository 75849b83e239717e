// Two cameras as one: perspective and parallel, that look at the same place from the same side.
import { OrthographicCamera, PerspectiveCamera, Spherical, Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import look from "./look.json";

/** Half of the angle that the narrower side of the picture spans. */
const HALF = (look.field / 2) * (Math.PI / 180);
const TANGENT = Math.tan(HALF);

/** Directions to the eye. */
const VIEWS = {
  front: [0, -1, 0], back: [0, 1, 0], right: [1, 0, 0], left: [-1, 0, 0], top: [0, 0, 1], bottom: [0, 0, -1],
  corner: look.eye,
};

export class Cameras {
  constructor(canvas, changed) {
    this.perspective = new PerspectiveCamera(look.field, 1, 0.1, 100);
    this.parallel = new OrthographicCamera(-1, 1, 1, -1, -100, 100);
    for (const camera of [this.perspective, this.parallel]) {
      camera.up.set(0, 0, 1);
      camera.position.set(1, -1, 1);
    }
    this.current = this.perspective;
    this.radius = 1;
    this.aspect = 1;
    /** The share of the picture that is left free around the model when all of it is shown. */
    this.room = 0;
    this.controls = new OrbitControls(this.current, canvas);
    this.controls.zoomToCursor = true;
    this.controls.addEventListener("change", () => { this.#depths(); changed(); });
    this.changed = changed;
  }

  get isParallel() {
    return this.current === this.parallel;
  }

  /** How far it is from the eye to where it looks; of the parallel one, for the same size there. */
  get distance() {
    if (!this.isParallel) return this.perspective.position.distanceTo(this.controls.target);
    return Math.min(this.parallel.top, this.parallel.right) / this.parallel.zoom / TANGENT;
  }

  /** The model's size is another. */
  sized(radius) {
    this.radius = radius || 1;
    this.#depths();
  }

  resized(width, height) {
    const half = Math.min(this.parallel.top, this.parallel.right);
    this.aspect = width / height;
    this.perspective.aspect = this.aspect;
    this.perspective.fov = 2 * Math.atan(this.#high(TANGENT)) * (180 / Math.PI);
    this.#frame(half);
    this.perspective.updateProjectionMatrix();
    this.changed();
  }

  look(name) {
    this.#place(new Vector3(...VIEWS[name]).normalize(), this.distance);
  }

  /** All of a ball of the model's radius into the picture. */
  fit() {
    const direction = this.current.position.clone().sub(this.controls.target).normalize();
    this.controls.target.set(0, 0, 0);
    this.#place(direction, this.#fitting);
  }

  get #fitting() {
    return (look.margin * this.radius) / Math.sin(HALF) / (1 - this.room);
  }

  /** Leaves room around the model, at once if all of it is shown. */
  leave(room) {
    const isFitted = this.controls.target.length() < 1e-6 * this.radius && Math.abs(this.distance / this.#fitting - 1) < 1e-6;
    this.room = room;
    if (isFitted) this.fit();
  }

  turn(across, up) {
    const off = this.current.position.clone().sub(this.controls.target);
    // (Spherical coordinates have their pole along y.)
    const sphere = new Spherical().setFromVector3(new Vector3(off.x, off.z, -off.y));
    sphere.theta -= across;
    sphere.phi = Math.min(Math.PI - 1e-4, Math.max(1e-4, sphere.phi + up));
    const turned = new Vector3().setFromSpherical(sphere);
    this.#place(new Vector3(turned.x, -turned.z, turned.y).normalize(), this.distance);
  }

  /** Moves by parts of the picture's height. */
  move(across, up) {
    const step = 2 * this.distance * this.#high(TANGENT);
    const [x, y] = [0, 1].map((k) => new Vector3().setFromMatrixColumn(this.current.matrixWorld, k));
    const by = x.multiplyScalar(across * step).add(y.multiplyScalar(up * step));
    this.controls.target.add(by);
    this.current.position.add(by);
    this.controls.update();
    this.changed();
  }

  nearer(factor) {
    const direction = this.current.position.clone().sub(this.controls.target).normalize();
    this.#place(direction, this.distance / factor);
  }

  project(isParallel) {
    const direction = this.current.position.clone().sub(this.controls.target).normalize();
    const { distance } = this;
    this.current = isParallel ? this.parallel : this.perspective;
    this.controls.object = this.current;
    this.#place(direction, distance);
  }

  #place(direction, distance) {
    this.current.position.copy(this.controls.target).addScaledVector(direction, distance);
    this.parallel.zoom = 1;
    this.#frame(distance * TANGENT);
    this.#depths();
    this.controls.update();
    this.changed();
  }

  /** Half of the picture's height, where this is half of its narrower side. */
  #high(half) {
    return half / Math.min(1, this.aspect);
  }

  #frame(half) {
    const top = this.#high(half);
    Object.assign(this.parallel, { top, bottom: -top, left: -top * this.aspect, right: top * this.aspect });
    this.parallel.updateProjectionMatrix();
  }

  /** What is nearest and farthest: a ball around the model. */
  #depths() {
    const off = this.current.position.length();
    const far = off + 1.1 * this.radius;
    this.perspective.near = Math.max(off - 1.1 * this.radius, 1e-4 * far);
    Object.assign(this.parallel, { near: off - 3 * this.radius - this.distance, far: far + 3 * this.radius + this.distance });
    this.perspective.far = far;
    this.current.updateProjectionMatrix();
  }
}
