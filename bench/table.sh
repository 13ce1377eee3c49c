#!/usr/bin/env bash
# Runs all of `sightline bench` and writes bench/README.md and bench/scaling.svg:  bench/table.sh [PROTOTYPE]
# PROTOTYPE is the folder of the hand-made prototype's sources. Where it is there, it is built and
# timed before and after; ours is compared with the lower of its medians. All on one core (CORE,
# else 1).
set -euo pipefail
cd "$(dirname "$0")/.." || exit 1
prototype=$(realpath -m "${1:-../shared/reference/solver_generic}")
core=${CORE:-1}
. bench/fit.sh
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

[[ -x build/release/bin/sightline ]] || {
  echo "table.sh: build/release/bin/sightline is not there, expected the release preset built" >&2
  exit 2
}
time_prototype() {
  [[ -x $work/prototype/b_team_bt ]] || return 0
  echo "prototype" >&2
  taskset -c "$core" "$work/prototype/b_team_bt" | grep '^team ' >>"$work/prototype.txt"
}
if [[ -d $prototype ]]; then
  cp -rp "$prototype" "$work/prototype"
  chmod -R u+w "$work/prototype"
  make -s -C "$work/prototype" b_team_bt >&2
fi

load=$(cut -d' ' -f1 /proc/loadavg)
time_prototype
taskset -c "$core" build/release/bin/sightline bench >"$work/table.md"
for seconds in 0 0.001; do
  taskset -c "$core" build/release/bin/sightline bench --paced --warm-up $seconds >"$work/paced_$seconds.md"
done
time_prototype

# A case's median [us], ours and IPOPT's; a line's lower median, the prototype's.
median() { awk -F'|' -v name=" $1 " '$2 == name { print $5 + 0 }' "$work/table.md"; }
p99() { awk -F'|' -v name=" $1 " '$2 == name { print $6 + 0 }' "$work/table.md"; }
ipopt() { awk -F'|' -v name=" $1 " '$2 == name { print $13 + 0 }' "$work/table.md"; }
prototype_median() { sed -nE "s/^$1: med +([0-9.]+) .*/\1/p" "$work/prototype.txt" | sort -g | head -n 1; }

for robots in 2 4 8 16 32 64; do
  echo "$robots $(median chain_$robots) $(median chain_${robots}_masked) $(ipopt chain_$robots)"
done >"$work/scaling.txt"
# Column 2: all feel, 3: masked, 4: IPOPT.
fit() { power_law "$work/scaling.txt" "$1" "$2" 64; }
read -r joint joint_at_1 <<<"$(fit 2 2)"
read -r joint_from_8 _ <<<"$(fit 2 8)"
read -r masked masked_at_1 <<<"$(fit 3 2)"
read -r masked_from_8 _ <<<"$(fit 3 8)"
read -r peer peer_at_1 <<<"$(fit 4 2)"

/usr/bin/python3 bench/loglog.py bench/scaling.svg "Time of one update over the number of robots in a chain" \
  "|#777777|o|$work/scaling.txt|4" "|#d95f02|o|$work/scaling.txt|2" "|#1b6ca8|o|$work/scaling.txt|3" \
  "IPOPT, to the optimum: robots^$peer|#bbbbbb|-|$peer_at_1 $peer" \
  "newton_riccati, all feel the couplings: robots^$joint|#d95f02|-|$joint_at_1 $joint" \
  "newton_riccati, the watching robot alone: robots^$masked|#1b6ca8|--|$masked_at_1 $masked"

ratio() { awk -v a="$1" -v b="$2" 'BEGIN { printf "%.2f", a / b }'; }
{
  cat <<'TEXT'
# Benchmarks

Made by `bench/table.sh`, in one run on one core; do not edit.

Every case is 60 s of closed loop: 6000 updates at 100 Hz, horizon 1 s in 20 stages. Between two updates only the plant
runs. Times are wall-clock times. They include the cold start of the first update, and, in p99 and the maximum, what
other programs took of the core. *Error* is the infinity norm of
u - u*, where u* is the optimum at the same state, converged to 1e-10; *before* are all updates up to 2 s except the
first. IPOPT (3.11, MUMPS) solves every 50th problem as sparse multiple shooting with exact derivatives, started at the
optimum of the update before, to a tolerance of 1e-13; where the team is masked, robot by robot. Its time is processor time, its error that of
whole horizons against u*. Robots of one model are computed in SIMD lanes: two or four where a team has so few robots of each model, else all lanes of the processor (eight with AVX-512).

TEXT
  printf 'Load of the machine at the start: %s (0: idle).\n\n' "$load"
  cat "$work/table.md"
  printf '\nWith interpreted instead of compiled programs, a chain of 8 takes %s times as long.\n' \
    "$(ratio "$(median chain_8_interpreted)" "$(median chain_8)")"
  if [[ -s $work/prototype.txt ]]; then
    cat <<'TEXT'

## Compared with the prototype

The prototype is written by hand for these teams: one kind of coupling with hand-derived derivatives. It was timed
before and after the table, with the processor's clock of its thread (reading it takes about 0.2 us of each of its medians); the lower
median counts.

| case | median us | prototype us | ratio | p99 / median |
|---|---|---|---|---|
TEXT
    while IFS=';' read -r name line; do
      theirs=$(prototype_median "$line")
      printf '| %s | %s | %s | %s | %s |\n' "$name" "$(median "$name")" "$theirs" "$(ratio "$(median "$name")" "$theirs")" \
        "$(ratio "$(p99 "$name")" "$(median "$name")")"
    done <<'CASES'
pair;team W2 M  2 JOINT k4 stop 1e-03
pair_masked;team W2 M  2 MASK k1 stop [^:]*
chain_64;team W8 M 64 JOINT k2 stop [^:]*
chain_64_masked;team W8 M 64 MASK k2 stop [^:]*
CASES
  fi
  cat <<'TEXT'

## In a flight at 100 Hz

As `run --realtime` has them, updates begin each 10 ms, and others use the caches between. *Cold*: as they come; else
the solver fills the caches just before, `[loop] warm_up`.

| case | back to back p50 us | cold p50 us | cold p99 us | p50 us | p99 us | p99.9 us |
|---|---|---|---|---|---|---|
TEXT
  paced() { awk -F'|' -v name=" $2 " -v column="$3" '$2 == name { print $column + 0 }' "$work/paced_$1.md"; }
  for name in pair chain_64 cascade_64; do
    printf '| %s | %s | %s | %s | %s | %s | %s |\n' "$name" "$(median "$name")" "$(paced 0 "$name" 5)" "$(paced 0 "$name" 6)" \
      "$(paced 0.001 "$name" 5)" "$(paced 0.001 "$name" 6)" "$(paced 0.001 "$name" 7)"
  done
  cat <<TEXT

## Over the number of robots

![Median time of an update over the number of robots, both axes logarithmic](scaling.svg)

Time grows with the power $joint of the number of robots from 2 to 64, where all feel the couplings ($joint_from_8 from 8 to
64); with the power $masked where only the observer does ($masked_from_8 from 8 to 64). Teams of other kinds, of up to 1024 robots: [families.md](families.md).
TEXT
} >bench/README.md
echo "table.sh: wrote bench/README.md and bench/scaling.svg" >&2
