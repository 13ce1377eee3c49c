// Goals, targets and obstacles that are dragged in the picture: level, or up and down with shift.
import * as THREE from 'three/three.module.js';
import { robotColour } from './palette.js';

export class Drag {
  // tune: receives their places
  constructor(stage, tune) {
    this.stage = stage;
    this.tune = tune;
    this.handles = []; // {mesh, move(p)}
    this.held = null;
    const canvas = stage.renderer.domElement;
    canvas.addEventListener('pointerdown', (event) => this.take(event), true);
    canvas.addEventListener('pointermove', (event) => this.move(event), true);
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, (event) => this.drop(event), true);
  }

  // Once what is drawn is built, or what may be tuned has changed.
  build(scene, tunables) {
    for (const { goal } of this.handles) if (goal) goal.parent.remove(goal);
    this.handles = [];
    if (!tunables?.tune || !this.stage.world) return;
    for (const reference of tunables.references) {
      const i = scene.bodies.findIndex((body) => body.name === reference.agent);
      if (!reference.goal || i < 0) continue;
      const goal = new THREE.Mesh(new THREE.OctahedronBufferGeometry(0.12),
        new THREE.MeshBasicMaterial({ color: robotColour(i), wireframe: true }));
      goal.position.set(...reference.goal);
      this.stage.world.add(goal);
      this.handles.push({ mesh: goal, goal, move: (p) => this.tune.moveGoal(reference, p) });
    }
    for (const body of tunables.bodies) {
      const i = scene.bodies.findIndex((one) => one.name === body.name);
      if (i >= 0) this.handles.push({ mesh: this.stage.bodies[i].shape, move: (p) => this.tune.moveBody(body, p) });
    }
  }

  // Where the handles are on the screen, for tests.
  places() {
    const { left, top, width, height } = this.stage.renderer.domElement.getBoundingClientRect();
    return this.handles.map(({ mesh }) => {
      const at = mesh.getWorldPosition(new THREE.Vector3()).project(this.stage.camera);
      return [left + ((at.x + 1) * width) / 2, top + ((1 - at.y) * height) / 2];
    });
  }

  ray(event) {
    const { left, top, width, height } = this.stage.renderer.domElement.getBoundingClientRect();
    const at = new THREE.Vector2((2 * (event.clientX - left)) / width - 1, 1 - (2 * (event.clientY - top)) / height);
    const caster = new THREE.Raycaster();
    caster.setFromCamera(at, this.stage.camera);
    return caster;
  }

  take(event) {
    if (event.button !== 0 || this.stage.followed?.sensor) return;
    const caster = this.ray(event);
    const hit = this.handles.flatMap((handle) => caster.intersectObject(handle.mesh, true).map((one) => ({ handle, far: one.distance })))
      .sort((a, b) => a.far - b.far)[0];
    if (!hit) return;
    event.stopImmediatePropagation();
    this.stage.renderer.domElement.setPointerCapture(event.pointerId);
    this.stage.orbit(false);
    this.held = { ...hit.handle, at: hit.handle.mesh.position.clone() };
    this.stage.renderer.domElement.style.cursor = 'grabbing';
  }

  move(event) {
    if (!this.held) return;
    event.stopImmediatePropagation();
    const { at } = this.held, view = this.stage.camera.getWorldDirection(new THREE.Vector3());
    const normal = event.shiftKey ? new THREE.Vector3(view.x, view.y, 0).normalize() : new THREE.Vector3(0, 0, 1);
    const met = this.ray(event).ray.intersectPlane(new THREE.Plane().setFromNormalAndCoplanarPoint(normal, at), new THREE.Vector3());
    if (!met || met.distanceTo(this.stage.camera.position) > 100) return;
    if (event.shiftKey) at.z = met.z;
    else at.set(met.x, met.y, at.z);
    if (this.held.goal) this.held.goal.position.copy(at);
    this.held.move([at.x, at.y, at.z].map((v) => Number(v.toFixed(3))));
  }

  drop(event) {
    if (!this.held) return;
    event.stopImmediatePropagation();
    this.held = null;
    this.stage.orbit(true);
    this.stage.renderer.domElement.style.cursor = '';
  }
}
