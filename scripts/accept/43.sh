#!/usr/bin/env bash
# The figures of verdicts, commands and what comes from outside, section by section:  scripts/accept/43.sh [--short] [SECTION ...]
# What is finished stays in out/accept/43/ and is not done again; delete it to begin anew. Needs the release preset built with tests.
# BEFORE=path names the binary that `bench` compares with. `debian13` needs root.
# --short is for CI, beside the 40 random scenarios of scripts/test.sh: ten others.
set -uo pipefail
cd "$(dirname "$0")/../.." || exit 1
build=build/release
. scripts/accept/sections.sh

# $1: tests of ctest. Those that failed, and how many passed; none at all is a failure.
tests_named() {
  ctest --preset release -R "$1" -j "$(nproc)" --no-tests=error | grep -E 'tests passed|Failed|Timeout|No tests'
  ((PIPESTATUS[0] == 0))
}

# Inputs that were taken for what they are not, and sentences of what is refused.
promises() { tests_named '^cli\.(Promises|RefusedFiles)\.'; }

# Verdicts against a judge that shares no code with them. Blocks side by side; each leaves what it printed.
random() {
  local from=0 to=1999 block=50
  whole || from=2000 to=2009 block=5
  mkdir -p "$out/random"
  seq "$from" "$block" "$to" | xargs -P "$(nproc)" -I{} bash -c '
    done=$1/$(printf %04d "$2").txt
    [[ -s $done ]] && exit 0
    python3=$(sed -nE "s/^Python_EXECUTABLE:[A-Z]+=//p" "$4/CMakeCache.txt")
    "${python3:-python3}" -B tests/independent/campaign.py --draw "$4/tests/draw_scenario" --binary "$4/bin/sightline" \
      --first "$2" --count "$3" --keep "$1/kept" >"$done.part" 2>&1
    mv "$done.part" "$done"' _ "$out/random" {} "$block" "$build"
  cat "$out"/random/*.txt | awk '/^[0-9]+ scenarios:/ { for (i = 1; i <= 12; ++i) n[i] += $i; replays += $14; bytes += $18 }
    END { printf "%d scenarios: %d verdict differences, %d commands not finite or beyond limits, %d replays that differ, %d byte differences\n",
            n[1], n[3], n[6], replays, bytes }'
  local bad
  mapfile -t bad < <(grep -LE ': 0 verdict differences, 0 commands .*, 0 replays that differ, 0 byte differences$' "$out"/random/*.txt)
  ((${#bad[@]} == 0)) && return
  grep -hvE '^exit codes|^[0-9]+ scenarios:' "${bad[@]}" | head -n 60
  rm -f "${bad[@]}"  # flown again the next time
  return 1
}

# Full disks, no memory, no descriptors, handlers that throw, logs that are stuck, floods of messages: no flight ends by them.
outside() {
  tests_named '^(base\.(CCallback|Failure|ServiceThread)|house\.Threads|record\.(Log|Mcap)|run\.LoopSink|server\.(Outside|PageServer|Tuning)|dds\.(ChannelOwner|Flood)|cli\.Memory)\.'
}

mutants() { scripts/mutants.sh "$build" barrier verdicts gate; }
debian13() { scripts/debian13.sh; }
bench() {
  [[ -x ${BEFORE:-} ]] || { echo "BEFORE = \"${BEFORE:-}\", expected the binary of the commit before"; return 1; }
  scripts/accept/bench_turns.sh "$BEFORE" "$build/bin/sightline"
}

all=(promises random outside mutants debian13 bench)
whole || all=(random)
run_sections "$@"
