// Where moments come from, by a WebSocket that is opened again when it breaks: of a flight the moments themselves, of a log how many
// there are by now, which are then fetched.

const token = () => new URLSearchParams(location.search).get('token');

// A path's query: its parameters and the token of the page.
export const queryOf = (parameters = {}) => {
  const query = new URLSearchParams({ ...parameters, ...(token() === null ? {} : { token: token() }) }).toString();
  return query && `?${query}`;
};

export const get = async (path, parameters = {}) => {
  const answer = await fetch(path + queryOf(parameters));
  if (!answer.ok) throw new Error(await answer.text());
  return answer.json();
};

const fetchedAtOnce = 2000;

export class Source {
  // on: {scene(scene), moments(list), link(state, why)}, states: connecting, live, lost, refused; of a log growing, finished, broken
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
      if (!same) {
        this.count = 0;
        this.on.scene(scene);
      }
      this.listen(scene.live);
    } catch (error) {
      if (/token/.test(error.message)) this.on.link('refused');
      else this.again();
    }
  }

  listen(live) {
    const socket = new WebSocket(`ws://${location.host}/live${queryOf()}`);
    this.socket = socket;
    socket.onopen = () => { this.wait = 250; if (live) this.on.link('live'); };
    socket.onmessage = (message) => {
      const state = JSON.parse(message.data);
      if (live) this.on.moments([state]); else this.follow(state, socket);
    };
    socket.onclose = () => this.again();
  }

  // Fetches what a log has more than is known. Another session is another log.
  async follow(state, socket) {
    this.reported = state;
    if (this.fetches) return;
    this.fetches = true;
    try {
      while (this.reported.session === this.session && this.count < this.reported.moments) {
        const list = await get('moments.json', { from: this.count, most: fetchedAtOnce });
        if (list.length === 0) break;
        this.count += list.length;
        this.on.moments(list);
        // Of a log that grows faster than it is fetched there is always more.
        if (this.reported.state === 'growing') this.on.link('growing', this.reported.fault);
      }
      if (this.reported.session !== this.session) socket.close();
      else this.on.link(this.reported.state, this.reported.fault);
    } catch {
      socket.close();
    }
    this.fetches = false;
  }

  // @return whether it is on its way
  send(text) {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(text);
    return true;
  }

  again() {
    this.on.link('lost');
    setTimeout(() => this.open(), this.wait);
    this.wait = Math.min(4000, 2 * this.wait);
  }
}
