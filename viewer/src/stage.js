// The flight in three dimensions: G is drawn as it is, x and y level, z up, in metres.
import * as THREE from 'three/three.module.js';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { colours, robotColour } from './palette.js';
import { colourSurface, ellipsoid, line, prismShape, robotShape, setEllipsoid, setLine, surfaceGeometries, surfaceMesh } from './shapes.js';

const pathPoints = 256, trailPoints = 400, ellipsoidSigmas = 3, orbitAngle = 50;
// Turns of the browser [ms]: where they take longer, pictures get fewer pixels, where shorter, more again. Turns to a change and to rest.
const slow = 30, quick = 20, turnsToAdapt = 8, turnsToRest = 30, leastScale = 0.5;

// Whether the processor draws: then without smoothed edges, which need more samples of each pixel.
function drawsInSoftware() {
  const gl = document.createElement('canvas').getContext('webgl2');
  const info = gl?.getExtension('WEBGL_debug_renderer_info');
  const name = info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : '';
  gl?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software/i.test(name);
}

export class Stage {
  constructor(element, labels) {
    this.element = element;
    this.labels = labels;
    this.inSoftware = drawsInSoftware();
    this.renderer = new THREE.WebGLRenderer({ antialias: !this.inSoftware });
    element.prepend(this.renderer.domElement);
    this.camera = new THREE.PerspectiveCamera(orbitAngle, 1, 0.05, 500);
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(-3.2, -4.2, 3.4);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.target.set(0, 0, 0.8);
    this.controls.enableKeys = false; // the arrows move the time
    this.followed = null; // {body, sensor}
    this.changed = true; // something is to be drawn anew
    this.scale = 1; // of the pixels along each side
    this.turns = []; // of pictures that move [ms]
    this.resting = 0; // turns
    this.controls.addEventListener('change', () => { this.changed = true; });
    new ResizeObserver(() => this.resize()).observe(element);
    this.resize();
  }

  resize() {
    const { clientWidth: w, clientHeight: h } = this.element;
    if (w === 0 || h === 0) return;
    this.setScale(this.scale);
    this.renderer.setSize(w, h);
    this.camera.aspect = w / h;
    this.camera.updateProjectionMatrix();
  }

  setScale(scale) {
    this.scale = scale;
    this.changed = true;
    this.renderer.setPixelRatio(scale * Math.min(devicePixelRatio, this.inSoftware ? 1 : 2));
  }

  // The browser's last turn took so long [ms]. What moves is drawn as finely as there is time for, what rests with all its pixels.
  pace(turn, rests) {
    this.resting = rests ? this.resting + 1 : 0;
    if (rests) {
      if (this.resting > turnsToRest && this.scale < 1) this.setScale(1);
      return;
    }
    this.turns.push(turn);
    if (this.turns.length < turnsToAdapt) return;
    const median = this.turns.sort((a, b) => a - b)[turnsToAdapt / 2];
    this.turns = [];
    if (median > slow && this.scale > leastScale) this.setScale(Math.max(leastScale, 0.8 * this.scale));
    if (median < quick && this.scale < 1) this.setScale(Math.min(1, 1.25 * this.scale));
  }

  // Builds what stays; again for another theme.
  build(scene) {
    const c = colours();
    this.scene = scene;
    this.changed = true;
    this.surfaces = surfaceGeometries(scene.surfaces);
    this.world = new THREE.Scene();
    this.world.background = new THREE.Color(c.back);
    this.world.add(new THREE.HemisphereLight('#ffffff', '#8a919a', 0.7));
    const sun = new THREE.DirectionalLight('#ffffff', 0.38);
    sun.position.set(3, -2, 6);
    this.world.add(sun);
    const grid = new THREE.GridHelper(20, 20, c.grid, c.grid);
    grid.rotation.x = Math.PI / 2;
    grid.material.transparent = true;
    grid.material.opacity = 0.7;
    this.world.add(grid, new THREE.AxesHelper(0.5));
    for (const [height, colour] of [[scene.floor, c.grey], [scene.ceiling, c.grey]]) {
      if (height === null || Math.abs(height) > 50) continue;
      const frame = new THREE.GridHelper(20, 2, colour, colour);
      frame.rotation.x = Math.PI / 2;
      frame.position.z = height;
      frame.material.transparent = true;
      frame.material.opacity = 0.35;
      this.world.add(frame);
    }
    for (const prism of scene.prisms) this.world.add(prismShape(prism, prism.keep === 'outside' ? c.bad : c.grey));
    this.labels.replaceChildren();
    this.bodies = scene.bodies.map((body, i) => this.buildBody(body, i));
    this.pairs = scene.pairs.map((pair) => this.buildPair(pair));
    for (const { body, surface, mount } of scene.zones) {
      const zone = surfaceMesh(this.surfaces[surface], c.bad);
      zone.userData.mount = mount;
      this.world.add(zone);
      (this.bodies[body].zones ??= []).push(zone);
    }
  }

