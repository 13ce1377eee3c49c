// Robots, lines, surfaces and ellipsoids as three draws them; each robot is one mesh, so that it costs one draw.
import * as THREE from 'three/three.module.js';
import { BufferGeometryUtils } from 'three/examples/jsm/utils/BufferGeometryUtils.js';

const place = (geometry, { at = [0, 0, 0], turn = [0, 0, 0] }) =>
  geometry.applyMatrix(new THREE.Matrix4().compose(new THREE.Vector3(...at), new THREE.Quaternion().setFromEuler(new THREE.Euler(...turn)), new THREE.Vector3(1, 1, 1)));

const corners = [[1, 1], [1, -1], [-1, 1], [-1, -1]];
const cross = Math.PI / 2;

function multirotor() {
  const parts = [place(new THREE.BoxBufferGeometry(0.22, 0.12, 0.07), {}), place(new THREE.ConeBufferGeometry(0.05, 0.12, 12), { at: [0.17, 0, 0], turn: [0, 0, -cross] })];
  for (const [x, y] of corners) {
    parts.push(place(new THREE.TorusBufferGeometry(0.1, 0.012, 6, 20), { at: [0.17 * x, 0.17 * y, 0.03] }));
    parts.push(place(new THREE.BoxBufferGeometry(0.24, 0.025, 0.025), { at: [0.085 * x, 0.085 * y, 0.01], turn: [0, 0, Math.atan2(y, x)] }));
  }
  return parts;
}

function rover() {
  const parts = [place(new THREE.BoxBufferGeometry(0.36, 0.24, 0.1), { at: [0, 0, 0.1] }), place(new THREE.ConeBufferGeometry(0.08, 0.14, 4), { at: [0.24, 0, 0.1], turn: [0, 0, -cross] })];
  for (const [x, y] of corners) parts.push(place(new THREE.CylinderBufferGeometry(0.07, 0.07, 0.05, 16), { at: [0.12 * x, 0.14 * y, 0.07] }));
  return parts;
}

const isRover = (robot) => /unicycle|car|rover|differential|ackermann|mecanum|omni|ground/.test(robot);

export function robotShape(robot, colour) {
  const geometry = BufferGeometryUtils.mergeBufferGeometries(isRover(robot) ? rover() : multirotor());
  return new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({ color: colour }));
}

export function line(points, colour, dashed) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(3 * points), 3));
  const material = dashed
    ? new THREE.LineDashedMaterial({ color: colour, dashSize: 0.08, gapSize: 0.06 })
    : new THREE.LineBasicMaterial({ color: colour });
  const drawn = new THREE.Line(geometry, material);
  drawn.frustumCulled = false;
  return drawn;
}

// The walls of a prism, with its edges.
export function prismShape({ polygon, low, high }, colour) {
  const at = [], corners = polygon.length / 2, corner = (i) => polygon.slice(2 * (i % corners), 2 * (i % corners) + 2);
  for (let i = 0; i < corners; ++i) {
    const a = corner(i), b = corner(i + 1);
    at.push(...a, low, ...b, low, ...b, high, ...a, low, ...b, high, ...a, high);
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(at), 3));
  const walls = new THREE.Mesh(geometry,
    new THREE.MeshBasicMaterial({ color: colour, transparent: true, opacity: 0.13, side: THREE.DoubleSide, depthWrite: false }));
  walls.add(new THREE.LineSegments(new THREE.EdgesGeometry(geometry), new THREE.LineBasicMaterial({ color: colour, transparent: true, opacity: 0.5 })));
  return walls;
}

export function setLine(drawn, numbers, count) {
  const at = drawn.geometry.attributes.position, shown = Math.min(count, at.count);
  for (let i = 0; i < 3 * shown; ++i) at.array[i] = numbers[i];
  at.needsUpdate = true;
  drawn.geometry.setDrawRange(0, shown);
  if (drawn.material.isLineDashedMaterial) drawn.computeLineDistances();
}

