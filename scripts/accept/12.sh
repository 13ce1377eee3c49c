#!/usr/bin/env bash
# The figures of identified vehicles, section by section:  scripts/accept/12.sh [--short] [SECTION ...]
# What is finished stays in out/accept/12/ and is not done again; delete it to begin anew. Needs the release preset.
# --short is for CI: fewer seeds and vehicles, shorter flights that judge. BEFORE=path names a binary without the lean, against whose
# update the section `tilt` judges its own.
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

# A camera that leans with its body: a target at 2 m/s on a circle of 1.33 m (3 m/s^2) and of 2 m (2 m/s^2), by the true camera; an update with
# lean, lags and disturbance against that of cooperative_localization. Then a flight and its replay by the command line.
tilt() {
  local said code now then
  said=$(SIGHTLINE_CAMPAIGN=$form "$build/tests/record_campaign_test" --gtest_filter='BodyCameraCampaign.*' 2>&1)
  code=$?
  grep -E 'm/s\^2,|an update|Failure|Expected|Actual|actual|PASSED|FAILED' <<<"$said"
  ((code == 0)) || return 1
  if whole && [[ -x ${BEFORE:-} ]]; then
    now=$(sed -n 's/.*in the median: \([0-9.]*\) us.*/\1/p' <<<"$said")
    then=$(for _ in {1..9}; do
      "$BEFORE" run scenarios/cooperative_localization.toml -o "$out/before" >/dev/null 2>&1
      sed -n '/"solve_us"/,/}/s/.*"median": \([0-9.]*\).*/\1/p' "$out/before/summary.json"
    done | sort -g | head -n 1)
    echo "$then us before, with lean, lags and disturbance $(awk "BEGIN { printf \"%.2f\", $now / $then }") times as long"
    awk "BEGIN { exit !($now <= 1.6 * $then) }" || { echo "expected at most 1.6 times"; return 1; }
  fi
  local file=$out/leaning.toml
  { sed 's/^offset = 0.17 .*/&\nframe = "body"/' scenarios/cooperative_localization.toml; printf '\n[world]\nkind = "rotors"\n'; } >"$file"
  "$build/bin/sightline" run "$file" -o "$out/leaning" | grep 'sees' &&
    "$build/bin/sightline" replay "$out/leaning" | grep ', 0 differ' || return 1
}

all=(identify tilt)
run_sections "$@"
