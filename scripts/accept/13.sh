#!/usr/bin/env bash
# The figures of flights over DDS, section by section:  scripts/accept/13.sh [--short] [SECTION ...]
# What is finished stays in out/accept/13/ and is not done again; delete it to begin anew. A killed
# run goes on where it was. Needs the release preset with Cyclone DDS. `timing` judges this machine:
# run it where nothing else does.
# --short is for CI: fewer vehicles, shorter flights, and times that are shown and not judged.
# DOMAIN=228 names another domain of DDS.
set -uo pipefail
cd "$(dirname "$0")/../.." || exit 1
build=build/release
. scripts/accept/sections.sh
. scripts/accept/rotors.sh
domain=${DOMAIN:-227}

# $1: vehicles; $2: duration [s]. PX4 vehicles of all releases in rows of four, 3 m apart, on
# circles of 0.3 m. Each keeps 1 m from the one before it.
fleet() {
  local i x y
  cat <<TOML
[fleet]
domain = $domain
discovery = { participants = 40 }
[solver]
name = "newton_riccati"
[safety]
barrier = "on"
d_hard = 0.6
floor = 0.2
position_sigma = 0.01
heading_sigma = 0.01
[safety.supervisor]
fresh = 0.05
[simulation]
duration = $2
TOML
  for ((i = 0; i < $1; ++i)); do
    x=$((3 * (i % 4))) y=$((3 * (i / 4)))
    cat <<TOML
[agent.uav$i]
robot = "multirotor"
start = { p = [$x.0, $y.0, 0.8], heading = 0.0 }
Q = [1.5, 1.5, 1.6, 0, 0, 0, 0]
reference = { circle = { centre = [$x.0, $y.0, 1.0], radius = 0.3, rate = 0.5 } }
[agent.uav$i.link]
kind = "px4"
release = "1.$((14 + i % 5))"
namespace = "/px4_$((i + 1))"
target_system = $((i + 2))
origin = { p = [$x.0, $y.0, 0.0], heading = 0.0 }
TOML
    ((i == 0)) || cat <<TOML
[[couple]]
potential = { too_near = { d_min = 1.0, kappa = 10.0 } }
between = ["uav$i", "uav$((i - 1))"]
felt_by = ["uav$i"]
weight = 4.0
TOML
  done
}

# Flies a fleet that is stood in for. $1: folder, with fleet.toml. Leaves fly.txt, vehicles.txt and
# `flown`, and in flight the flyer's number in `pid`. The exit code is that of `fly`.
fly_fleet() {
  local folder=$1 vehicles flyer code=0
  "$sightline" vehicles "$folder/fleet.toml" >"$folder/vehicles.txt" 2>"$folder/vehicles.err" </dev/null &
  vehicles=$!
  "$sightline" fly "$folder/fleet.toml" -o "$folder/flown" >"$folder/fly.txt" 2>&1 &
  flyer=$!
  echo "$flyer" >"$folder/pid"
  wait "$flyer" || code=$?
  kill -INT "$vehicles"
  wait "$vehicles"
  return $code
}
figure() { jq -r "$2" "$1/flown/summary.json"; }  # $1: folder; $2: of its summary

# 2, 8 and 16 vehicles for 180 s: periods, wake-ups, latencies, CPU and allocations of the flyer.
timing() {
  local n folder shown fifo late apart bad=0 seconds=180
  local -a fleets=(2 8 16)
  whole || fleets=(2) seconds=6
  for n in "${fleets[@]}"; do
    folder=$out/timing/$n
    if [[ ! -s $folder/done ]]; then
      rm -rf "$folder" && mkdir -p "$folder"
      fleet "$n" "$seconds" >"$folder/fleet.toml"
      fly_fleet "$folder" || { tail -n 5 "$folder/fly.txt"; return 1; }
      echo 1 >"$folder/done"
    fi
    grep -m 1 'real time' "$folder/fly.txt"
    # Times are judged in the whole form, on a machine that does nothing else; beside other work
    # they are those of the others.
    shown='' fifo='' late=0.2 apart=$((n > 2 ? 12 : 10))
    whole || shown=wanted
    { whole && grep -q 'real time: SCHED_FIFO' "$folder/fly.txt"; } || fifo=wanted late=2 apart=15
    judge "$n vehicles: missed periods" "$(figure "$folder" '100 * .real_time.missed / .real_time.periods')" "<= $late" % $shown || bad=1
    judge "$n vehicles: wake-up p99" "$(figure "$folder" '.real_time.wake_us.p99 / 1000')" '<= 0.5' ms $fifo || bad=1
    judge "$n vehicles: poses later than the fastest p99" "$(figure "$folder" '.real_time.arrival_us.p99 / 1000')" '<= 1' ms $fifo || bad=1
    judge "$n vehicles: stamp to received command, p99 less median" "$(sed -n \
      's/.* answers \([0-9.]*\) ms after the pose at the median, \([0-9.]*\) at 99 %.*/\1 \2/p' "$folder/vehicles.txt" |
      awk '{ d = $2 - $1; if (d > w) w = d } END { print w }')" "<= $apart" ms $shown || bad=1
    echo "$n vehicles: stamp to received command $(sed -n 's/.* answers \([0-9.]* ms\).*, \([0-9.]*\) at 99 %.*/\1 (p99 \2)/p' "$folder/vehicles.txt" | head -n 1)"
    judge "$n vehicles: CPU" "$(figure "$folder" '100 * .real_time.cpu')" '<= 10' '% of one core' $fifo || bad=1
    judge "$n vehicles: allocations in an update" "$(figure "$folder" .allocations_per_update)" '== 0' '' || bad=1
    judge "$n vehicles: set-points outside offboard" "$(grep -o '[0-9]* outside offboard' "$folder/vehicles.txt" | awk '{ n += $1 } END { print n }')" '== 0' '' || bad=1
  done
  return $bad
}

