#!/usr/bin/env bash
# The figures of large teams, section by section:  scripts/accept/16.sh [--short] [SECTION ...]
# What is finished stays in out/accept/16/ and is not done again; delete it to begin anew. Needs the
# release preset. One pinned core (CORE, else 1).
# --short is for CI: few robots and few updates, no limits of time.
set -uo pipefail
cd "$(dirname "$0")/../.." || exit 1
build=build/release
. scripts/accept/sections.sh
. bench/fit.sh
sightline=$build/bin/sightline
core=${CORE:-1}

# $1: file of JSON; $2: key of its first case.
number() { sed -nE "s/.*\"$2\": ([-0-9.e+]+),?/\1/p" "$1" | head -n 1; }
# $1: case; the rest: options. Prints the file of its JSON.
flown() {
  local file
  file=$out/$(tr -c 'a-z0-9_\n' _ <<<"$*").json
  [[ -s $file ]] || { taskset -c "$core" "$sightline" bench --case "$@" --json >"$file.part" 2>"$file.log" && mv "$file.part" "$file"; } || return 1
  echo "$file"
}
# $1: what; $2: had; $3: at most. A row, and in the whole form whether it holds.
row_at_most() {
  local verdict=ok
  awk "BEGIN { exit !(\"$2\" != \"\" && $2 + 0 <= $3) }" || verdict=missed
  printf '| %s | %s | %s | %s |\n' "$1" "$2" "$3" "$verdict"
  [[ $verdict == ok ]] || ! whole
}
# $1: file of "robots time"; $2, $3: from, to. The exponent of time over robots.
exponent() { power_law "$1" 2 "$2" "$3" | cut -d' ' -f1; }

# Medians, 99th percentiles, cold starts and errors of each family, and how they grow.
times() {
  local bad=0 family n file sizes='8 16 32 64 128 256 512 1024'
  local -a short=()
  whole || { sizes='8 16'; short=(--updates 200 --times); }
  for family in chain cascade strong_chain mutual_chain grid; do
    : >"$out/$family.txt"
    for n in $sizes; do
      file=$(flown ${family}_$n "${short[@]}") || { echo "${family}_$n: failed"; return 1; }
      echo "$n $(number "$file" median_us) $(number "$file" p99_us) $(number "$file" first_us) $(number "$file" input_error_max) $(number "$file" allocations)" >>"$out/$family.txt"
    done
    awk -v f=$family '{ printf "%s_%s: median %s us, p99 %s us, first %s us, error after 2 s %s, allocations %s\n", f, $1, $2, $3, $4, $5, $6; bad += $6 } END { exit bad > 0 }' \
      "$out/$family.txt" || bad=1
  done
  whole || return $bad
  had() { awk -v n="$2" -v column="$3" '$1 == n { print $column }' "$out/$1.txt"; }
  printf '\n| what | had | at most | |\n|---|---|---|---|\n'
  row_at_most 'cascade_64, median us' "$(had cascade 64 2)" 110 || bad=1
  row_at_most 'cascade_64, p99 us' "$(had cascade 64 3)" 250 || bad=1
  row_at_most 'cascade_64, error after 2 s' "$(had cascade 64 5)" 1e-5 || bad=1
  row_at_most 'strong_chain_64, median us' "$(had strong_chain 64 2)" 250 || bad=1
  row_at_most 'strong_chain_64, p99 us' "$(had strong_chain 64 3)" 700 || bad=1
  row_at_most 'strong_chain_64, first update us' "$(had strong_chain 64 4)" 5000 || bad=1
  row_at_most 'strong_chain_1024, median us' "$(had strong_chain 1024 2)" 6000 || bad=1
  row_at_most 'strong_chain_1024, p99 us' "$(had strong_chain 1024 3)" 9500 || bad=1
  row_at_most 'strong_chain_1024, first update us' "$(had strong_chain 1024 4)" 300000 || bad=1
  row_at_most 'mutual_chain_64, median us' "$(had mutual_chain 64 2)" 150 || bad=1
  row_at_most 'mutual_chain_64, p99 us' "$(had mutual_chain 64 3)" 400 || bad=1
  row_at_most 'chain_1024, median us' "$(had chain 1024 2)" 1600 || bad=1
  for family in chain cascade strong_chain mutual_chain grid; do
    row_at_most "$family, exponent 8 to 512" "$(exponent "$out/$family.txt" 8 512)" 1.1 || bad=1
    row_at_most "$family, exponent 64 to 1024" "$(exponent "$out/$family.txt" 64 1024)" 1.2 || bad=1
  done
  return $bad
}

