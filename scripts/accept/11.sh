#!/usr/bin/env bash
# Every figure that "Ready for the world" asks for, section by section:  scripts/accept/11.sh [--short] [SECTION ...]
# What is finished stays in out/accept/11/ and is not done again; delete it to begin anew. Needs the release preset, and
# `npm ci --prefix tests/npm`. BEFORE=path names the binary of the commit before, which flies the scenarios of its time.
# --short is for CI: a log against itself.
set -uo pipefail
cd "$(dirname "$0")/../.." || exit 1
begin_commit=22aaa23  # the last one before
build=build/release
. scripts/accept/sections.sh
whole || begin_commit=HEAD BEFORE=$build/bin/sightline

# The log of every shipped scenario, seed 1, is the same before and after, message by message.
logs() {
  local before=${BEFORE:-} after=$build/bin/sightline name told bad=0 flown=0
  [[ -x $before ]] || { echo "BEFORE = \"$before\", expected the binary of the commit before"; return 1; }
  local -a scenarios=(scenarios/*.toml)
  whole || scenarios=(scenarios/handover.toml)
  mkdir -p "$out/tree"
  git archive "$begin_commit" scenarios | tar -x -C "$out/tree" || return 1
  for scenario in "${scenarios[@]}"; do
    name=$(basename "$scenario" .toml)
    [[ -f $out/tree/$scenario ]] || continue  # it is new
    if told=$(diff <("$before" check "$out/tree/$scenario") <("$after" check "$scenario")); [[ -n $told ]]; then
      printf '%-40s is another team now:\n%s\n' "$scenario" "$told"
      continue
    fi
    for side in before after; do
      local of=$scenario
      [[ $side == after ]] || of=$out/tree/$scenario
      "${!side}" run "$of" --seed 1 -o "$out/$side/$name" >"$out/$side-$name.txt" 2>&1
      (($? <= 1)) || { echo "$side: $scenario did not fly"; tail -n 3 "$out/$side-$name.txt"; bad=$((bad + 1)); continue 2; }
    done
    if told=$(node tests/npm/same_mcap.mjs "$out"/{before,after}/"$name"/run.mcap 2>&1); then
      flown=$((flown + 1))
    else
      bad=$((bad + 1))
    fi
    printf '%-40s %s\n' "$scenario" "$told"
    rm -rf "$out"/{before,after}/"$name" "$out"/{before,after}-"$name.txt"
  done
  echo "$flown logs the same, $bad not"
  ((bad == 0 && flown > 0))
}

all=(logs)
run_sections "$@"
