"""What ten clients cost a flight in real time:  client_figures.py [--short]

Flies a scenario in turns without a server, and with one that ten WebSocket clients look on at, one of which reads nothing.
Prints what was measured, and ends with 1 where missed periods or the time of an update are beyond their limit.
"""

import csv
import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

root = Path(__file__).resolve().parents[1]
sightline = os.environ.get("SIGHTLINE_BINARY", root / "build/release/bin/sightline")
short = "--short" in sys.argv
turns, seconds = (1, 10) if short else (5, 120)
missed_more, ratio_most = (20.0, 20.0) if short else (0.1, 1.3)  # points; short: on a machine that does other things too


def fly(folder, clients):
    """One turn. Returns the times of its updates [us], its missed periods, and what the clients counted."""
    command = [sightline, "run", root / "scenarios/cooperative_localization.toml", "--realtime", "-o", folder,
               "--set", f"simulation.duration={seconds}"]
    if clients:
        command += ["--view", "--port", "0"]
    flight = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    watching = None
    for line in flight.stderr:
        url = re.search(r"http://\S+", line)
        if clients and url and watching is None:
            words = ["node", root / "tests/npm/page_clients.mjs", url.group(), "10"]
            watching = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    flight.wait()
    counts = json.loads(watching.communicate(timeout=60)[0]) if watching else None
    with open(folder / "timing.csv") as file:
        rows = list(csv.DictReader(file))
    return [float(row["update_us"]) for row in rows], sum(int(row["missed"]) for row in rows), counts


def main():
    updates, missed, counts = {False: [], True: []}, {False: 0, True: 0}, []
    with tempfile.TemporaryDirectory() as folder:
        for turn in range(turns):
            for clients in (False, True) if turn % 2 == 0 else (True, False):
                times, periods, reported = fly(Path(folder) / f"{turn}{clients}", clients)
                updates[clients] += times
                missed[clients] += periods
                if reported:
                    counts.append(reported)

    def p99(clients):
        return sorted(updates[clients])[int(0.99 * len(updates[clients]))]

    def share(clients):
        return 100 * missed[clients] / (len(updates[clients]) + missed[clients])

    for clients in (False, True):
        print(f"{'ten clients' if clients else 'no server'}: {len(updates[clients])} updates, p99 {p99(clients):.1f} us, "
              f"{missed[clients]} periods missed ({share(clients):.3f} %)")
    states, messages, deaf = (sum(one[key] for one in counts) for key in ("states", "messages", "deaf"))
    print(f"they received {states} states and {messages} messages; the one that reads nothing came {deaf} times")
    more, ratio = share(True) - share(False), p99(True) / p99(False)
    print(f"{more:+.3f} points missed, at most {missed_more}; p99 x {ratio:.2f}, at most {ratio_most}")
    watched = states > 20 * seconds * turns and messages > 1000 * seconds * turns
    sys.exit(not (watched and more <= missed_more and ratio <= ratio_most))


main()
