// Where moments come from: a flight that goes on, by a WebSocket that is opened again when it breaks, or a finished log.

const told = () => {
  const token = new URLSearchParams(location.search).get('token');
  return token === null ? '' : `?token=${encodeURIComponent(token)}`;
};

const get = async (path) => {
  const answer = await fetch(path + told());
  if (!answer.ok) throw new Error(await answer.text());
  return answer.json();
};

export class Source {
  // on: {scene(scene), moments(list), link(state)}, states: connecting, live, lost, log, refused
  constructor(on) {
    this.on = on;
    this.session = null;
    this.wait = 250;
    this.open();
  }

  async open() {
    try {
      const scene = await get('scene.json');
      const same = scene.session === this.session;
      this.session = scene.session;
      if (!same) this.on.scene(scene);
      if (scene.live) this.listen();
      else if (!same) {
        this.on.moments(await get('moments.json'));
        this.on.link('log');
      }
    } catch (error) {
      if (/token/.test(error.message)) this.on.link('refused');
      else this.again();
    }
  }

  listen() {
    const socket = new WebSocket(`ws://${location.host}/live${told()}`);
    socket.onopen = () => { this.wait = 250; this.on.link('live'); };
    socket.onmessage = (message) => this.on.moments([JSON.parse(message.data)]);
    socket.onclose = () => this.again();
  }

  again() {
    this.on.link('lost');
    setTimeout(() => this.open(), this.wait);
    this.wait = Math.min(4000, 2 * this.wait);
  }
}
