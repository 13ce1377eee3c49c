#!/usr/bin/env bash
# The figures of verdicts, commands and what comes from outside, section by section:  scripts/accept/43.sh [--short] [SECTION ...]
# What is finished stays in out/accept/43/ and is not done again; delete it to begin anew. Needs the
# release preset built with tests. BEFORE=path names the binary that `bench` compares with.
# `debian13` needs root.
# --short is for CI, beside the 40 random scenarios of scripts/test.sh: ten others.
set -uo pipefail
cd "$(dirname "$0")/../.." || exit 1
build=build/release
. scripts/accept/sections.sh

# Inputs that were taken for what they are not, and sentences of what is refused.
promises() { ctests '^cli\.(Promises|RefusedFiles)\.'; }

# Verdicts against a judge that shares no code with them.
judge_block() {
  local python3
  python3=$(sed -nE 's/^Python_EXECUTABLE:[A-Z]+=//p' "$build/CMakeCache.txt")
  "${python3:-python3}" -B tests/independent/campaign.py --draw "$build/tests/draw_scenario" --binary "$build/bin/sightline" \
    --first "$1" --count "$2" --keep "$out/random/kept"
}
random() {
  export out
  if whole; then blocks 0 50 1999 judge_block; else blocks 2000 5 2009 judge_block; fi
  cat "$out"/random/*.txt | awk '/^[0-9]+ scenarios:/ { for (i = 1; i <= 12; ++i) n[i] += $i; replays += $14; bytes += $18 }
    END { printf "%d scenarios: %d verdict differences, %d commands not finite or beyond limits, %d replays that differ, %d byte differences\n",
            n[1], n[3], n[6], replays, bytes }'
  local bad
  mapfile -t bad < <(grep -LE ': 0 verdict differences, 0 commands .*, 0 replays that differ, 0 byte differences$' "$out"/random/*.txt)
  failed_blocks '^(?!exit codes|[0-9]+ scenarios:)' "${bad[@]}"
}

# Full disks, no memory, no descriptors, handlers that throw, logs that are stuck, floods of
# messages: no flight ends by them.
outside() {
  ctests '^(base\.(CCallback|Failure|ServiceThread)|record\.(Log|Mcap)|run\.LoopSink|server\.(Outside|PageServer|Tuning)|dds\.(ChannelOwner|Flood)|cli\.Memory)\.|^house\.lint$'
}

mutants() { scripts/mutants.sh "$build" barrier verdicts gate; }
debian13() { scripts/debian.sh trixie; }
bench() {
  [[ -x ${BEFORE:-} ]] || { echo "BEFORE = \"${BEFORE:-}\", expected the binary of the commit before"; return 1; }
  scripts/accept/bench_turns.sh "$BEFORE" "$build/bin/sightline_bench"
}

all=(promises random outside mutants debian13 bench)
whole || all=(random)
run_sections "$@"
