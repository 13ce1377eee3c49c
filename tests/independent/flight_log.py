"""What a flight left in run.mcap, as arrays over time. Reads the bytes of MCAP and CDR by their specifications."""

import ctypes
import json
import struct

import numpy as np

_zstd = ctypes.CDLL("libzstd.so.1")
_zstd.ZSTD_decompress.restype = ctypes.c_size_t
_zstd.ZSTD_decompress.argtypes = [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_size_t]
_magic = b"\x89MCAP0\r\n"


def _decompressed(data, size):
    to = ctypes.create_string_buffer(size)
    if _zstd.ZSTD_decompress(to, size, data, len(data)) != size:
        raise ValueError("a chunk cannot be decompressed")
    return to.raw


class _Fields:
    """The fields of one record, one after the other."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def number(self, form):
        (value,) = struct.unpack_from("<" + form, self.data, self.at)
        self.at += struct.calcsize("<" + form)
        return value

    def raw(self, length):
        self.at += length
        return self.data[self.at - length : self.at]

    def text(self):
        return self.raw(self.number("I")).decode()

    def words(self):
        end = self.number("I") + self.at
        words = {}
        while self.at < end:
            key = self.text()
            words[key] = self.text()
        return words


def _records(data, at):
    while at + 9 <= len(data):
        kind, (length,) = data[at], struct.unpack_from("<Q", data, at + 1)
        if at + 9 + length > len(data):
            raise ValueError("the log ends within a record")
        yield kind, data[at + 9 : at + 9 + length]
        at += 9 + length


def messages(data, metadata):
    """(topic, time [ns], bytes) of each message in the order of the file; fills `metadata`."""
    if data[:8] != _magic or data[-8:] != _magic:
        raise ValueError("the log is not whole")
    channels = {}

    def read(kind, body):
        fields = _Fields(body)
        if kind == 0x04:
            number = fields.number("H")
            fields.number("H")
            channels[number] = fields.text()
        elif kind == 0x05:
            number = fields.number("H")
            fields.number("I")
            time = fields.number("Q")
            fields.number("Q")
            yield channels[number], time, body[fields.at :]
        elif kind == 0x06:
            fields.raw(16)
            size = fields.number("Q")
            fields.number("I")
            packed, inner = fields.text(), fields.raw(fields.number("Q"))
            for one, within in _records(_decompressed(inner, size) if packed == "zstd" else inner, 0):
                yield from read(one, within)
        elif kind == 0x0C:
            name = fields.text()
            metadata[name] = fields.words()

    for kind, body in _records(data[:-8], 8):
        if kind == 0x0F:  # what follows is the index
            break
        yield from read(kind, body)


def _behind_header(body):
    (length,) = struct.unpack_from("<I", body, 12)
    return 4 + (12 + length + 7) // 8 * 8


def _pose(body):
    x, y, z, qx, qy, qz, qw = struct.unpack_from("<7d", body, _behind_header(body))
    ahead, left = 1 - 2 * (qy * qy + qz * qz), 2 * (qw * qz + qx * qy)
    length = np.hypot(ahead, left)
    return x, y, z, ahead / length, left / length


def _numbers(values):
    return [np.nan if value is None else value for value in values]


class Body:
    """Rows are the samples: state x, position p, heading d, velocity v; of a robot inputs u and raw."""

    def __init__(self, is_robot):
        self.is_robot = is_robot
        self.rows = {"x": {}, "p": {}, "d": {}, "v": {}, "u": {}, "raw": {}, "active": {}}

    def settle(self, steps):
        for key, rows in self.rows.items():
            width = len(next(iter(rows.values()))) if rows else {"d": 2, "active": 1}.get(key, 3)
            table = np.full((len(steps), width), np.nan)
            for i, step in enumerate(steps):
                if step in rows:
                    table[i] = rows[step]
            setattr(self, key, table)
        del self.rows
        self.there = np.isfinite(self.p[:, 0])


class Flight:
    """steps: periods since the start, of each sample; commanded: whether the sample has a command."""

    def __init__(self, file):
        metadata = {}
        with open(file, "rb") as log:
            data = log.read()
        self.bodies, self.events, solver = {}, [], {}
        steps = set()
        for topic, time, body in messages(data, metadata):
            if not self.bodies:
                self._begin(metadata["sightline"])
            step = round(1e-9 * time / self.period)
            name, _, what = topic[1:].rpartition("/")
            if topic == "/events":
                event = json.loads(body)
                self.events.append((event["time"], event["kind"], event["value"]))
            elif what == "solver":
                solver.setdefault(step, []).append(json.loads(body)["status"])
            elif name in self.bodies:
                self._take(self.bodies[name].rows, what, step, body)
                if what == "state":
                    steps.add(step)
        self.steps = np.array(sorted(steps))
        self.times = self.steps * self.period
        self.status = [solver.get(step, []) for step in self.steps]
        self.commanded = np.array([bool(statuses) for statuses in self.status])
        for body in self.bodies.values():
            body.settle(self.steps)

    def _begin(self, words):
        self.period, self.solver = float(words["period"]), words["solver"]
        team = json.loads(words["team"])
        self.names = [body["name"] for body in team["bodies"]]
        self.script = team.get("events") or []
        for body in team["bodies"]:
            self.bodies[body["name"]] = Body(body["kind"] == "agent")

    @staticmethod
    def _take(rows, what, step, body):
        if what == "state":
            rows["x"][step] = _numbers(json.loads(body)["x"])
        elif what == "pose":
            pose = _pose(body)
            rows["p"][step], rows["d"][step] = pose[:3], pose[3:]
        elif what == "twist":
            rows["v"][step] = struct.unpack_from("<3d", body, _behind_header(body))
        elif what == "input":
            message = json.loads(body)
            rows["u"][step], rows["raw"][step] = _numbers(message["u"]), _numbers(message["raw"])
        elif what == "barrier":
            rows["active"][step] = [1.0 if json.loads(body)["active"] else 0.0]

    @property
    def robots(self):
        return [name for name in self.names if self.bodies[name].is_robot]

    @property
    def end(self):
        """Of the last period that had a command [s]."""
        return self.times[self.commanded][-1] + self.period

    def step_of(self, time):
        """The first sample at a time or later."""
        return int(np.searchsorted(self.times, time - 1e-9))
