#!/usr/bin/env bash
# Times teams of six kinds, of 8 to 1024 robots, and writes bench/families.md and bench/families.svg:  bench/families.sh
# All on one core (CORE, else 1), with the release preset; some 9 minutes.
set -euo pipefail
cd "$(dirname "$0")/.." || exit 1
core=${CORE:-1}
sightline=build/release/bin/sightline
. bench/fit.sh
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
[[ -x $sightline ]] || { echo "families.sh: $sightline is not there, expected the release preset built" >&2; exit 2; }

load=$(cut -d' ' -f1 /proc/loadavg)
families='chain cascade strong_chain mutual_chain grid'
number() { sed -nE "s/.*\"$1\": ([-0-9.e+]+),?/\1/p" "$work/case.json" | head -n 1; }
# Of each size: robots, median, p99, first update [us], error after 2 s.
for family in $families; do
  for robots in 8 16 32 64 128 256 512 1024; do
    echo "${family}_$robots" >&2
    taskset -c "$core" "$sightline" bench --case "${family}_$robots" --updates 1000 --json 2>/dev/null >"$work/case.json"
    echo "$robots $(number median_us) $(number p99_us) $(number first_us) $(number input_error_max)" >>"$work/$family.txt"
  done
done
# Of swarms the worst second.
for robots in 8 16 32 64 128 256 512 1024; do
  echo "swarm_$robots" >&2
  taskset -c "$core" "$sightline" bench --case "swarm_$robots" 2>/dev/null |
    awk -F'|' -v n="$robots" '$2 == " swarm_" n "_crossing " { print n, $5 + 0, $6 + 0 }' >>"$work/swarm.txt"
done

/usr/bin/python3 bench/loglog.py bench/families.svg "Time of one update over the number of robots" \
  "swarm, its worst second|#7a3b9a|o-|$work/swarm.txt|2" "mutual_chain|#b3002d|o-|$work/mutual_chain.txt|2" \
  "strong_chain (B)|#d95f02|o-|$work/strong_chain.txt|2" "cascade|#c9a400|o-|$work/cascade.txt|2" \
  "grid|#2f7d32|o-|$work/grid.txt|2" "chain (A)|#1b6ca8|o-|$work/chain.txt|2"

exponent() { power_law "$work/$1.txt" 2 "$2" "$3" | cut -d' ' -f1; }
{
  cat <<'TEXT'
# Teams of many kinds and sizes

Made by `bench/families.sh`, in one run on one core; do not edit. How a case is flown and judged: [README.md](README.md).

| family | robots and couplings |
|---|---|
| `chain` (A) | each watches the next; weak couplings (0.4) that both feel |
| `cascade` | in the words of `scenarios/chain8.toml`: the first flies a circle, each other watches the one before it and alone feels that |
| `strong_chain` (B) | the same, and robots two apart keep their distance, which both feel but the first |
| `mutual_chain` | B, all of it felt by both |
| `grid` | four robots a row, each on a circle of its own, apart from those beside it; felt by both |
| `swarm` | `keep_apart` among all, which swap places across a circle; the second of the flight whose median is worst |

TEXT
  printf 'Load of the machine at the start: %s (0: idle).\n\n' "$load"
  taskset -c "$core" "$sightline" bench --case pair --updates 100 --times 2>/dev/null | head -n 1
  cat <<'TEXT'

![Median time of an update of each family, both axes logarithmic](families.svg)

10 s of closed loop (1000 updates); of swarms at least 6000 updates, in crossings of 60 s, of 26 s up to 32 robots. *First* is the cold start; *error* that of inputs from 2 s on, beyond
64 robots at every 50th update. The robots of all chains but A begin at their limits for a second, which is most of their p99.

| case | median us | p99 us | first ms | error |
|---|---|---|---|---|
TEXT
  for family in $families; do
    awk -v f="$family" '{ printf "| %s_%s | %.1f | %.1f | %.2f | %.1e |\n", f, $1, $2, $3, $4 / 1000, $5 }' "$work/$family.txt"
  done
  awk '{ printf "| swarm_%s | %.1f | %.1f | - | - |\n", $1, $2, $3 }' "$work/swarm.txt"
  printf '\n| family | exponent 8 to 512 | 64 to 1024 |\n|---|---|---|\n'
  for family in $families; do
    echo "| $family | $(exponent "$family" 8 512) | $(exponent "$family" 64 1024) |"
  done
} >bench/families.md
echo "families.sh: wrote bench/families.md and bench/families.svg" >&2
