// The model as three.js draws it: faces, edges, the cut, and what is picked.
import {
  AlwaysStencilFunc, BackSide, BufferAttribute, BufferGeometry, Color, DataTexture, DecrementWrapStencilOp,
  DirectionalLight, DoubleSide, FloatType, FrontSide, GLSL3, Group, HemisphereLight, IncrementWrapStencilOp,
  LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, MeshLambertMaterial, NearestFilter, NotEqualStencilFunc,
  Plane, PlaneGeometry, Points, PointsMaterial, RGBAFormat, ReplaceStencilOp, Scene, ShaderMaterial, UnsignedByteType,
  Vector3, WebGLRenderTarget,
} from "three";
import { Dimensions } from "./dimensions.js";
import look from "./look.json";

const WIDTH = 1024;
/** Milliseconds that a frame may take while the camera moves. */
const BUDGET = 33;
/** The pixels a side of a frame in motion, of all, by how coarse it is. */
const PIXELS = [1, 1, 1 / 2, 1 / 3];
/** Half of the window around the pointer in which edges are looked for, in pixels. */
const REACH = 6;

/** A colour as a number, of its parts. */
const packed = ([red, green, blue]) => (red << 16) | (green << 8) | blue;

/** A texture with four bytes for each face: its colour, and 255 where it is shown, 128 where
 * it is picked, 0 where it is hidden. */
function stateTexture(count) {
  const height = Math.max(1, Math.ceil(count / WIDTH));
  const texture = new DataTexture(new Uint8Array(4 * WIDTH * height), WIDTH, height, RGBAFormat, UnsignedByteType);
  texture.minFilter = texture.magFilter = NearestFilter;
  return texture;
}

const STATE = `
  uniform sampler2D states;
  vec4 stateOf(float face) {
    int k = int(face + 0.5);
    return texelFetch(states, ivec2(k % ${WIDTH}, k / ${WIDTH}), 0);
  }`;

export class Drawing {
  constructor(renderer) {
    this.renderer = renderer;
    this.scene = new Scene();
    this.plane = new Plane(new Vector3(0, -1, 0), 0);
    this.isCut = false;
    this.hidden = new Set();
    this.picks = [];
    this.group = new Group();
    this.scene.add(this.group);
    this.lights = [new HemisphereLight(0xffffff, packed(look.ground), look.sky), new DirectionalLight(0xffffff, look.lamp)];
    this.lights[0].position.set(0, 0, 1);
    this.scene.add(...this.lights);
    this.target = new WebGLRenderTarget(2 * REACH + 1, 2 * REACH + 1, { type: FloatType, format: RGBAFormat });
    this.pickScene = new Scene();
    this.states = { value: stateTexture(1) };
    this.accent = { value: new Color() };
    this.faceMaterial = this.#faceMaterial();
    this.stencils = [this.#stencil(BackSide, IncrementWrapStencilOp), this.#stencil(FrontSide, DecrementWrapStencilOp)];
    this.capMaterial = new MeshLambertMaterial({
      side: DoubleSide, stencilWrite: true, stencilRef: 0,
      stencilFunc: NotEqualStencilFunc, stencilFail: ReplaceStencilOp, stencilZFail: ReplaceStencilOp,
      stencilZPass: ReplaceStencilOp,
    });
    this.edgeMaterial = new LineBasicMaterial();
    this.pickedEdges = new LineBasicMaterial({ depthTest: false });
    this.pickedPoints = new PointsMaterial({ size: 9, sizeAttenuation: false, depthTest: false });
    this.pickMaterials = [this.#pickMaterial(1), this.#pickMaterial(-1)];
    this.showsEdges = this.showsFaces = true;
    this.dimensions = new Dimensions();
    this.scene.add(this.dimensions.group);
    this.theme(false);
  }

  #faceMaterial() {
    // (Physically based shaders take longer to make and to draw.)
    const material = new MeshLambertMaterial({
      side: DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
    });
    material.onBeforeCompile = (shader) => {
      Object.assign(shader.uniforms, { states: this.states, accent: this.accent });
      shader.vertexShader = shader.vertexShader
        .replace("#include <common>", "#include <common>\nattribute float face; varying float vFace;")
        .replace("#include <begin_vertex>", "#include <begin_vertex>\nvFace = face;");
      shader.fragmentShader = shader.fragmentShader
        .replace("#include <common>", `#include <common>\nvarying float vFace; uniform vec3 accent;${STATE}`)
        .replace("#include <color_fragment>", `
          vec4 state = stateOf(vFace);
          if (state.a < 0.25) discard;
          diffuseColor.rgb = sRGBTransferEOTF(vec4(state.rgb, 1.0)).rgb;
          if (state.a < 0.75) diffuseColor.rgb = mix(diffuseColor.rgb, accent, 0.65);`);
    };
    return material;
  }

  /** Counts walls of the whole model along a ray: what is open at the cut is inside. */
  #stencil(side, operation) {
    return new MeshBasicMaterial({
      side, colorWrite: false, depthWrite: false, depthTest: false, stencilWrite: true, stencilFunc: AlwaysStencilFunc,
      stencilFail: operation, stencilZFail: operation, stencilZPass: operation,
    });
  }

