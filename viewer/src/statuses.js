// The table of statuses: built once for a scene, then only what changed is written.
import { robotColour } from './palette.js';

function table(heads, rows) {
  const made = document.createElement('table'), head = made.createTHead().insertRow();
  for (const [words, kind] of heads) {
    const one = document.createElement('th');
    one.textContent = words;
    one.className = kind;
    head.append(one);
  }
  const body = made.createTBody();
  const cells = rows.map((name) => {
    const row = body.insertRow(), first = row.insertCell();
    first.append(name);
    return heads.slice(1).map(() => row.insertCell());
  });
  return { made, cells };
}

function write(cells, words) {
  words.forEach(([text, kind = ''], i) => {
    if (cells[i].textContent !== text) cells[i].textContent = text;
    if (cells[i].className !== kind) cells[i].className = kind;
  });
}

function named(body, i) {
  const name = document.createElement('span'), swatch = document.createElement('span');
  swatch.className = 'swatch';
  swatch.style.background = robotColour(i);
  name.append(swatch, body.name);
  return name;
}

const blank = (count) => Array.from({ length: count }, () => ['']);

export class Statuses {
  constructor(element) {
    this.element = element;
  }

  build(scene) {
    this.scene = scene;
    this.agents = scene.bodies.flatMap((body, i) => (body.agent ? [i] : []));
    this.robots = table([['Robot', ''], ['level', ''], ['barrier', ''], ['z [m]', 'number'], ['|u| / limit', 'number']],
      this.agents.map((i) => named(scene.bodies[i], i)));
    this.views = table([['View', ''], ['', ''], ['distance', 'number'], ['angle', 'number']],
      scene.pairs.map((pair) => `${scene.bodies[pair.observer].name} › ${scene.bodies[pair.target].name}`));
    this.solver = table([['Solver', ''], ['status', ''], ['residual', 'number'], ['steps', 'number'], ['time', 'number']], [scene.solver]);
    this.element.replaceChildren(this.robots.made, ...(scene.pairs.length > 0 ? [this.views.made] : []), this.solver.made);
  }

  draw(moment) {
    this.agents.forEach((i, k) => {
      const body = this.scene.bodies[i], u = moment.u[k] ?? [], acts = moment.barrier?.[k], seen = moment.b[i];
      const share = Math.max(...u.map((v, j) => Math.abs(v) / Math.max(Math.abs(body.u_min[j]), Math.abs(body.u_max[j]))));
      const level = seen === null ? 'not there' : moment.levels?.[i] ?? '';
      write(this.robots.cells[k], [[level, level === '' || level === 'valid' ? '' : 'bad'],
        [acts === undefined ? '' : acts ? 'active' : 'idle', acts ? 'bad' : ''], [seen?.[2].toFixed(2) ?? '', 'number'],
        [Number.isFinite(share) ? `${(100 * share).toFixed(0)} %` : '', 'number']]);
    });
    this.scene.pairs.forEach((pair, k) => {
      const view = moment.p[k];
      write(this.views.cells[k], view === null ? [['no view required'], ...blank(2)] : [[view[0] ? '● in view' : '○ out of view', view[0] ? 'good' : 'bad'],
        [`${view[1].toFixed(2)} m`, 'number'], [view[2] === null ? '' : `${((180 / Math.PI) * view[2]).toFixed(1)}°`, 'number']]);
    });
    write(this.solver.cells[0], [[moment.status, /converged|stepped/.test(moment.status) ? 'good' : 'bad'],
      [moment.residual === null ? '' : moment.residual.toExponential(1), 'number'], [String(moment.it), 'number'],
      [moment.us === null ? '' : `${moment.us.toFixed(0)} µs`, 'number']]);
  }
}
