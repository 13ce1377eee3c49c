#!/usr/bin/env bash
# The figures of identified vehicles, section by section:  scripts/accept/12.sh [--short] [SECTION ...]
# What is finished stays in out/accept/12/ and is not done again; delete it to begin anew. Needs the release preset.
# --short is for CI: fewer seeds and vehicles, shorter flights that judge.
set -uo pipefail
cd "$(dirname "$0")/../.." || exit 1
build=build/release
. scripts/accept/sections.sh

# 20 s of excitation in noise, judged on a task and on bang-bang of the same vehicle; the intervals of 20 drawn vehicles; the AR.Drone;
# the presets of hover_multirotor. Then the command itself, twice: the same numbers.
identify() {
  local said
  said=$(SIGHTLINE_CAMPAIGN=$form "$build/tests/analysis_campaign_test" --gtest_filter='IdentifyCampaign.*' 2>&1)
  local code=$?
  grep -E ' seeds: |drawn vehicles|numbers within|lumped |Failure|Expected|Actual|PASSED|FAILED' <<<"$said"
  ((code == 0)) || return 1
  local file=$out/rotors.toml
  { cat scenarios/cooperative_localization.toml; printf '\n[world]\nkind = "rotors"\n'; } >"$file"
  "$build/bin/sightline" identify "$file" --agent uav0 -o "$out/first" >/dev/null &&
    "$build/bin/sightline" identify "$file" --agent uav0 -o "$out/second" >/dev/null &&
    cmp "$out"/{first,second}/identify.json && echo "identify.json twice the same" || return 1
  whole || rm -rf "$out"/{first,second}
}

all=(identify)
run_sections "$@"