# Eigenvalues of P^-1 C on recorded problems, and what each way to the team's step takes. In the
# words of B a pass in order is the step, though GMRES needs many; felt by both, whole bands of
# modes are strong. Once settled, an update needs two at most.
spectra() {
  local -a cases=(chain_16 cascade_16 strong_chain_16 mutual_chain_8 mutual_chain_16)
  whole || cases=(strong_chain_8 mutual_chain_8)
  taskset -c "$core" "$build/bin/bench_spectra" "${cases[@]}" | tee "$out/spectra.md"
  ((PIPESTATUS[0] == 0)) || return 1
  awk -F' [|] ' '/chain_|cascade_/ { n++; sub(/ .*/, "", $18)
      bad += ($1 ~ /strong|cascade/ && ($4 > 0.1 || $16 != "1 / 1")) + ($1 ~ /mutual/ && $6 < 5) + ($2 > 1 && $18 > 2) }
    END { exit n == 0 || bad > 0 }' "$out/spectra.md"
}

# One update over several threads: the same commands, and how much sooner.
threads() {
  local bad=0 n one two sizes='256 512 1024'
  local -a short=(--updates 2000 --times)
  whole || { sizes=128; short=(--updates 200 --times); }
  for n in $sizes; do
    one=$(number "$(flown chain_$n "${short[@]}" --threads 1)" median_us)
    two=$("$sightline" bench --case chain_$n "${short[@]}" --threads 2 --json 2>/dev/null | sed -nE 's/.*"median_us": ([-0-9.e+]+),?/\1/p' | head -n 1)
    echo "chain_$n: $one us by one thread, $two us by two"
    row_at_most "chain_$n, time of two threads over one" "$(awk -v a="$two" -v b="$one" 'BEGIN { printf "%.3f", a / b }')" 0.588 || bad=1
  done
  tests solver_test 'ThreadPools.*' || bad=1
  return $bad
}

# Teams of any graph: the converged solve is stationary, and real-time steps stay near their task.
graphs() { tests solver_campaign_test 'RandomGraphs.*'; }

# p99.99, beside a second core that is busy.
tails() {
  local name updates=1000000 busy priority=(chrt -f 50)
  whole || updates=2000
  "${priority[@]}" true 2>/dev/null || { echo 'no right to SCHED_FIFO here: times of an ordinary process'; priority=(); }
  # The kernel stops for 50 ms of each second who takes more of a core by FIFO. A control thread
  # does not, updates without a pause do.
  local limit=/proc/sys/kernel/sched_rt_runtime_us before
  before=$(<$limit)
  taskset -c $((1 - core)) bash -c 'while :; do :; done' &
  busy=$!
  trap "{ kill $busy; echo $before >$limit; } 2>/dev/null" EXIT  # a section has a shell of its own; whatever ends it, the machine is as it was
  ! whole || { echo -1 >$limit; } 2>/dev/null || echo "kernel.sched_rt_runtime_us stays $before: the longest times are those of its pauses"
  for name in pair strong_chain_64 swarm_32; do
    taskset -c "$core" "${priority[@]}" "$sightline" bench --case $name --updates "$updates" --times --json >"$out/tail_$name.json" 2>/dev/null || echo "$name: failed"
    echo "$name: median $(number "$out/tail_$name.json" median_us) us, p99 $(number "$out/tail_$name.json" p99_us) us, p99.99 $(number "$out/tail_$name.json" p9999_us) us, longest $(number "$out/tail_$name.json" max_us) us of $updates; allocations $(number "$out/tail_$name.json" allocations)"
  done
  for name in pair strong_chain_64 swarm_32; do [[ $(number "$out/tail_$name.json" allocations) == 0 ]] || return 1; done
}

# Medians and p99 [us] of the rows of a bench case on one core: NAME MEDIAN P99.
rows_of() {
  taskset -c "$core" "$sightline" bench --case "$1" 2>/dev/null | awk -F'|' '$3 ~ /newton|barrier/ { gsub(/ /, ""); print $2, $5, $6 }'
}
# $1: text of rows; $2: row; $3: 2 median, 3 p99.
figure_of() { awk -v name="$2" -v column="$3" '$1 == name { print $column }' <<<"$1"; }
at_most() { awk -v value="$1" -v most="$2" 'BEGIN { exit !(value != "" && value <= most) }'; }

