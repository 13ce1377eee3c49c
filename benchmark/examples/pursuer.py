#!/usr/bin/env python3
"""A controller outside: benchmark/run.py --controllers process --process 'python3 benchmark/examples/pursuer.py' -o DIR"""

import json
import math
import sys

task = json.loads(sys.stdin.readline())


def steer(x, target, of):
    """Inputs of (24) for a robot with state x = (p, d, v): turn to the target, keep the distance, stay above."""
    ahead = [target[0] - x[0], target[1] - x[1]]
    forward, left = x[3] * ahead[0] + x[4] * ahead[1], x[3] * ahead[1] - x[4] * ahead[0]
    bearing, distance = math.atan2(left, forward), math.hypot(*ahead)
    wanted = 0.5 * (of["d_min"] + of["d_max"])
    above = math.tan(of["pitch"]) * (wanted - of["offset"])
    speed = 0.8 * (distance - wanted)
    return [1.5 * (speed * math.cos(bearing) - x[5]), -1.5 * (speed * math.sin(bearing) - x[6]),
            1.0 * (target[2] + above - x[2]), 1.5 * bearing]


for line in sys.stdin:
    time, *states = map(float, line.split())
    inputs = []
    for of in task["observers"]:
        inputs += steer(states[of["state"]:], states[of["target_state"]:], of)
    print(*(max(-1.0, min(1.0, u)) for u in inputs), flush=True)
