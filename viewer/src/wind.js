// The scenario's wind, in a corner of the stage: an arrow as the camera sees it, and its size.
import * as THREE from 'three/three.module.js';

const middle = 22, longest = 17;

export class Wind {
  constructor(element) {
    this.element = element;
    this.arrow = element.querySelector('line');
    this.words = element.querySelector('text');
  }

  build({ v, gust }) {
    this.vector = new THREE.Vector3(...v);
    const size = this.vector.length();
    this.element.toggleAttribute('hidden', size === 0 && gust === 0);
    const parts = [...(size > 0 ? [`wind ${size.toPrecision(2)} m/s²`] : []), ...(gust > 0 ? [`gusts σ ${gust.toPrecision(2)} m/s²`] : [])];
    this.words.textContent = parts.join(', ');
    this.arrow.toggleAttribute('hidden', size === 0);
  }

  draw(camera) {
    if (this.vector.lengthSq() === 0) return;
    const seen = this.vector.clone().normalize().transformDirection(camera.matrixWorldInverse).multiplyScalar(longest);
    const set = (name, value) => this.arrow.setAttribute(name, value.toFixed(1));
    set('x1', middle - seen.x);
    set('y1', middle + seen.y);
    set('x2', middle + seen.x);
    set('y2', middle - seen.y);
  }
}
