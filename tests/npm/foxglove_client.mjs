// Subscribes to all topics of a flight with the protocol's own client, and decodes all messages.
// node foxglove_client.mjs URL SECONDS: one line of JSON, exit 0; or one sentence on stderr, exit
// 1.
//   {protocol, name, session, statuses, times: {count, first, last},
//    topics: {"/uav0/pose": {encoding, schema, count, first, last, gap, message}}}
// Times in s; gap is the longest between two messages; message the last, decoded.
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import protocol from "@foxglove/ws-protocol";
import WebSocket from "ws";

const [url, seconds] = process.argv.slice(2);
const ws = new WebSocket(url, ["foxglove.websocket.v1"]);
const client = new protocol.FoxgloveClient({ ws });
const told = { statuses: [], times: { count: 0 }, topics: {} };
const subscriptions = new Map();
const text = (bytes) => new TextDecoder("utf-8", { fatal: true }).decode(bytes);

function decoder({ encoding, schema, schemaEncoding }) {
  if (encoding === "json" && schemaEncoding === "jsonschema") {
    JSON.parse(schema);
    return (bytes) => JSON.parse(text(bytes));
  }
  if (encoding !== "cdr" || schemaEncoding !== "ros2msg") throw new Error(`${encoding} with a schema in ${schemaEncoding}`);
  const reader = new MessageReader(parse(schema, { ros2: true }));
  return (bytes) => reader.readMessage(bytes);
}

function quit(sentence) {
  console.error(`${url}: ${sentence}`);
  process.exit(1);
}

function end() {
  console.log(JSON.stringify(told, (_, value) => (ArrayBuffer.isView(value) ? Array.from(value) : value)));
  process.exit(0);
}

client.on("error", (error) => quit(error.message));
client.on("close", end); // a flight that ends
client.on("serverInfo", ({ name, sessionId, capabilities }) => Object.assign(told, { name, session: sessionId, capabilities, protocol: ws.protocol }));
client.on("status", (status) => told.statuses.push(status));
client.on("time", ({ timestamp }) => {
  const time = Number(timestamp) / 1e9;
  told.times = { count: told.times.count + 1, first: told.times.first ?? time, last: time };
});
client.on("advertise", (channels) => {
  for (const channel of channels) {
    const { topic, encoding, schemaName } = channel;
    told.topics[topic] = { encoding, schema: schemaName, count: 0, gap: 0 };
    subscriptions.set(client.subscribe(channel.id), { topic, decode: decoder(channel) });
  }
});
client.on("message", ({ subscriptionId, timestamp, data }) => {
  const { topic, decode } = subscriptions.get(subscriptionId);
  const one = told.topics[topic], time = Number(timestamp) / 1e9;
  if (one.count > 0) one.gap = Math.max(one.gap, time - one.last);
  Object.assign(one, { count: one.count + 1, first: one.first ?? time, last: time, message: decode(data) });
});
setTimeout(end, 1000 * Number(seconds));