# Swarms that cross with the barrier off: distance, arrival, pairs; the worst second, alone and with
# the barrier.
swarm() {
  tests cli_campaign_test 'SwarmFlights.*' || return 1
  local rows bad=0 n=64
  whole && n=128
  rows=$(rows_of swarm_$n)
  echo "$rows"
  local alone both
  alone=$(figure_of "$rows" swarm_${n}_crossing 2) both=$(figure_of "$rows" swarm_${n}_barrier_crossing 2)
  echo "with the barrier $(awk -v a="$alone" -v b="$both" 'BEGIN { print b / a }') times as long"
  if whole; then
    at_most "$both" "$(awk -v a="$alone" 'BEGIN { print 1.5 * a }')" || bad=1
    at_most "$alone" 3000 || bad=1
    at_most "$(figure_of "$rows" swarm_${n}_crossing 3)" 6000 || bad=1
  fi
  ((bad == 0))
}

# The barrier of one robot against 16 that close in.
barrier() {
  local rows
  rows=$(rows_of barrier_16)
  echo "$rows"
  [[ -n $rows ]] || return 1
  ! whole || { at_most "$(figure_of "$rows" barrier_16 2)" 3 && at_most "$(figure_of "$rows" barrier_16 3)" 10; }
}

# $1: robots; $2: seconds; $3: who feels; $4 to $6: weights of bearing, too_near, too_far; $7: more
# of the file. A chain on a circle.
chain_file() {
  printf '%s\n[simulation]\nduration = %s.0\nseed = 1\nsettle = 0.1\nrms_from = 0.1\n' "${7:-}" "$2"
  printf '[agent."uav{0000..%04d}"]\nrobot = "multirotor"\n' $(($1 - 1))
  printf 'start.p = { place = "circle", centre = [0.0, 0.0, 1.5], radius = %s.0 }\n' $(($1 / 5))
  printf 'sensor = { pitch = 0.0, offset = 0.1 }\n[[shape]]\nfelt_by = "%s"\nchain = [' "$3"
  printf '"uav%04d", ' $(seq 0 $(($1 - 1)))
  printf ']\npotentials = [{ bearing = { alpha = 0.5, width = 0.1, tilt = 0.2 }, weight = %s }, ' "$4"
  printf '{ too_near = { d_min = 1.0, kappa = 10.0 }, weight = %s }, { too_far = { d_max = 2.0, kappa = 10.0 }, weight = %s }]\n' "$5" "$6"
}

# Memory, log and report of a chain of many.
large() {
  local folder n=256 seconds=2 bad=0 bytes
  whole && n=1024 seconds=10
  folder=$(mktemp -d)
  chain_file $n $seconds both 0.4 0.4 0.4 >"$folder/chain.toml"
  # In so short a flight not all come into view: exit 1.
  /usr/bin/time -q -f '%M KB at most, %U s of processor' -o "$folder/used" "$sightline" run "$folder/chain.toml" -o "$folder/out" &>"$folder/said"
  (($? < 2)) || { cat "$folder/said"; bad=1; }
  cat "$folder/used"
  for file in run.mcap report.html summary.json; do
    bytes=$(stat -c %s "$folder/out/$file")
    echo "$file: $bytes bytes"
    [[ $file == report.html ]] && { at_most "$bytes" 10000000 || bad=1; }
  done
  rm -rf "$folder"
  ((bad == 0))
}

# A large team in real time, from its cold start on. Past a deadline its updates end with the step
# they are at, and say so; commands keep to their limits.
deadline() {
  local folder n=128 bad=0 ms longest limits=(0 1)
  whole && n=1024 limits=(0 30 10)
  folder=$(mktemp -d)
  for ms in "${limits[@]}"; do
    chain_file $n 1 observer 4.0 4.0 8.0 "solver = { deadline = ${ms}e-3 }" >"$folder/chain.toml"  # 0: none
    taskset -c "$core" "$sightline" run "$folder/chain.toml" --realtime -o "$folder/out" &>"$folder/said"
    (($? < 2)) || { cat "$folder/said"; bad=1; }
    grep -E '^(updates|time to solve)' "$folder/said"
    for key in allocations_per_update input_violations not_finite; do
      [[ $(number "$folder/out/summary.json" $key) == 0 ]] || { echo "$key is not 0"; bad=1; }
    done
    longest=$(sed -nE 's/.*longest ([0-9]+) µs.*/\1/p' "$folder/said")
    ((ms == 0)) || grep -qE '^updates .*[0-9] deadline' "$folder/said" || { echo 'no update says that it was late'; bad=1; }
    whole || continue
    ((ms == 0)) || row_at_most "longest update of $n robots with a deadline of $ms ms, us" "$longest" $((1000 * ms + 15000)) || bad=1
  done
  rm -rf "$folder"
  ((bad == 0))
}

all=(times spectra deadline threads graphs tails swarm barrier large)
run_sections "$@"
