// Compares two logs message by message: topic, times and bytes, in the order of the files; metadata
// may differ, and the second may have topics that the first has not.
// node same_mcap.mjs FILE FILE: one line with the messages, exit 0; or the first that differs on
// stderr, exit 1.
import { McapStreamReader } from "@mcap/core";
import { loadDecompressHandlers } from "@mcap/support";
import { createReadStream } from "node:fs";

async function* messages(path, decompressHandlers, known) {
  const reader = new McapStreamReader({ decompressHandlers });
  const topics = new Map();
  for await (const piece of createReadStream(path)) {
    reader.append(piece);
    for (let record; (record = reader.nextRecord()) != undefined; ) {
      if (record.type === "Channel") topics.set(record.id, record.topic);
      if (record.type !== "Message") continue;
      const topic = topics.get(record.channelId);
      if (known === undefined || known.has(topic)) yield { ...record, topic };
    }
  }
}

const place = (m) => `${m.topic} at ${Number(m.logTime) / 1e9} s`;
const same = (a, b) =>
  a.topic === b.topic && a.logTime === b.logTime && a.publishTime === b.publishTime && Buffer.compare(a.data, b.data) === 0;

const [first, second] = process.argv.slice(2);
const handlers = await loadDecompressHandlers();
const known = new Set();
for await (const { topic } of messages(first, handlers)) known.add(topic);
const others = messages(second, handlers, known);
let count = 0;
for await (const message of messages(first, handlers)) {
  const { value, done } = await others.next();
  if (done || !same(message, value)) {
    console.error(`message ${count}: ${place(message)}, in the other log ${done ? "none" : `${place(value)}, other bytes`}`);
    process.exit(1);
  }
  ++count;
}
const { value, done } = await others.next();
if (!done) {
  console.error(`message ${count}: none, in the other log ${place(value)}`);
  process.exit(1);
}
console.log(`${count} messages, all the same`);
