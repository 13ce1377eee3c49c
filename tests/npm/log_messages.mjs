// Prints the JSON messages of some topics of a log, one a line, with their topic.
// node log_messages.mjs FILE TOPIC ...
import { McapStreamReader } from "@mcap/core";
import { loadDecompressHandlers } from "@mcap/support";
import { createReadStream } from "node:fs";

const [file, ...asked] = process.argv.slice(2);
const reader = new McapStreamReader({ decompressHandlers: await loadDecompressHandlers() });
const topics = new Map();
const lines = [];
for await (const piece of createReadStream(file)) {
  reader.append(piece);
  for (let record; (record = reader.nextRecord()) != undefined; ) {
    if (record.type === "Channel") topics.set(record.id, record.topic);
    if (record.type !== "Message" || !asked.includes(topics.get(record.channelId))) continue;
    lines.push(JSON.stringify({ topic: topics.get(record.channelId), ...JSON.parse(new TextDecoder().decode(record.data)) }));
  }
}
console.log(lines.join("\n"));
