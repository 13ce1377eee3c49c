// Reads every message of a log with the format's own library and checks every CRC.
// node read_mcap.mjs FILE: one line with the messages per topic, exit 0; or one sentence on stderr,
// exit 1.
import { crc32 } from "@foxglove/crc";
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { FileHandleReadable } from "@mcap/nodejs";
import { loadDecompressHandlers } from "@mcap/support";
import { open } from "node:fs/promises";

const text = (bytes) => new TextDecoder("utf-8", { fatal: true }).decode(bytes);

function expect(condition, sentence) {
  if (!condition) throw new Error(sentence);
}

// What turns a channel's bytes into a message.
function decoder(channel, schema) {
  if (channel.messageEncoding === "json") {
    expect(schema.encoding === "jsonschema", `${channel.topic} is json with a ${schema.encoding} schema`);
    JSON.parse(text(schema.data));
    return (bytes) => JSON.parse(text(bytes));
  }
  expect(channel.messageEncoding === "cdr", `${channel.topic} has the encoding ${channel.messageEncoding}`);
  expect(schema.encoding === "ros2msg", `${channel.topic} is cdr with a ${schema.encoding} schema`);
  const reader = new MessageReader(parse(text(schema.data), { ros2: true }));
  return (bytes) => reader.readMessage(bytes);
}

// Every number of a decoded message is finite, and orientations have length one.
function check(topic, message) {
  for (const value of Object.values(message ?? {})) {
    if (typeof value === "number") expect(Number.isFinite(value), `${topic} holds ${value}`);
    else if (typeof value === "object") check(topic, value);
  }
  if (message?.orientation != undefined) {
    const { x, y, z, w } = message.orientation;
    expect(Math.abs(Math.hypot(x, y, z, w) - 1) < 1e-9, `${topic} has an orientation whose length is not 1`);
  }
}

// Messages per topic in the order of the file, as one reads a log from a pipe.
async function stream(file, decompressHandlers) {
  const reader = new McapStreamReader({ validateCrcs: true, decompressHandlers });
  const channels = new Map(), schemas = new Map(), decoders = new Map(), counts = {};
  const take = () => {
    for (let record; (record = reader.nextRecord()) != undefined; ) {
      if (record.type === "Schema") schemas.set(record.id, record);
      if (record.type === "Channel" && !channels.has(record.id)) {
        channels.set(record.id, record);
        decoders.set(record.id, decoder(record, schemas.get(record.schemaId)));
      }
      if (record.type !== "Message") continue;
      const { topic, messageEncoding } = channels.get(record.channelId);
      const message = decoders.get(record.channelId)(record.data);
      if (messageEncoding === "cdr") check(topic, message);
      counts[topic] = (counts[topic] ?? 0) + 1;
    }
  };
  for await (const piece of file.createReadStream({ start: 0, autoClose: false })) {
    reader.append(piece);
    take();
  }
  expect(reader.done(), "the log ends early");
  return counts;
}

// The same through the index, as a viewer seeks.
async function index(file, decompressHandlers) {
  const readable = new FileHandleReadable(file);
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  const counts = {};
  let last = 0n;
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const { topic } = reader.channelsById.get(message.channelId);
    counts[topic] = (counts[topic] ?? 0) + 1;
    expect(message.logTime >= last, `${topic} goes back in time`);
    last = message.logTime;
  }
  for (const { id, topic } of reader.channelsById.values()) {
    const stated = Number(reader.statistics.channelMessageCounts.get(id));
    const here = counts[topic] ?? 0;
    expect(stated === here, `the statistics state ${stated} messages on ${topic}, the index holds ${here}`);
  }
  const names = [];
  for await (const { name } of reader.readMetadata()) names.push(name);
  const stated = reader.statistics.metadataCount;
  expect(names.length === stated, `${stated} metadata records are stated, ${names.length} are there`);
  return { counts, names, reader };
}

// The CRC of everything before the data end, which the library leaves to its user.
async function checkDataSection(file, reader) {
  const dataEnd = 9 + 4;
  const bytes = Buffer.alloc(Number(reader.footer.summaryStart) - dataEnd);
  await file.read(bytes, 0, bytes.length, 0);
  expect(crc32(bytes) === reader.dataSectionCrc, "the data section does not match its CRC");
}

const sorted = (counts) => Object.entries(counts).sort(([a], [b]) => (a < b ? -1 : 1));

try {
  expect(process.argv.length === 3, "usage: node read_mcap.mjs FILE");
  const decompressHandlers = await loadDecompressHandlers();
  const file = await open(process.argv[2]);
  try {
    const streamed = sorted(await stream(file, decompressHandlers));
    const { counts, names, reader } = await index(file, decompressHandlers);
    const indexed = sorted(counts);
    expect(
      JSON.stringify(streamed) === JSON.stringify(indexed),
      `the stream holds ${JSON.stringify(streamed)}, the index ${JSON.stringify(indexed)}`,
    );
    await checkDataSection(file, reader);
    const topics = streamed.map(([topic, count]) => `${topic} ${count}`).join(", ");
    console.log(`${topics}; ${reader.chunkIndexes.length} chunks; metadata ${names.join(", ")}`);
  } finally {
    await file.close();
  }
} catch (error) {
  console.error(`${process.argv[2] ?? "read_mcap.mjs"}: ${error.message}`);
  process.exitCode = 1;
}
