#!/usr/bin/env bash
# The figures of campaigns in shards and of teams that plan apart, section by section:  scripts/accept/17.sh [--short] [SECTION ...]
# What is finished stays in out/accept/17/ and is not done again; delete it to begin anew. Needs the
# release preset with Cyclone DDS.
# --short is for CI: fewer runs and shorter flights, and the limits of a machine that others use too.
# DOMAIN=226 names another domain of DDS, RUNS=1000 flies fewer in `shards`.
set -uo pipefail
cd "$(dirname "$0")/../.." || exit 1
build=build/release
. scripts/accept/sections.sh
sightline=$build/bin/sightline
domain=${DOMAIN:-226}
fleet=fleets/chain8.toml
pairs='partition={a=["uav0","uav1"],b=["uav2","uav3"],c=["uav4","uav5"],d=["uav6","uav7"]}'
lossy=(--set 'partition.exchange.loss=0.2' --set 'partition.exchange.delay=0.03')

# $1: text; $2: condition of awk. Says both, and whether it holds.
holds() {
  local verdict=ok
  awk "BEGIN { exit !($2) }" || verdict=MISSED
  echo "$1: $verdict"
  [[ $verdict == ok ]]
}
# Processor time of all that has ended [s]: others may use the machine.
processor() {
  times >"$out/times"
  awk 'NR == 2 { gsub(/[ms]/, " "); print 60 * $1 + $2 + 60 * $3 + $4 }' "$out/times"
}
less() { awk "BEGIN { printf \"%.1f\", $1 - $2 }"; }
rows() { sqlite3 -csv "$1" 'SELECT * FROM runs ORDER BY "index"'; }  # of a campaign's file

# Of Slurm, that run; who has ended and is not waited for does not.
daemons() { ps -eo stat=,pid=,comm= | awk '$1 !~ /^Z/ && $3 ~ /slurm|munge/'; }

# The same runs in one process and as shards, one of them killed and resumed, one corrupted: one
# table, row by row.
shards() {
  local n=8 runs=10000 bad=0 i began one all daemons
  local scenario=scenarios/cooperative_localization.toml folder=$out/shards
  whole || { n=3 runs=60; }
  runs=${RUNS:-$runs}
  local -a flights=("$scenario" --runs "$runs" --seed 1)
  fly() { "$sightline" campaign "${flights[@]}" "$@" >>"$folder.log" 2>&1; }
  mkdir -p "$folder"; : >"$folder.log"
  processor >"$folder/began"; began=$(<"$folder/began")
  fly -o "$folder/one" --resume || fly -o "$folder/one" || bad=1
  processor >"$folder/ended"; one=$(less "$(<"$folder/ended")" "$began")
  began=$(<"$folder/ended")
  for ((i = 0; i < n; ++i)); do fly --shard $i/$n -o "$folder/$i" || bad=1; done
  processor >"$folder/ended"; all=$(less "$(<"$folder/ended")" "$began")
  "$sightline" campaign --merge "$folder"/[0-9] -o "$folder/merged" >>"$folder.log" 2>&1 || bad=1
  rows "$folder/one/campaign.sqlite" >"$folder/one.csv"; rows "$folder/merged/campaign.sqlite" >"$folder/merged.csv"
  cmp "$folder/one.csv" "$folder/merged.csv" && echo "$runs runs in one process and as $n shards: the same rows" || bad=1
  holds "shards took $all s of processor time, one process $one s, $(awk "BEGIN { printf \"%+.1f\", 100*($all/$one-1) }") %" \
    "$all <= 1.05 * $one || \"$form\" == \"short\"" || bad=1

  # By Slurm, on a cluster of one node.
  if command -v sbatch >/dev/null && ((EUID == 0)); then
    daemons=$(daemons | wc -l)
    scripts/slurm_local.sh "$sightline" campaign "${flights[@]}" --slurm --shards $n -o "$folder/slurm" >>"$folder.log" 2>&1 || bad=1
    rows "$folder/slurm/campaign.sqlite" >"$folder/slurm.csv"
    cmp "$folder/one.csv" "$folder/slurm.csv" && echo "as an array of $n jobs of Slurm: the same rows" || bad=1
    (($(daemons | wc -l) <= daemons)) || { daemons; echo 'daemons are left'; bad=1; }
  else
    echo 'not by Slurm: no sbatch here, or no root'
  fi

  # A shard that is killed in its middle and goes on.
  rm -rf "$folder/killed"
  if whole; then i=20; else i=0.3; fi
  timeout -s KILL $i "$sightline" campaign "${flights[@]}" --shard 1/$n -o "$folder/killed" >>"$folder.log" 2>&1
  echo "killed with $(sqlite3 "$folder/killed/campaign.sqlite" 'SELECT count(*) FROM runs' 2>/dev/null || echo 0) runs"
  fly --shard 1/$n -o "$folder/killed" --resume || fly --shard 1/$n -o "$folder/killed" || bad=1
  rows "$folder/killed/campaign.sqlite" >"$folder/killed.csv"; rows "$folder/1/campaign.sqlite" >"$folder/1.csv"
  cmp "$folder/killed.csv" "$folder/1.csv" && echo 'a shard that was killed and resumed: the same rows' || bad=1

  # One that is not what it was.
  rm -rf "$folder/bad"
  cp -r "$folder/1" "$folder/spoilt"
  printf 'spoilt' | dd of="$folder/spoilt/campaign.sqlite" bs=1 seek=5000 conv=notrunc 2>/dev/null
  if "$sightline" campaign --merge "$folder"/[02-9] "$folder/spoilt" -o "$folder/bad" 2>"$folder/refusal.txt"; then bad=1; fi
  cat "$folder/refusal.txt"
  grep -q spoilt "$folder/refusal.txt" || bad=1
  rm -rf "$folder/spoilt" "$folder/killed" "$folder/bad"
  return $bad
}

