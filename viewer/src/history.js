// What is known of a flight: its scene, and its moments by their time.

export class History {
  constructor(scene) {
    this.scene = scene;
    this.moments = [];
    this.events = []; // [number, time, words]
    this.levels = []; // {body, level, from, until} of robots; until is null while it lasts
    this.lasting = new Map(); // of each body, the last of its levels
    this.longest = scene.live ? 36000 : Infinity; // moments of a live flight that are kept: 20 minutes
  }

  add(moment) {
    const last = this.moments.at(-1);
    if (last && moment.t <= last.t) return false;
    for (const event of moment.events ?? []) {
      if (this.events.length === 0 || event[0] > this.events.at(-1)[0]) this.events.push(event);
    }
    moment.levels?.forEach((level, body) => this.addLevel(body, level, moment.t));
    // A prediction stands until the next one.
    if (!moment.paths && last) moment.paths = last.paths;
    this.moments.push(moment);
    if (this.moments.length > this.longest) this.moments.splice(0, this.longest / 10);
    return true;
  }

  addLevel(body, level, t) {
    const before = this.lasting.get(body);
    if (before?.level === level || !this.scene.bodies[body]?.agent) return;
    if (before) before.until = t;
    const one = { body, level, from: t, until: null };
    this.lasting.set(body, one);
    this.levels.push(one);
  }

  get begin() { return this.moments[0]?.t ?? 0; }
  get end() { return this.moments.at(-1)?.t ?? 0; }

  // Place of the last moment that is not after t.
  indexAt(t) {
    let low = 0, high = this.moments.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.moments[middle].t <= t) low = middle; else high = middle - 1;
    }
    return low;
  }
}