# Flights of all kinds, missed periods, losses, restarts and pilots included, are replayed: 0
# commands differ.
replay() {
  local case kind folder bad=0
  local -a cases=(good losses pilot restart stopped)
  whole || cases=(losses stopped)
  for case in "${cases[@]}"; do
    folder=$out/replay/$case
    rm -rf "$folder" && mkdir -p "$folder"
    fleet 2 "$(whole && echo 30 || echo 6)" >"$folder/fleet.toml"
    case $case in
      losses) for kind in drop delay reorder duplicate not_finite; do fault "$kind" 2.0; done ;;
      pilot | restart) fault "$case" 3.0 ;;
    esac >>"$folder/fleet.toml"
    if [[ $case == stopped ]]; then
      { sleep 7; kill -STOP "$(<"$folder/pid")"; sleep 0.15; kill -CONT "$(<"$folder/pid")"; } &
    fi
    fly_fleet "$folder" >/dev/null
    echo "$case: $(figure "$folder" '"\(.real_time.periods) periods, \(.real_time.missed) missed"')"
    "$sightline" replay "$folder/flown" | grep ', 0 differ' || { echo "$case: commands differ"; bad=1; }
  done
  return $bad
}
fault() { printf '[[fleet.fault]]\nrobot = "uav0"\nkind = "%s"\nsince = "flight"\nat = %s\n' "$@"; }

# Each release of PX4 flies with its own vehicle, and each wrong pair is refused.
releases() { tests dds_test 'DdsWorld.AFleetOfAllReleases*:DdsWorld.EachWrongPair*'; }

# What becomes of a flight when something fails.
faults() {
  if whole; then
    tests dds_test 'DdsWorld.*:Faults.*:VehicleSimulator.*' && tests dds_campaign_test 'FaultMatrix.*:DdsFlights.*:FlyInterrupted.*:Fly.*'
  else
    tests dds_campaign_test 'FaultMatrix.ALowBattery*:FaultMatrix.AJumpThatTheEstimator*'
  fi
}

# Mutated payloads of every type, forged packets.
payloads() { tests dds_test 'Garbled.*'; }
packets() { tests dds_campaign_test 'Forged.*:Flood.*'; }

# Random flights with events, tuning and faults: 250 blocks of eight.
event_block() { SIGHTLINE_CAMPAIGN=whole "$build/tests/dds_campaign_test" --gtest_filter="Blocks/ChangingFleetCampaign.*/$1"; }
events() {
  whole || { echo "whole only: the tests fly four"; return 0; }
  blocks 0 1 249 event_block
  local -a bad
  mapfile -t bad < <(grep -L 'PASSED  \] 1 test' "$out"/random/*.txt)
  echo "250 blocks of 8 flights: ${#bad[@]} with a broken promise"
  failed_blocks '^flight ' "${bad[@]}"
}

# The shipped fleet from the ground to the ground, 60 s, and its replay.
demo() {
  whole || { echo "whole only: a document flies it for 8 s"; return 0; }
  scripts/fly_demo.sh 2>&1 | tail -n 4 | grep ', 0 differ'
}

all=(timing replay releases faults payloads packets events demo)
run_sections "$@"
