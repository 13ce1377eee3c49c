#!/usr/bin/env bash
# Flies two PX4 vehicles that are stood in for, on this machine alone:  scripts/fly_demo.sh [FLEET.toml]
# Needs cyclonedds-dev and cyclonedds-tools (scripts/deps.sh test).
set -euo pipefail
cd "$(dirname "$0")/.."

fleet=${1:-fleets/desk.toml}
out=out/$(basename "$fleet" .toml)
if [[ ! -x build/release/bin/sightline ]]; then
  cmake --preset release -DSIGHTLINE_TESTS=OFF -DSIGHTLINE_BENCH=OFF >&2
  cmake --build --preset release --target sightline_cli >&2
fi

build/release/bin/sightline vehicles "$fleet" &
vehicles=$!
trap 'kill -INT "$vehicles" 2>/dev/null || true; wait "$vehicles" || true' EXIT

code=0
build/release/bin/sightline fly "$fleet" -o "$out" || code=$?
if ((code == 0)); then
  build/release/bin/sightline replay "$out" || code=$?
fi
exit "$code"