  buildBody(body, i) {
    const colour = body.agent ? robotColour(i) : colours().grey;
    const shape = !body.agent
      ? new THREE.Mesh(new THREE.SphereBufferGeometry(0.12, 24, 16), new THREE.MeshLambertMaterial({ color: colour }))
      : robotShape(body.robot, colour);
    const parts = { shape, label: document.createElement('span') };
    this.world.add(shape);
    if (!body.agent && body.hard > 0) {
      parts.hard = new THREE.Mesh(new THREE.SphereBufferGeometry(body.hard, 32, 20),
        new THREE.MeshBasicMaterial({ color: colours().bad, transparent: true, opacity: 0.13, depthWrite: false }));
      const wire = new THREE.Mesh(new THREE.SphereBufferGeometry(body.hard, 16, 10),
        new THREE.MeshBasicMaterial({ color: colours().bad, wireframe: true, transparent: true, opacity: 0.18 }));
      parts.hard.add(wire);
      this.world.add(parts.hard);
    }
    if (body.agent) {
      parts.path = line(pathPoints, colour, true);
      parts.trail = line(trailPoints, colour, false);
      parts.trail.material.transparent = true;
      parts.trail.material.opacity = 0.45;
      this.world.add(parts.path, parts.trail);
      if (body.localized) this.world.add(parts.estimate = ellipsoid(colour));
    }
    parts.label.textContent = body.name;
    this.labels.append(parts.label);
    return parts;
  }

  buildPair(pair) {
    const whole = line(2, colours().good, false), dashed = line(2, colours().bad, true);
    const parts = { whole, dashed, label: document.createElement('span') };
    if (pair.surface !== null) {
      parts.region = surfaceMesh(this.surfaces[pair.surface], colours().good);
      this.world.add(parts.region);
    }
    this.world.add(whole, dashed);
    this.labels.append(parts.label);
    return parts;
  }

  // Looks at all that is there.
  frame(moment) {
    const box = new THREE.Box3();
    for (const seen of moment.b) if (seen) box.expandByPoint(new THREE.Vector3(seen[0], seen[1], seen[2]));
    if (box.isEmpty()) return;
    const centre = box.getCenter(new THREE.Vector3()), away = Math.max(4.5, 1.1 * box.getSize(new THREE.Vector3()).length());
    this.controls.target.copy(centre);
    this.camera.position.copy(centre).add(new THREE.Vector3(-0.53, -0.66, 0.53).multiplyScalar(away));
  }

  draw(history, index) {
    const moment = history.moments[index];
    if (!moment) return;
    this.changed = false;
    let robot = 0;
    this.scene.bodies.forEach((body, i) => { if (body.agent) this.drawEstimate(this.bodies[i], moment.e?.[robot++]); });
    this.scene.bodies.forEach((body, i) => this.drawBody(body, i, moment, history, index));
    this.scene.pairs.forEach((pair, i) => this.drawPair(pair, i, moment));
    this.aim(moment);
    this.renderer.render(this.world, this.camera);
    this.placeLabels(moment);
  }

  drawEstimate(parts, estimate) {
    if (parts.estimate) parts.estimate.visible = Boolean(estimate) && setEllipsoid(parts.estimate, estimate, ellipsoidSigmas);
  }

  drawBody(body, i, moment, history, index) {
    const parts = this.bodies[i], seen = moment.b[i];
    for (const zone of parts.zones ?? []) {
      zone.visible = seen !== null;
      if (!seen) continue;
      const { mount } = zone.userData, at = mount ? this.sensor(mount, seen) : { position: new THREE.Vector3(seen[0], seen[1], seen[2]), quaternion: zone.quaternion };
      zone.position.copy(at.position);
      zone.quaternion.copy(at.quaternion);
    }
    parts.shape.visible = seen !== null && !(this.followed?.sensor && this.followed.body === i);
    for (const one of [parts.hard, parts.path, parts.trail]) if (one) one.visible = seen !== null;
    if (seen === null) return;
    parts.shape.position.set(seen[0], seen[1], seen[2]);
    parts.shape.quaternion.set(seen[3], seen[4], seen[5], seen[6]);
    if (parts.hard) parts.hard.position.copy(parts.shape.position);
    if (!body.agent) return;
    const path = moment.paths?.[i] ?? [];
    setLine(parts.path, path.includes(null) ? [] : path, path.includes(null) ? 0 : path.length / 3);
    const trail = [], step = 3;
    for (let k = Math.max(0, index - step * (trailPoints - 2)); k <= index; k += step) {
      const then = history.moments[k].b[i];
      if (then) trail.push(then[0], then[1], then[2]);
    }
    setLine(parts.trail, trail, trail.length / 3);
  }

