// What stands around the robot: boxes, cylinders and spheres, where its plant says that they are.
import * as three from "./vendored/three.js";

const COLOUR = 0x8d7b68;
const OPACITY = 0.55; // the hand is to be seen behind them

export class Things {
  constructor(scene) {
    this.scene = scene;
    this.drawn = new Map(); // by name, kind and size
    const look = { color: COLOUR, transparent: true, opacity: OPACITY, depthWrite: false };
    this.material = new three.MeshLambertMaterial(look);
  }

  /** Draw these, and no others. */
  show(things) {
    const gone = new Set(this.drawn.keys());
    for (const { name, kind, size, pose } of things) {
      const key = [name, kind, ...size].join();
      gone.delete(key);
      if (!this.drawn.has(key)) {
        this.drawn.set(key, new three.Mesh(geometryOf(kind, size), this.material));
        this.scene.add(this.drawn.get(key));
      }
      const solid = this.drawn.get(key);
      solid.position.set(...pose.position);
      solid.quaternion.set(...pose.orientation);
    }
    for (const key of gone) {
      this.scene.remove(this.drawn.get(key));
      this.drawn.get(key).geometry.dispose();
      this.drawn.delete(key);
    }
  }
}

/** Return the surface of a box, a cylinder along z, or a sphere. */
export function geometryOf(kind, size) {
  if (kind === "box") return new three.BoxGeometry(...size);
  if (kind === "sphere") return new three.SphereGeometry(size[0], 24, 16);
  return new three.CylinderGeometry(size[0], size[0], size[1], 32).rotateX(Math.PI / 2);
}