# $1: folder; then the fleet's own options. Simulated messages against one solver.
in_simulation() {
  local folder=$1
  "$sightline" run $fleet "${@:2}" -o "$folder" >"$folder.txt" 2>&1 || { cat "$folder.txt"; return 1; }
}
# $1: folder; $2: parts, as "front back"; then options. Flies each part in a process of its own,
# beside vehicles that stand in; writes their memory into $watched, where that is said.
in_processes() {
  local folder=$1 part vehicles code=0
  local -a flyers=()
  mkdir -p "$folder"
  "$sightline" vehicles $fleet --set "fleet.domain=$domain" >"$folder/vehicles.txt" 2>&1 </dev/null &
  vehicles=$!
  sleep 1
  for part in $2; do
    "$sightline" fly $fleet --set "fleet.domain=$domain" "${@:3}" --part "$part" -o "$folder/$part" >"$folder/$part.txt" 2>&1 &
    flyers+=($!)
  done
  [[ -z ${watched:-} ]] || watch_memory "$watched" "${flyers[@]}" &
  for part in "${flyers[@]}"; do wait "$part" || code=1; done
  kill -INT $vehicles; wait $vehicles
  ((code == 0)) || tail -n 5 "$folder"/*.txt
  return $code
}
# $1: folder; $2: parts. Their cost together; a coupling that robots of two parts feel is in both,
# and here it is nothing.
cost_of() {
  local part
  for part in $2; do jq .cost "$1/$part/summary.json"; done | awk '{ sum += $1 } END { print sum }'
}
# $1: from when [s]; then folders of logs. Their cost together from then on, as Python reads them.
cost_from() {
  PYTHONPATH=$build/python "$(sed -n 's/^Python_EXECUTABLE:[A-Z]*=//p' "$build/CMakeCache.txt")" -B - "$@" <<'PY'
import sys

import sightline

cost = 0.0
for folder in sys.argv[2:]:
    log = sightline.Log(folder)
    cost += log.period * sum(l for t, l in zip(log.time, log.cost) if t > float(sys.argv[1]) - 0.5 * log.period)
print(cost)
PY
}
# $1: folder; $2: parts. Of each, how often its updates ended how.
shares_of() {
  local part
  for part in $2; do jq -c .status "$1/$part/summary.json"; done
}
least_distance() { for part in $2; do jq .min_distance "$1/$part/summary.json"; done | sort -g | head -1; }

# The chain of eight in 2 and 4 processes against one solver, without loss and with 20 % of messages
# lost, 30 ms late. The cost of the exchange, against its cost in simulation. Vehicles turn and
# climb later than the model that a simulation flies: that is in both of the former. They are
# compared from 4 s on. Before, the cost goes with when in a period the first poses come. Three
# fifths of all are spent there, and flights of one solver differ by 2 % of all.
parts() {
  local bad=0 seconds=60 part_set parts folder cost simulated flown whole name most d agree=0.005 from=4 apart together
  whole || seconds=12 agree=0.03
  local -a duration=(--set "simulation.duration=$seconds") of_parts network
  "$sightline" run $fleet "${duration[@]}" --set 'partition.part="all"' -o "$out/central" >"$out/central.txt" 2>&1 || bad=1
  in_processes "$out/central-flown" all "${duration[@]}" || bad=1
  whole=$(jq .cost "$out/central/summary.json") flown=$(jq .cost "$out/central-flown/all/summary.json")
  for part_set in 2 4; do
    parts='front back' of_parts=()
    ((part_set == 2)) || { parts='a b c d'; of_parts=(--set "$pairs"); whole || continue; }
    for name in clear lossy; do
      network=() most=0.01
      [[ $name == clear ]] || { network=("${lossy[@]}"); most=0.03; }
      whole || most=0.03
      folder=$out/$part_set-$name
      in_simulation "$folder-simulated" "${duration[@]}" "${of_parts[@]}" "${network[@]}" || bad=1
      [[ $name == clear ]] || network+=(--set 'partition.exchange.flown_by="simulation"')
      in_processes "$folder" "$parts" "${duration[@]}" "${of_parts[@]}" "${network[@]}" || bad=1
      cost=$(cost_of "$folder" "$parts") simulated=$(jq .cost "$folder-simulated/summary.json")
      d=$(least_distance "$folder" "$parts")
      echo "$part_set processes, $name: cost $cost, one solver $flown; in simulation $simulated, one solver $whole"
      # The first seconds show where vehicles stood after their take-off, which no two flights
      # share.
      apart=$(cost_from $from $(printf "$folder/%s " $parts))/$(cost_from $from "$out/central-flown/all")
      together=$(cost_from $from "$folder-simulated")/$(cost_from $from "$out/central")
      holds "$part_set processes, $name, from $from s on: $(awk "BEGIN { printf \"%+.2f\", 100*($apart-1) }") %, in simulation $(awk "BEGIN { printf \"%+.2f\", 100*($together-1) }") %" \
        "$apart <= 1 + $most && ($apart-$together)^2 <= $agree^2" || bad=1
      holds "$part_set processes, $name: least distance $d m" "$d >= 0.6" || bad=1
      grep -h 'predictions,' "$folder"/[a-f]*.txt | sed 's/^sightline: //'
      shares_of "$folder" "$parts"; jq -c .status "$folder-simulated/summary.json"
    done
  done
  return $bad
}

# A process that is killed in flight: its robots' autopilots land them, the others keep distance and
# view. Started again it is in the exchange within 2 s. Its robots fly only after they have landed
# and somebody calls ~/start.
killed() {
  local folder=$out/killed bad=0 seconds=45 vehicles front back second=0 code=0
  whole || seconds=25
  rm -rf "$folder"; mkdir -p "$folder"
  local -a common=($fleet --set "fleet.domain=$domain" --set "simulation.duration=$seconds")
  "$sightline" vehicles $fleet --set "fleet.domain=$domain" >"$folder/vehicles.txt" 2>&1 </dev/null &
  vehicles=$!
  sleep 1
  "$sightline" fly "${common[@]}" --part front -o "$folder/front" >"$folder/front.txt" 2>&1 & front=$!
  "$sightline" fly "${common[@]}" --part back -o "$folder/back" >"$folder/back.txt" 2>&1 & back=$!
  sleep 20
  "$sightline" fly "${common[@]}" --part back -o "$folder/second" >"$folder/second.txt" 2>&1 || second=$?
  cat "$folder/second.txt"
  ((second == 2)) || bad=1
  kill -KILL $back; wait $back 2>/dev/null
  sleep 1
  "$sightline" fly "${common[@]}" --part back -o "$folder/again" >"$folder/again.txt" 2>&1 & back=$!
  sleep 2
  # By then the other has heard the new one.
  grep -c 'part back: its messages arrive, its robots do not fly' "$folder/front.txt" | grep -qx 2 || { echo 'not heard within 2 s'; bad=1; }
  wait $front || code=$?
  kill -INT $back; wait $back
  kill -INT $vehicles; wait $vehicles
  grep '^sightline: part back' "$folder/front.txt"
  grep 'flies already\|lets them' "$folder/again.txt"
  grep -q 'lets them take off' "$folder/again.txt" || bad=1
  grep -o 'uav[4-7]: .*failsafe.*\|uav[4-7]: [0-9]* set-points' "$folder/vehicles.txt"
  [[ $(grep -c failsafe "$folder/vehicles.txt") == 4 ]] || bad=1
  holds "the others: exit code $code, least distance $(jq .min_distance "$folder/front/summary.json") m" \
    "$code == 0 && $(jq .min_distance "$folder/front/summary.json") >= 0.6" || bad=1
  grep 'sees' "$folder/front.txt"
  return $bad
}

# $1: robots; $2: duration [s]; $3: robots of a part, which are neighbours. A chain.
chain_in_parts() {
  local n=$1 of=$3 i to
  cat <<TOML
solver = { name = "newton_riccati" }
shape = [ { chain = ["uav{0..$((n - 1))}"], felt_by = "observer", potentials = [
  { bearing = { alpha = 0.5, width = 0.1, tilt = 0.2 }, weight = 4.0 },
  { too_near = { d_min = 1.0, kappa = 10.0 }, weight = 4.0 },
  { too_far = { d_max = 2.0, kappa = 10.0 }, weight = 8.0 },
  { relative_velocity = { v_0 = 1.0 }, weight = 0.1 } ] } ]
[simulation]
duration = $2
settle = 4.0
[log]
prediction_period = 10.0
[partition]
TOML
  for ((i = 0; i < n; i += of)); do
    printf 'p%d = [' $((i / of))
    for ((to = i; to < i + of && to < n; ++to)); do printf '"uav%d",' $to; done
    echo ']'
  done
  for ((i = 0; i < n; ++i)); do
    cat <<TOML
[agent.uav$i]
robot = "multirotor"
start = { p = [$((-3 * i / 2)).$((5 * (i % 2))), 0.$((i % 3 * 2)), $((1 + 3 * i / 10)).$((3 * i % 10))], heading = 0.0 }
sensor = { pitch = 0.3, offset = 0.17 }
TOML
    if ((i == 0)); then
      echo 'Q = [1.5, 1.5, 1.6, 0, 0, 0, 0]
reference = { circle = { centre = [-1.5, 0.0, 1.0], radius = 1.5, rate = 0.2 } }'
    else
      echo 'R = [0.1, 0.1, 0.1, 0.1]'
    fi
  done
}

# $1: robots; $2: of a part; $3: duration [s]; then options. One solver flies the same beside.
chain_run() {
  local name=$out/chain$1-$2
  chain_in_parts "$1" "$3" "$2" >"$name.toml"
  "$sightline" run "$name.toml" "${@:4}" -o "$name" >"$name.txt" 2>&1 || { grep '^sightline' "$name.txt"; return 1; }
}

# Teams of 64, 256 and 1024 in parts of eight, and in smaller ones: what a part takes, and what it
# costs against one solver. The log is the same whatever the number of threads.
scale() {
  local n of seconds name bad=0 excess p99
  local -a teams=(64 256 1024) sizes=(8 4 2 1)
  whole || teams=(64) sizes=(8 1)
  for n in "${teams[@]}"; do
    seconds=$((n > 256 ? 4 : n > 64 ? 10 : 20))
    whole || seconds=3
    for of in "${sizes[@]}"; do
      ((n < 1024 || of == 8)) || continue
      name=$out/chain$n-$of
      chain_run "$n" "$of" $seconds || bad=1
      excess=$(jq .cost_excess "$name/partition.json") p99=$(jq .part_p99_us "$name/partition.json")
      holds "$n robots in parts of $of: the slowest part takes $(jq .part_us "$name/partition.json") us, of each 99 % within $p99 us" \
        "$p99 <= 500 || \"$form\" == \"short\"" || bad=1
      holds "$n robots in parts of $of: cost $(awk "BEGIN { printf \"%+.3f\", 100 * $excess }") % of that of one solver" \
        "$excess <= 0.01 || $of < 8 || $n > 256" || bad=1
    done
  done
  name=$out/chain64-8
  cp "$name/run.mcap" "$name.mcap"
  for n in 2 4; do
    chain_run 64 8 "$(whole && echo 20 || echo 3)" --threads $n || bad=1
    cmp "$name/run.mcap" "$name.mcap" && echo "$n threads: the same log" || bad=1
  done
  return $bad
}

# $1: file; then programs by their ids. Their memory [kB] each 15 s, a line each time, until the
# first has ended.
watch_memory() {
  local file=$1 id
  shift
  while kill -0 "$1" 2>/dev/null; do
    for id in "$@"; do awk '/^VmRSS/ { printf "%d ", $2 }' "/proc/$id/status" 2>/dev/null; done
    echo
    sleep 15
  done >"$file"
}

# Ten minutes of eight programs, a robot each, at 100 Hz: messages, loss, processor time and memory.
soak() {
  local folder=$out/soak bad=0 seconds=600 parts='p0 p1 p2 p3 p4 p5 p6 p7'
  whole || seconds=10
  rm -rf "$folder"
  local each='partition={p0=["uav0"],p1=["uav1"],p2=["uav2"],p3=["uav3"],p4=["uav4"],p5=["uav5"],p6=["uav6"],p7=["uav7"]}'
  watched=$folder/memory.txt in_processes "$folder" "$parts" --set "simulation.duration=$seconds" --set "$each" || bad=1
  grep -h 'predictions' "$folder"/p?.txt | awk -v seconds="$seconds" '
    / sent$/ { sent += $(NF - 2) }
    / lost, / { for (i = 1; i < NF; ++i) { if ($(i + 1) == "predictions,") came += $i; if ($(i + 1) == "lost,") lost += $i } }
    END { printf "%d predictions sent, %d received, %.0f a second in the air, %.4f %% lost\n", sent, came, came / seconds, 100 * lost / (came + lost)
          exit !(lost <= 0.001 * (came + lost)) }' || { ((seconds < 600)) || bad=1; }
  for part in $parts; do jq -r '[.real_time.cpu, .real_time.missed, .real_time.periods, .allocations_per_update] | @tsv' "$folder/$part/summary.json"; done |
    awk '{ cpu += $1; missed += $2; periods += $3; if ($4 > allocations) allocations = $4 }
         END { printf "processor: %.1f %% of a core for each program, %d of %d periods missed, %d allocations in an update\n", 100 * cpu / NR, missed, periods, allocations; exit allocations != 0 }' || bad=1
  # While they fly, from the first minute on: when a flight ends its report is drawn.
  awk -v last=$((seconds / 15)) 'NF == 8 && ++n <= last { for (i = 1; i <= 8; ++i) { if (n == 4) from[i] = $i; to[i] = $i } }
       END { for (i in from) if (to[i] - from[i] > grew) grew = to[i] - from[i]
             printf "memory: %.1f MB at most, grows by at most %.2f MB after the first minute\n", to[1] / 1024, grew / 1024; exit n > 8 && grew > 2048 }' "$folder/memory.txt" || bad=1
  holds "least distance $(least_distance "$folder" "$parts") m" "$(least_distance "$folder" "$parts") >= 0.6" || bad=1
  return $bad
}

all=(shards parts killed scale soak)
run_sections "$@"
