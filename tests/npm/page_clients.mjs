// Looks on at a flight as often as asked: a third by its page, the others by Foxglove's protocol
// with all topics; the last one subscribes to all, reads nothing, and comes again whenever it is
// closed.
// node page_clients.mjs URL COUNT: until the server has gone; one line of JSON {states, messages,
// deaf}, what the page's and Foxglove's clients heard, and how often the last one came.
import net from "node:net";
import protocol from "@foxglove/ws-protocol";
import WebSocket from "ws";

const url = new URL(process.argv[2]);
const count = Number(process.argv[3]);
const told = { states: 0, messages: 0, deaf: 0 };
const socketUrl = (path) => `ws://${url.host}${path}${url.search}`;
let open = 0, deaf;

function left() {
  if (--open > 0) return;
  deaf?.destroy();
  console.log(JSON.stringify(told));
  process.exit(0);
}

function watch() {
  const ws = new WebSocket(socketUrl("/live"));
  ws.on("message", () => ++told.states);
  ws.on("close", left);
}

function subscribe() {
  const client = new protocol.FoxgloveClient({ ws: new WebSocket(socketUrl("/"), ["foxglove.websocket.v1"]) });
  client.on("advertise", (channels) => channels.forEach(({ id }) => client.subscribe(id)));
  client.on("message", () => ++told.messages);
  client.on("close", left);
}

// On a plain socket: a library reads whether it is asked to or not.
function readNothing() {
  ++told.deaf;
  const request = `{"op":"subscribe","subscriptions":[${Array.from({ length: 200 }, (_, id) => `{"id":${id},"channelId":${id}}`)}]}`;
  const head = Buffer.from([0x81, 0xfe, request.length >> 8, request.length & 0xff, 0, 0, 0, 0]); // a mask of zeros
  deaf = net.connect(Number(url.port), url.hostname, () =>
    deaf.write(
      `GET /${url.search} HTTP/1.1\r\nHost: ${url.host}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n` +
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: foxglove.websocket.v1\r\n\r\n",
    ),
  );
  deaf.once("data", () => {
    deaf.pause();
    deaf.write(Buffer.concat([head, Buffer.from(request)]));
  });
  deaf.on("error", () => {});
  // Paused, it hears of no end: it comes anew when the server's patience is surely over.
  setTimeout(() => (deaf.destroy(), readNothing()), 20_000);
}

for (let i = 0; i + 1 < count; ++i, ++open) (i % 3 === 0 ? watch : subscribe)();
readNothing();
