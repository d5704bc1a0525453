// The 3D picture: the robot from its shapes, the trace of the hand, goal and marker. z is up.
import { Things, geometryOf } from "./things.js";
import * as three from "./vendored/three.js";

const TRACE = 600; // points of the trace
const MOVED = 0.004; // [m] from one point of the trace to the next
const FLOOR = 10; // [m] of the floor to each side
const NEAREST = 0.6; // [m] of the camera from what it looks at
const FARTHEST = 8;
const DISTANCE = 2.7; // [m] at first
const PARTS = { behind: [-1, 0, 0.45], side: [0, -1, 0.35], above: [-0.02, 0, 1] };

export class Scene {
  /** Draw into a canvas; throws where there is no WebGL. `lost()` is called when it is lost. */
  constructor(canvas, { lost, moved }) {
    this.canvas = canvas;
    this.renderer = new three.WebGLRenderer({ canvas, antialias: true, powerPreference: "low-power" });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.scene = new three.Scene();
    this.camera = new three.PerspectiveCamera(42, 1, 0.05, 60);
    this.camera.up.set(0, 0, 1);
    this.base = new three.Vector3();
    this.heading = 0;
    this.dirty = true;
    canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      this.gone = true;
      lost(true);
    });
    canvas.addEventListener("webglcontextrestored", () => {
      this.gone = false;
      this.dirty = true;
      lost(false);
    });
    this.things = new Things(this.scene);
    this.#light();
    this.#marks();
    this.#controls(moved);
    new ResizeObserver(() => (this.dirty = true)).observe(canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.#colours());
    this.#colours();
  }

  #light() {
    this.scene.add(new three.HemisphereLight(0xffffff, 0x8a8f96, 2.2));
    const sun = new three.DirectionalLight(0xffffff, 1.6);
    sun.position.set(-2, -3, 5);
    this.scene.add(sun);
  }

  #colours() {
    const dark = matchMedia("(prefers-color-scheme: dark)").matches;
    this.scene.background = new three.Color(dark ? 0x1a2026 : 0xe9eef2);
    this.scene.remove(this.grid);
    this.grid = floor(dark ? 0x46525d : 0xb3c0ca);
    this.scene.add(this.grid);
    this.dirty = true;
  }

  #marks() {
    this.hand = new three.AxesHelper(0.12);
    this.hand.visible = false;
    const ball = (radius, colour, opacity) => new three.Mesh(
      new three.SphereGeometry(radius, 24, 16),
      new three.MeshLambertMaterial({ color: colour, transparent: true, opacity }),
    );
    this.goal = ball(0.028, 0x1b7f3b, 0.75);
    this.goal.visible = false;
    this.marker = ball(0.036, 0xb3541e, 0.8);
    this.marker.visible = false;
    this.trace = new three.Line(
      new three.BufferGeometry(),
      new three.LineBasicMaterial({ color: 0x1f6fb2 }),
    );
    this.trace.geometry.setAttribute(
      "position",
      new three.BufferAttribute(new Float32Array(3 * TRACE), 3),
    );
    this.trace.geometry.setDrawRange(0, 0);
    this.trace.frustumCulled = false;
    this.points = [];
    this.scene.add(this.hand, this.goal, this.marker, this.trace);
  }

  #controls(moved) {
    const redraw = () => (this.dirty = true);
    this.orbit = new three.OrbitControls(this.camera, this.canvas);
    this.orbit.enableDamping = false;
    this.orbit.minDistance = NEAREST;
    this.orbit.maxDistance = FARTHEST;
    this.orbit.minPolarAngle = 0.02;
    this.orbit.maxPolarAngle = 1.54;
    this.orbit.enablePan = false;
    this.orbit.enableZoom = false; // the wheel scrolls the page; there are buttons
    this.orbit.addEventListener("change", redraw);
    this.drag = new three.TransformControls(this.camera, this.canvas);
    this.drag.setSize(1.1);
    this.drag.addEventListener("change", redraw);
    this.drag.addEventListener("dragging-changed", ({ value }) => (this.orbit.enabled = !value));
    this.drag.addEventListener("objectChange", () => moved(this.marker.position.toArray()));
    this.scene.add(this.drag.getHelper());
    this.#touch();
  }

  /** A finger still scrolls the page, unless there is a marker to drag. */
  #touch() {
    this.canvas.style.touchAction = this.marker.visible ? "none" : "pan-y";
  }

  /** Build the robot of a `hello` message. */
  build({ frames, shapes }) {
    for (const old of [this.robot, this.world]) {
      old?.traverse(({ geometry, material }) => {
        geometry?.dispose();
        material?.dispose();
      });
      old?.removeFromParent();
    }
    this.robot = new three.Group();
    this.world = new three.Group();
    this.frames = [this.robot];
    this.joints = frames.map(({ parent, origin, axis, slides, leader, multiplier, offset }) => {
      const group = new three.Group();
      this.frames[parent].add(group);
      this.frames.push(group);
      const [at, turned] = pose(origin);
      return { group, at, turned, axis: new three.Vector3(...axis), slides, leader, multiplier, offset };
    });
    this.scene.add(this.robot, this.world);
    for (const shape of shapes) this.#shape(shape);
    this.#pose(this.joints.map(() => 0));
    this.dirty = true;
  }

  #shape({ kind, size, pose: where, frame, colour, mesh }) {
    const [red, green, blue, opacity] = colour;
    const material = new three.MeshLambertMaterial({
      color: new three.Color().setRGB(red, green, blue, "srgb"),
      transparent: opacity < 1,
      opacity,
    });
    const parent = frame < 0 ? this.world : this.frames[frame]; // as long as this robot is drawn
    const place = (geometry) => {
      const solid = new three.Mesh(geometry, material);
      const [at, turned] = pose(where);
      solid.position.copy(at);
      solid.quaternion.copy(turned);
      if (kind === "mesh") solid.scale.set(...size);
      parent.add(solid);
      this.dirty = true;
    };
    if (kind !== "mesh") place(geometryOf(kind, size));
    else if (mesh.toLowerCase().endsWith(".stl")) {
      new three.STLLoader().load(mesh, place, undefined, () => {});
    }
  }

  #pose(q) {
    for (const { group, at, turned, axis, slides, leader, multiplier, offset } of this.joints) {
      if (q[leader] === null || q[leader] === undefined) continue; // where it was
      const by = multiplier * q[leader] + offset;
      group.position.copy(at);
      group.quaternion.copy(turned);
      if (slides) group.position.add(axis.clone().multiplyScalar(by).applyQuaternion(turned));
      else group.quaternion.multiply(new three.Quaternion().setFromAxisAngle(axis, by));
    }
  }

  /** Take a state; it is painted by the next `paint`. */
  show({ q, base, hand, goal, things }) {
    if (!this.robot) return;
    this.#pose(q);
    if (base) this.#carry(base);
    this.things.show(things);
    this.hand.visible = hand !== null;
    if (hand !== null) {
      put(this.hand, hand);
      this.#draw(hand.position);
    }
    this.goal.visible = goal !== null;
    if (goal !== null) put(this.goal, goal);
    this.dirty = true;
  }

  /** Put the base there; the camera goes with it, but does not turn with it. */
  #carry([x, y, heading]) {
    const shift = new three.Vector3(x, y, 0).sub(this.base);
    this.base.set(x, y, 0);
    this.heading = heading;
    this.robot.position.set(x, y, 0);
    this.robot.rotation.set(0, 0, heading);
    if (!this.looked) {
      this.looked = true;
      this.view("behind");
      return;
    }
    this.camera.position.add(shift);
    this.orbit.target.add(shift);
    this.orbit.update();
  }

  #draw(point) {
    const last = this.points.at(-1);
    if (last && Math.hypot(...point.map((one, i) => one - last[i])) < MOVED) return;
    this.points.push(point);
    if (this.points.length > TRACE) this.points.shift();
    const attribute = this.trace.geometry.getAttribute("position");
    this.points.forEach((each, i) => attribute.setXYZ(i, ...each));
    attribute.needsUpdate = true;
    this.trace.geometry.setDrawRange(0, this.points.length);
  }

  /** Look from `behind`, the `side` or `above`, as the robot stands now. */
  view(from) {
    const [ahead, left, up] = PARTS[from];
    const [c, s] = [Math.cos(this.heading), Math.sin(this.heading)];
    this.orbit.target.set(this.base.x + 0.35 * c, this.base.y + 0.35 * s, 0.6);
    const away = new three.Vector3(c * ahead - s * left, s * ahead + c * left, up);
    this.camera.position.copy(this.orbit.target).addScaledVector(away.normalize(), DISTANCE);
    this.orbit.update();
    this.dirty = true;
  }

  /** Turn the camera about what it looks at [rad], and go to `zoom` times the distance. */
  move(turn, zoom) {
    const away = this.camera.position.clone().sub(this.orbit.target);
    away.applyAxisAngle(new three.Vector3(0, 0, 1), turn).multiplyScalar(zoom);
    this.camera.position.copy(this.orbit.target).add(away);
    this.orbit.update();
    this.dirty = true;
  }

  /** The heading of the direction of view in the world [rad], from x towards y. */
  get cameraHeading() {
    const way = this.orbit.target.clone().sub(this.camera.position);
    return Math.atan2(way.y, way.x);
  }

  /** Show the marker at a position, to be dragged; null hides it. */
  mark(position) {
    this.marker.visible = position !== null;
    if (position === null) this.drag.detach();
    else {
      this.marker.position.set(...position);
      if (!this.drag.object) this.drag.attach(this.marker);
    }
    this.#touch();
    this.dirty = true;
  }

  /** Draw, if anything has changed. */
  paint() {
    if (!this.dirty || this.gone) return;
    this.dirty = false;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0 || height === 0) return;
    if (width !== this.width || height !== this.height) {
      [this.width, this.height] = [width, height];
      this.renderer.setSize(width, height, false);
      this.camera.aspect = width / height;
      this.camera.updateProjectionMatrix();
    }
    this.renderer.render(this.scene, this.camera);
  }
}

/** Lines on the floor every half metre, in short pieces: long ones are lost behind the camera. */
function floor(color) {
  const points = [];
  for (let one = -FLOOR; one <= FLOOR; one += 0.5) {
    for (let from = -FLOOR; from < FLOOR; from += 0.5) {
      points.push(one, from, 0, one, from + 0.5, 0, from, one, 0, from + 0.5, one, 0);
    }
  }
  const geometry = new three.BufferGeometry();
  geometry.setAttribute("position", new three.BufferAttribute(new Float32Array(points), 3));
  return new three.LineSegments(geometry, new three.LineBasicMaterial({ color }));
}

function pose({ position, orientation }) {
  const turned = orientation ? new three.Quaternion(...orientation) : new three.Quaternion();
  return [new three.Vector3(...position), turned];
}

function put(thing, { position, orientation }) {
  thing.position.set(...position);
  if (orientation) thing.quaternion.set(...orientation);
}
