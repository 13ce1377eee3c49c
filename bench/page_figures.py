"""Figures of the page of a flight, one section a call:  page_figures.py frames|growing SIGHTLINE [--short]

A browser (tests/npm/browser.mjs) looks at what SIGHTLINE, the program, serves. Prints what was measured, and ends with 1 where that is
beyond its limit; --short measures less, by wider limits. CHROMIUM names the browser.
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

tree = Path(__file__).resolve().parents[1]
program = sys.argv[2]
short = "--short" in sys.argv
wide = 0.05 if short else 1.0  # on a machine that does other things too


class Viewed:
    """`sightline view` of something, and its address."""

    def __init__(self, *words):
        self.process = subprocess.Popen([program, "view", *map(str, words), "--port", "0"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.url = self.process.stdout.readline().strip()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait()


class Browser:
    """A browser at an address, driven step by step."""

    def __init__(self, url):
        self.process = subprocess.Popen(["node", tree / "tests/npm/browser.mjs", url], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def __call__(self, step):
        print(step, file=self.process.stdin, flush=True)
        return json.loads(self.process.stdout.readline() or '{"faults": ["the browser ended"]}')

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.communicate("quit\n")


def flown(folder, scenario, seconds):
    subprocess.run([program, "run", tree / "scenarios" / scenario, "-o", folder, "--set", f"simulation.duration={seconds}"],
                   check=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def pictures(look, least, what):
    cpu = sum(look["cpu_ms"].values())
    print(f"{what}: {look['fps']:.1f} pictures a second, at least {least:g}; {cpu:.0f} ms of the processor for one, with {look['pixels']:.2f} of the pixels along each side; page of {look['weight'] / 1000:.0f} kB")
    return look["fps"] >= least * wide and not look["faults"]


def frames():
    """Pictures a second of a finished log, and of a flight in real time, at 1280 x 720."""
    seconds, ok = (4 if short else 20), True
    with tempfile.TemporaryDirectory() as folder:
        for name in ("localize", "pyramid_camera", "cooperative_localization"):
            flown(f"{folder}/{name}", f"{name}.toml", 2 * seconds + 5)
            with Viewed(f"{folder}/{name}") as view, Browser(view.url) as browser:
                browser("wait finished")
                browser("pause 1")
                ok &= pictures(browser(f"look {seconds}"), 30, f"log of {name}")
    with Viewed(tree / "scenarios/cooperative_localization.toml") as view, Browser(view.url) as browser:
        browser("wait live")
        browser("moments 30")
        ok &= pictures(browser(f"look {seconds}"), 15, "cooperative_localization in real time")
    return ok


def growing():
    """A log that is still written is shown as it grows, and as it ended when its run is killed."""
    with tempfile.TemporaryDirectory() as folder:
        run = subprocess.Popen([program, "run", tree / "scenarios/cooperative_localization.toml", "-o", folder, "--realtime"],
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        while not os.path.exists(f"{folder}/run.mcap"):
            time.sleep(0.1)
        time.sleep(1)
        with Viewed(folder) as view, Browser(view.url) as browser:
            browser("wait growing")
            browser("newest")
            behind = []
            for _ in range(3 if short else 20):
                before = browser("look 1")
                after = browser("look 1")
                behind.append(after["t"] - before["t"])
            grows = sum(behind) / len(behind)
            run.send_signal(signal.SIGKILL)
            run.wait()
            ended = browser("wait broken")
            last = browser("look 1")
    print(f"a log of a flight in real time: {grows:.2f} s shown between two looks; {last['moments']} moments, then: {last.get('link')}")
    return grows > 0.5 and ended.get("link") == "broken" and not last["faults"]


section = {"frames": frames, "growing": growing}[sys.argv[1]]
sys.exit(0 if section() else 1)