  /** Writes places about the model's middle, and the number of a face, or of an edge below 0. */
  #pickMaterial(sign) {
    return new ShaderMaterial({
      glslVersion: GLSL3, side: DoubleSide, clipping: true, uniforms: { states: this.states },
      polygonOffset: sign > 0, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
      vertexShader: `
        #include <clipping_planes_pars_vertex>
        in float face; out float vFace; out vec3 place;
        void main() {
          vFace = face; place = position;
          vec4 mvPosition = modelViewMatrix * vec4(position, 1.0);
          gl_Position = projectionMatrix * mvPosition;
          #include <clipping_planes_vertex>
        }`,
      fragmentShader: `
        #include <clipping_planes_pars_fragment>
        in float vFace; in vec3 place; out vec4 found; ${STATE}
        void main() {
          #include <clipping_planes_fragment>
          ${sign > 0 ? "if (stateOf(vFace).a < 0.25) discard;" : ""}
          found = vec4(place, ${sign > 0 ? "" : "-"}(floor(vFace + 0.5) + 1.0));
        }`,
    });
  }

  /** Colours for a light or a dark page. */
  theme(isDark) {
    this.colors = isDark ? look.dark : look.light;
    const { backgroundColor } = getComputedStyle(document.body);
    this.renderer.setClearColor(backgroundColor);
    this.dimensions.theme(isDark, backgroundColor);
    this.edgeMaterial.color.set(packed(this.colors.lines));
    this.accent.value.set(isDark ? 0x4da0ff : 0x1b74d0);
    this.pickedEdges.color.set(0xff7a1a);
    this.pickedPoints.color.set(0xff7a1a);
    this.capMaterial.color.set(isDark ? 0xb4583c : 0xd2785a);
    if (this.model) this.#paint();
  }

  /** Puts another model in place of this one. */
  show(model) {
    for (const mesh of [...this.group.children, ...this.pickScene.children]) {
      this.group.remove(mesh);
      this.pickScene.remove(mesh);
      mesh.geometry.dispose();
    }
    for (const simplified of this.simplifiedFaces ?? []) simplified.dispose();
    this.model = model;
    this.cost = this.step = this.lastEnd = 0;
    this.wasSlow = false;
    this.isMeasured = false;
    const faces = new BufferGeometry();
    faces.setAttribute("position", new BufferAttribute(model.points, 3));
    faces.setAttribute("normal", new BufferAttribute(model.normals, 4, true));
    faces.setAttribute("face", new BufferAttribute(model.faceOf, 1));
    faces.setIndex(new BufferAttribute(model.corners, 1));
    // The same points, and fewer triangles of them.
    this.simplifiedFaces = model.simplifiedCorners.map((corners) => {
      const simplified = new BufferGeometry();
      for (const [name, attribute] of Object.entries(faces.attributes)) simplified.setAttribute(name, attribute);
      return simplified.setIndex(new BufferAttribute(corners, 1));
    });
    const edges = new BufferGeometry();
    edges.setAttribute("position", new BufferAttribute(model.segments, 3));
    const ends = new Float32Array(2 * model.edgeOf.length);
    model.edgeOf.forEach((edge, k) => ends.fill(edge, 2 * k, 2 * k + 2));
    edges.setAttribute("face", new BufferAttribute(ends, 1));
    edges.setIndex(new BufferAttribute(Uint32Array.from(ends.keys()), 1));
    this.faceMesh = new Mesh(faces, this.faceMaterial);
    this.edgeLines = new LineSegments(edges, this.edgeMaterial);
    this.stencilMeshes = this.stencils.map((material) => new Mesh(faces, material));
    const size = 4 * (model.radius || 1);
    this.cap = new Mesh(new PlaneGeometry(size, size), this.capMaterial);
    this.cap.onAfterRender = (renderer) => renderer.clearStencil();
    this.stencilMeshes.forEach((mesh) => { mesh.renderOrder = 1; });
    this.cap.renderOrder = 2;
    this.faceMesh.renderOrder = this.edgeLines.renderOrder = 3;
    this.pickedLines = new LineSegments(new BufferGeometry(), this.pickedEdges);
    this.pickedDots = new Points(new BufferGeometry(), this.pickedPoints);
    this.pickedLines.renderOrder = this.pickedDots.renderOrder = 4;
    this.group.add(...this.stencilMeshes, this.cap, this.faceMesh, this.edgeLines, this.pickedLines, this.pickedDots);
    this.pickFaces = new Mesh(faces, this.pickMaterials[0]);
    this.pickEdges = new LineSegments(edges, this.pickMaterials[1]);
    this.pickScene.add(this.pickFaces, this.pickEdges);
    for (const object of [...this.group.children, ...this.pickScene.children]) object.frustumCulled = false;
    this.hidden = new Set();
    this.picks = [];
    this.states.value.dispose();
    this.states.value = stateTexture(model.faces.length);
    this.dimensions.of(model, this.hidden);
    this.#paint();
    this.#mark();
    this.#apply();
  }

  /** Draws these faces, edges or vertices as picked. */
  pick(picks) {
    this.picks = picks;
    this.#paint();
    this.#mark();
  }

  hide(hidden) {
    this.hidden = hidden;
    this.dimensions.of(this.model, hidden);
    this.#paint();
    // Edges are shown where a face beside them is.
    const { edgeFaces, edgeOf } = this.model;
    const { index } = this.edgeLines.geometry;
    let count = 0;
    edgeOf.forEach((edge, k) => {
      if (hidden.has(edgeFaces[2 * edge]) && hidden.has(edgeFaces[2 * edge + 1])) return;
      index.array.set([2 * k, 2 * k + 1], count);
      count += 2;
    });
    index.needsUpdate = true;
    this.edgeLines.geometry.setDrawRange(0, count);
  }

  /** Edges and faces, on or off. */
  showing(edges, faces) {
    this.showsEdges = edges;
    this.showsFaces = faces;
    this.#apply();
  }

  /** Cuts at a place along an axis, and keeps the side below it or above it; or not. */
  cut(isCut, axis = "y", place = 0, isTurned = false) {
    this.isCut = isCut;
    const sign = isTurned ? 1 : -1;
    this.plane.normal.set(axis === "x" ? sign : 0, axis === "y" ? sign : 0, axis === "z" ? sign : 0);
    this.plane.constant = -sign * place;
    this.#apply();
  }

  #apply() {
    const planes = this.isCut ? [this.plane] : null;
    for (const material of [this.faceMaterial, this.edgeMaterial, this.pickedEdges, this.pickedPoints, ...this.stencils, ...this.pickMaterials]) {
      if ((material.clippingPlanes === null) !== (planes === null)) material.needsUpdate = true;
      material.clippingPlanes = planes;
    }
    if (!this.model) return;
    this.faceMesh.visible = this.pickFaces.visible = this.showsFaces;
    this.edgeLines.visible = this.pickEdges.visible = this.showsEdges;
    for (const mesh of [...this.stencilMeshes, this.cap]) mesh.visible = this.isCut && this.showsFaces;
    this.cap.position.copy(this.plane.normal).multiplyScalar(-this.plane.constant);
    this.cap.lookAt(this.cap.position.clone().add(this.plane.normal));
  }

  #paint() {
    const { data } = this.states.value.image;
    const picked = new Set(this.picks.filter((pick) => pick.kind === "face").map((pick) => pick.id));
    this.model.faces.forEach(({ color }, k) => {
      const shade = color ? color.slice(0, 3).map((part) => Math.round(255 * part)) : this.colors.faces;
      data.set([...shade, this.hidden.has(k) ? 0 : picked.has(k) ? 128 : 255], 4 * k);
    });
    this.states.value.needsUpdate = true;
  }

  #mark() {
    const ofKind = (kind) => new Set(this.picks.filter((pick) => pick.kind === kind).map((pick) => pick.id));
    const [edges, vertices] = [ofKind("edge"), ofKind("vertex")];
    const { edgeOf, segments, vertices: corners } = this.model;
    const ends = [];
    if (edges.size) edgeOf.forEach((edge, k) => { if (edges.has(edge)) ends.push(...segments.subarray(6 * k, 6 * k + 6)); });
    const dots = [...vertices].flatMap((vertex) => [...corners.subarray(3 * vertex, 3 * vertex + 3)]);
    for (const [object, places] of [[this.pickedLines, ends], [this.pickedDots, dots]]) {
      object.geometry.dispose();
      object.geometry = new BufferGeometry();
      object.geometry.setAttribute("position", new BufferAttribute(new Float32Array(places), 3));
      object.visible = places.length > 0;
    }
  }

  /** How coarse frames in motion are: 0 with all triangles, 1 and so on with fewer and fewer, and with fewer pixels. */
  get coarseness() {
    const most = this.simplifiedFaces?.length ? PIXELS.length - 1 : 0;
    // (The cut draws them three times.)
    return Math.min(most, this.isCut && 3 * this.cost > BUDGET ? Math.max(1, this.step) : this.step);
  }

  /** Draws a frame; `isMoving` if another follows soon. */
  draw(camera, isMoving = false) {
    const coarseness = isMoving ? this.coarseness : 0;
    const simplified = this.simplifiedFaces?.[Math.min(coarseness, this.simplifiedFaces.length) - 1];
    for (const mesh of this.model ? [this.faceMesh, ...this.stencilMeshes] : []) {
      mesh.geometry = simplified ?? this.pickFaces.geometry;
    }
    if (this.model) {
      // Lines count as triangles do.
      const isHeavy = simplified && this.model.edgeOf.length > simplified.index.count / 3;
      this.edgeLines.visible = this.showsEdges && !isHeavy;
    }
    const ratio = window.devicePixelRatio * PIXELS[coarseness];
    if (this.renderer.getPixelRatio() !== ratio) this.renderer.setPixelRatio(ratio);
    this.lights[1].position.copy(camera.position).add(camera.up.clone().multiplyScalar(look.lamp_up * camera.position.length()));
    const { clientWidth: width, clientHeight: height } = this.renderer.domElement;
    this.dimensions.layOut(camera, width, height);
    this.renderer.localClippingEnabled = true;
    this.renderer.render(this.scene, camera);
  }

  /** Waits until all that was drawn is there. */
  async #done() {
    const gl = this.renderer.getContext();
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    while (gl.getSyncParameter(fence, gl.SYNC_STATUS) !== gl.SIGNALED) await new Promise((next) => setTimeout(next, 1));
    gl.deleteSync(fence);
  }

  /** Draws a frame in motion. Two in turn that take too long make the next ones coarser; nothing waits
   * for that. */
  async drawMoving(camera) {
    const { model } = this;
    const start = performance.now();
    this.draw(camera, true);
    if (!this.cost) return;
    await this.#done();
    const end = performance.now();
    // (It has waited for the one before.)
    const isSlow = end - Math.max(start, this.lastEnd) > BUDGET;
    this.lastEnd = end;
    if (isSlow && this.wasSlow && model === this.model) this.step = Math.min(this.coarseness + 1, PIXELS.length - 1);
    this.wasSlow = isSlow && !this.wasSlow;
  }

  /** Measures once what a frame of all triangles costs, where there are fewer; nothing waits for it.
   * From then on frames in motion are followed. */
  async measure(camera) {
    const { model } = this;
    if (this.isMeasured || !model?.simplifiedCorners.length) return;
    this.isMeasured = true;
    // (What was drawn before, which took the triangles to the graphics card, is not of it.)
    await this.#done();
    const start = performance.now();
    if (model === this.model) this.draw(camera);
    await this.#done();
    if (model !== this.model) return;
    this.cost = performance.now() - start;
    if (this.cost > BUDGET) this.step = Math.max(1, this.step);
  }

  /** What is seen at a place in pixels of the page: a vertex or an edge near by, or a face. */
  at(x, y, camera) {
    if (!this.model) return null;
    const { renderer } = this;
    const { clientWidth: width, clientHeight: height } = renderer.domElement;
    const side = 2 * REACH + 1;
    camera.setViewOffset(width, height, Math.floor(x) - REACH, Math.floor(y) - REACH, side, side);
    const before = renderer.getClearColor(new Color());
    renderer.setClearColor(0x000000, 0);
    renderer.setRenderTarget(this.target);
    renderer.clear();
    renderer.render(this.pickScene, camera);
    const pixels = new Float32Array(4 * side * side);
    renderer.readRenderTargetPixels(this.target, 0, 0, side, side, pixels);
    renderer.setRenderTarget(null);
    renderer.setClearColor(before, 1);
    camera.clearViewOffset();
    camera.updateProjectionMatrix();
    let edge = null;
    for (let k = 0; k < side * side; k++) {
      const off = Math.hypot((k % side) - REACH, Math.floor(k / side) - REACH);
      if (pixels[4 * k + 3] < 0 && off <= 4 && (!edge || off < edge.off)) {
        edge = { off, id: -pixels[4 * k + 3] - 1, place: pixels.slice(4 * k, 4 * k + 3) };
      }
    }
    if (edge) {
      for (const vertex of this.model.edges[edge.id] ?? []) {
        const seen = new Vector3(...this.model.vertices.subarray(3 * vertex, 3 * vertex + 3)).project(camera);
        const off = Math.hypot((seen.x + 1) * width / 2 - x, (1 - seen.y) * height / 2 - y);
        if (off <= 1.5 * REACH) return { kind: "vertex", id: vertex, place: [...this.model.vertices.subarray(3 * vertex, 3 * vertex + 3)] };
      }
      return { kind: "edge", id: edge.id, place: [...edge.place] };
    }
    const middle = 4 * (side * REACH + REACH);
    const face = pixels[middle + 3] - 1;
    if (face < 0) return null;
    return { kind: "face", id: face, place: [...pixels.slice(middle, middle + 3)] };
  }
}