  drawPair(pair, i, moment) {
    const parts = this.pairs[i], view = moment.p[i];
    const there = view !== null && moment.b[pair.observer] !== null && moment.b[pair.target] !== null;
    parts.whole.visible = there && view[0] === 1;
    parts.dashed.visible = there && view[0] !== 1;
    // From within, a region is the picture's edge.
    if (parts.region) parts.region.visible = there;
    if (!there) return;
    const a = moment.b[pair.observer], b = moment.b[pair.target];
    setLine(view[0] === 1 ? parts.whole : parts.dashed, [a[0], a[1], a[2], b[0], b[1], b[2]], 2);
    if (!parts.region) return;
    const { position, quaternion } = this.sensor(pair.mount, a);
    parts.region.position.copy(position);
    parts.region.quaternion.copy(quaternion);
    if (parts.region.userData.scales) parts.region.scale.setScalar(Math.min(10, Math.max(0.5, view[1])));
    colourSurface(parts.region, view[0] === 1 ? colours().good : colours().bad);
  }

  // Where a sensor is and how it looks: its axis is x, as mounted on the body, or on what is level in its heading.
  sensor(mount, seen) {
    const body = new THREE.Quaternion(seen[3], seen[4], seen[5], seen[6]);
    if (!mount.on_body) {
      const ahead = new THREE.Vector3(1, 0, 0).applyQuaternion(body);
      body.setFromAxisAngle(new THREE.Vector3(0, 0, 1), Math.atan2(ahead.y, ahead.x));
    }
    const position = new THREE.Vector3(...mount.offset).applyQuaternion(body).add(new THREE.Vector3(seen[0], seen[1], seen[2]));
    const quaternion = body.multiply(new THREE.Quaternion(...mount.turned));
    return { position, quaternion };
  }

  follow(followed) {
    // Behind a sensor there is no place to orbit from: the one before is taken again.
    const { camera, controls } = this, alpha = followed?.sensor?.alpha;
    if (followed?.sensor && !this.followed?.sensor) this.before = { from: camera.position.clone(), to: controls.target.clone() };
    if (!followed?.sensor && this.followed?.sensor) {
      camera.position.copy(this.before.from);
      controls.target.copy(this.before.to);
    }
    camera.fov = alpha ? Math.min(110, Math.max(20, (2.3 * alpha * 180) / Math.PI)) : orbitAngle;
    camera.updateProjectionMatrix();
    this.followed = followed;
    this.changed = true;
    this.orbit(true);
    this.last = null;
  }

  // Whether the pointer turns the camera; behind a sensor it never does.
  orbit(may) {
    this.controls.enabled = may && !this.followed?.sensor;
  }

  aim(moment) {
    const seen = this.followed && moment.b[this.followed.body];
    if (seen && this.followed.sensor) {
      const { position, quaternion } = this.sensor(this.followed.sensor, seen);
      this.camera.position.copy(position);
      this.camera.up.set(0, 0, 1).applyQuaternion(quaternion);
      this.camera.lookAt(position.clone().add(new THREE.Vector3(1, 0, 0).applyQuaternion(quaternion)));
      return;
    }
    this.camera.up.set(0, 0, 1);
    if (seen) {
      const now = new THREE.Vector3(seen[0], seen[1], seen[2]);
      this.camera.position.add(now.clone().sub(this.last ?? this.controls.target));
      this.controls.target.copy(now);
      this.last = now;
    }
    this.controls.update();
  }

  placeLabels(moment) {
    const { clientWidth: w, clientHeight: h } = this.element;
    const place = (label, point) => {
      const at = point.project(this.camera);
      const shown = at.z < 1 && Math.abs(at.x) < 1.1 && Math.abs(at.y) < 1.1;
      label.hidden = !shown;
      if (shown) label.style.transform = `translate(${((at.x + 1) * w) / 2}px, ${((1 - at.y) * h) / 2}px) translate(-50%, -50%)`;
    };
    this.scene.bodies.forEach((body, i) => {
      const seen = moment.b[i], label = this.bodies[i].label;
      if (seen === null) label.hidden = true;
      else place(label, new THREE.Vector3(seen[0], seen[1], seen[2] + 0.3));
    });
    this.scene.pairs.forEach((pair, i) => {
      const view = moment.p[i], label = this.pairs[i].label, a = moment.b[pair.observer], b = moment.b[pair.target];
      if (view === null || a === null || b === null || this.scene.pairs.length > 12) {
        label.hidden = true;
        return;
      }
      label.textContent = `${view[1].toFixed(2)} m`;
      place(label, new THREE.Vector3((a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2));
    });
  }
}