// The edges at which two triangles meet at more than 24 degrees, or that are of one alone; triangles are either way round. What is
// hardly a triangle has no clear direction.
function edgesOf({ corners, triangles, reach }) {
  const at = (i) => new THREE.Vector3(corners[3 * i], corners[3 * i + 1], corners[3 * i + 2]), met = new Map(), drawn = [];
  for (let t = 0; t < triangles.length; t += 3) {
    const ends = triangles.slice(t, t + 3), [a, b, c] = ends.map(at), normal = b.sub(a).cross(c.sub(a));
    if (normal.length() < 2e-4 * reach * reach) normal.set(0, 0, 0); else normal.normalize();
    ends.forEach((one, k) => {
      const other = ends[(k + 1) % 3], key = `${Math.min(one, other)} ${Math.max(one, other)}`;
      if (met.has(key)) met.get(key).push(normal); else met.set(key, [normal]);
    });
  }
  for (const [key, normals] of met) {
    if (normals.some((one) => one.lengthSq() === 0)) continue;
    if (normals.length === 2 && Math.abs(normals[0].dot(normals[1])) > Math.cos((24 * Math.PI) / 180)) continue;
    for (const end of key.split(' ')) drawn.push(...at(Number(end)).toArray());
  }
  return new THREE.BufferGeometry().setAttribute('position', new THREE.Float32BufferAttribute(drawn, 3));
}

// The geometries of a scene's surfaces, each made once: the surface and its edges.
export function surfaceGeometries(surfaces) {
  return surfaces.map((surface) => {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.Float32BufferAttribute(surface.corners, 3));
    geometry.setIndex(surface.triangles);
    return { geometry, edges: edgesOf(surface), scales: surface.scales };
  });
}

export function surfaceMesh({ geometry, edges, scales }, colour) {
  const material = new THREE.MeshBasicMaterial({ color: colour, transparent: true, opacity: 0.15, side: THREE.DoubleSide, depthWrite: false });
  const mesh = new THREE.Mesh(geometry, material);
  mesh.add(new THREE.LineSegments(edges, new THREE.LineBasicMaterial({ color: colour, transparent: true, opacity: 0.6 })));
  mesh.userData.scales = scales;
  return mesh;
}

export function colourSurface(mesh, colour) {
  mesh.material.color.set(colour);
  mesh.children[0].material.color.set(colour);
}

export function ellipsoid(colour) {
  const mesh = new THREE.Mesh(new THREE.SphereBufferGeometry(1, 20, 12), new THREE.MeshBasicMaterial({ color: colour, transparent: true, opacity: 0.35, depthWrite: false, depthTest: false }));
  mesh.renderOrder = 1; // it is mostly within its robot
  mesh.matrixAutoUpdate = false;
  mesh.frustumCulled = false;
  return mesh;
}

// All places within `sigmas` standard deviations of an estimate [x, y, z, P_xx, P_xy, P_xz, P_yy, P_yz, P_zz]: the unit sphere by
// Cholesky's factor of P. False where P is no covariance.
export function setEllipsoid(mesh, e, sigmas) {
  const [x, y, z, xx, xy, xz, yy, yz, zz] = e;
  if (e.slice(0, 9).includes(null) || !(xx > 0)) return false;
  const a = Math.sqrt(xx), b = xy / a, c = xz / a;
  const dd = yy - b * b, d = Math.sqrt(Math.max(dd, 0)), f = d > 0 ? (yz - b * c) / d : 0, g = Math.sqrt(Math.max(zz - c * c - f * f, 0));
  const s = sigmas;
  mesh.matrix.set(s * a, 0, 0, x, s * b, s * d, 0, y, s * c, s * f, s * g, z, 0, 0, 0, 1);
  mesh.matrixWorldNeedsUpdate = true;
  return true;
}
