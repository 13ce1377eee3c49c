#!/usr/bin/env bash
# Times two builds in turns, case by case on one core, and fails where the second is more than 3 %
# slower:
#   scripts/accept/bench_turns.sh BEFORE AFTER [CASE ...]
# BEFORE and AFTER are programs sightline_bench, or sightline of a commit without that program. Each
# runs `bench --case --times`. The least of the medians of TURNS (5) turns counts: other load only
# adds time. A case beyond LIMIT (1.03) is timed again, up to four times. Each turn times fresh
# copies: the pages of memory that hold a program's file decide up to 40 % of a case. One core
# (CORE, else 1).
set -euo pipefail
(($# >= 2)) || { echo "bench_turns.sh: expected BEFORE AFTER [CASE ...]" >&2; exit 2; }
before=$(realpath "$1") after=$(realpath "$2")
copies=$(mktemp -d)
trap 'rm -rf "$copies"' EXIT
shift 2
cases=("$@")
if ((${#cases[@]} == 0)); then
  IFS=', ' read -ra cases <<<"$("$after" bench --case none 2>&1 | sed -nE 's/.*expected one of ([^;]*);.*/\1/p')"
  cases+=(barrier_1 barrier_4 barrier_16 swarm_32 events_8 estimate)
fi

median() { taskset -c "${CORE:-1}" "$1" bench --case "$2" --times --json 2>/dev/null | sed -nE 's/.*"median_us": ([0-9.e+-]+),?/\1/p' | head -n 1; }
least() { printf '%s\n' "$@" | sort -g | head -n 1; }
# By more than the clock's 10 ns, which cases of 0.2 us consist of.
is_slower() { awk -v a="$a" -v b="$b" -v limit="${LIMIT:-1.03}" 'BEGIN { exit !(b > limit * a && b - a > 0.011) }'; }

bad=0 compared=0
printf '| case | before us | after us | ratio |\n|---|---|---|---|\n'
for name in "${cases[@]}"; do
  a='' b='' ratio='' verdict=''
  for ((again = 0; again < 4; ++again)); do
    for ((turn = 0; turn < ${TURNS:-5}; ++turn)); do
      cp "$before" "$copies/before" && cp "$after" "$copies/after"
      a=$(least $a "$(median "$copies/before" "$name")")
      [[ -n $a ]] || break 2
      b=$(least $b "$(median "$copies/after" "$name")")
      rm "$copies"/*
    done
    [[ -n $b ]] || break
    ratio=$(awk -v a="$a" -v b="$b" 'BEGIN { printf "%.3f", b / a }')
    is_slower || break
  done
  if [[ -z $a ]]; then
    verdict='(new)'
  else
    compared=$((compared + 1))
    if [[ -z $b ]]; then
      verdict='**failed**'
    elif is_slower; then
      verdict=' **slower**'
    fi
    [[ -z $verdict ]] || bad=$((bad + 1))
  fi
  printf '| %s | %s | %s | %s%s |\n' "$name" "${a:--}" "${b:--}" "$ratio" "$verdict"
done
echo "$bad of $compared cases failed or more than $(awk -v l="${LIMIT:-1.03}" 'BEGIN { printf "%g", 100 * (l - 1) }') % slower"
((bad == 0 && compared > 0))
