#!/usr/bin/env python3
"""Flies random scenarios by the command line and holds its verdicts against an independent judge.

campaign.py --draw PROGRAM --binary SIGHTLINE [--first SEED] [--count N] [--keep DIR]

Every tenth scenario is flown twice, every tenth with two threads as well, every fifth is replayed, and every hundredth is flown in
real time and stopped on the way. Ends with a line of what differed; exit 1 if anything did. SIGHTLINE_CAMPAIGN=whole flies 2000.
"""

import argparse
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from judge import Judge

longest = 300  # of a command [s]


class Campaign:
    def __init__(self, options, folder):
        self.options, self.folder = options, folder
        self.flown = self.refused = self.verdicts = self.commands = self.replays = self.bytes = 0
        self.codes, self.claims = {}, {}

    def call(self, *arguments):
        return subprocess.run([self.options.binary, *map(str, arguments)], capture_output=True, text=True, timeout=longest, check=False)

    def differ(self, scenario, claim, sentence):
        print(f"{scenario.name}: {claim}: {sentence}", flush=True)
        self.claims[claim] = self.claims.get(claim, 0) + 1
        if self.options.keep:
            self.options.keep.mkdir(parents=True, exist_ok=True)
            shutil.copy(scenario, self.options.keep)

    def stopped(self, scenario, out):
        """A flight in real time whose process is stopped on the way, so that it misses periods."""
        with subprocess.Popen([self.options.binary, "run", scenario, "-o", out, "--realtime"], stdout=subprocess.DEVNULL,
                              stderr=subprocess.PIPE, text=True) as flight:  # fmt: skip
            begun = time.monotonic()
            while not (out / "run.mcap").exists() and flight.poll() is None and time.monotonic() < begun + 30:
                time.sleep(0.02)
            for pause in (0.4, 1.0):
                time.sleep(0.3)
                if flight.poll() is None:
                    flight.send_signal(signal.SIGSTOP)
                    time.sleep(pause)
                    flight.send_signal(signal.SIGCONT)
            err = flight.communicate(timeout=longest)[1]
        return subprocess.CompletedProcess([], flight.returncode, "", err)

    def fly(self, seed, scenario):
        out = self.folder / "run"
        shutil.rmtree(out, ignore_errors=True)
        realtime = seed % 100 == 7
        run = self.stopped(scenario, out) if realtime else self.call("run", scenario, "-o", out)
        self.flown += 1
        self.codes[run.returncode] = self.codes.get(run.returncode, 0) + 1
        if run.returncode == 2 and re.match(r"^[^\n]*\.toml:\d+(:\d+)?: [^\n]+\n", run.stderr) and not (out / "run.mcap").exists():
            self.refused += 1
            if self.options.refusals:
                print(f"{scenario.name}: refused: {run.stderr.strip()}", flush=True)
            return
        if run.returncode not in (0, 1):
            self.verdicts += 1
            self.differ(scenario, "exit", f"exit {run.returncode}: {run.stderr.strip()[:300]}")
            return
        if run.returncode == 1 and not run.stderr.strip():
            self.verdicts += 1
            self.differ(scenario, "exit", "exit 1, and no sentence says why")
        self.hold(scenario, out, run, realtime)
        log = (out / "run.mcap").read_bytes()
        if seed % 5 == 1 or realtime:
            self.replay(scenario, out)
        for chosen, extra in ((seed % 10 == 3, []), (seed % 10 == 5, ["--threads", "2"])):
            if chosen:
                again = self.folder / "again"
                self.call("run", scenario, "-o", again, *extra)
                if (again / "run.mcap").read_bytes() != log:
                    self.bytes += 1
                    self.differ(scenario, "bytes", f"another log {' '.join(extra) or 'the second time'}")

    def hold(self, scenario, out, run, realtime):
        try:
            judge = Judge(scenario, out, run.returncode, realtime)
            differences = judge.judge()
        except Exception as error:  # pylint: disable=broad-except
            if self.options.trace:
                raise
            self.verdicts += 1
            self.differ(scenario, "judge", f"{type(error).__name__}: {error}")
            return
        said = run.stderr.strip()
        touched = judge.vehicles and " touched " in said
        self.commands += judge.wrong_commands
        for claim, sentence in differences:
            if claim == "exit" and touched:
                continue  # of a touch in the last period the log has no trace
            if claim not in ("command", "rate"):
                self.verdicts += 1
            self.differ(scenario, claim, sentence + (f" | {said[:200]}" if claim == "exit" and said else ""))

    def replay(self, scenario, out):
        again = self.call("replay", out)
        if again.returncode != 0 or not re.search(r"\b0 differ", again.stdout):
            self.replays += 1
            self.differ(scenario, "replay", (again.stdout + again.stderr).strip()[-300:])

    def run(self):
        for seed in range(self.options.first, self.options.first + self.options.count):
            subprocess.run([self.options.draw, self.folder, str(seed), "1"], check=True)
            scenario = self.folder / f"{seed}.toml"
            try:
                self.fly(seed, scenario)
            except subprocess.TimeoutExpired:
                self.verdicts += 1
                self.differ(scenario, "exit", f"did not end within {longest} s")
            scenario.unlink()
        print(f"exit codes {dict(sorted(self.codes.items()))}; differences by claim {dict(sorted(self.claims.items()))}")
        print(f"{self.flown} scenarios: {self.verdicts} verdict differences, {self.commands} commands not finite or beyond limits, "
              f"{self.replays} replays that differ, {self.bytes} byte differences")  # fmt: skip
        few = self.refused <= 1 + self.flown // 5
        if not few:
            print(f"{self.refused} scenarios were refused, expected at most a fifth")
        return 0 if few and self.verdicts + self.commands + self.replays + self.bytes == 0 else 1


def main():
    whole = os.environ.get("SIGHTLINE_CAMPAIGN") == "whole"
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draw", required=True, help="the program that draws scenarios")
    parser.add_argument("--binary", required=True, help="the command line")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=2000 if whole else 40)
    parser.add_argument("--keep", type=Path, help="keeps the scenarios that differ there")
    parser.add_argument("--refusals", action="store_true", help="prints why scenarios are refused")
    parser.add_argument("--trace", action="store_true", help="ends with the judge's own errors")
    with tempfile.TemporaryDirectory() as folder:
        return Campaign(parser.parse_args(), Path(folder)).run()


if __name__ == "__main__":
    sys.exit(main())
