#!/usr/bin/env bash
# Every figure that "Promises kept" asks for, section by section:  scripts/accept/10.sh [--short] [SECTION ...]
# What is finished stays in out/accept/10/ and is not done again; delete it to begin anew. A killed
# run goes on where it was. Needs the release preset built with tests. BEFORE=path names the binary
# of the commit before, for `bench`.
# --short is for CI, beside the short forms of all campaigns that scripts/test.sh flies: `bench_turns.sh` itself.
# Random scenarios are in 43.sh.
set -uo pipefail
cd "$(dirname "$0")/../.." || exit 1
begin_commit=b18f400  # the last one before
build=build/release
. scripts/accept/sections.sh
export SIGHTLINE_CAMPAIGN=$form

# Runs tests of a program by their names; none at all is a failure. $1: program, $2: filter.
tests() {
  local log code
  log=$(mktemp -p "$out")
  "$build/tests/$1" --gtest_filter="$2" >"$log" 2>&1
  code=$?
  grep -vE '^(\[|Note:|Running main|$)' "$log" | head -n 60
  sed -nE 's/^\[==========\] ([0-9]+ tests?) from .* ran.*/\1 of '"$1"'/p' "$log"
  ((code == 0)) && grep -qE '^\[  PASSED  \] [1-9]' "$log"
  code=$?
  rm -f "$log"
  return $code
}

# Tests that came with the work on this: their names are in the history.
defects() {
  local names
  git cat-file -e "$begin_commit" 2>/dev/null || { echo "commit $begin_commit is not in this clone"; return 1; }
  names=$(git diff "$begin_commit" HEAD -- 'tests/*_test.cpp' |
    sed -nE 's/^\+(TYPED_)?TEST(_[FP])?\(([A-Za-z0-9_]+), *([A-Za-z0-9_]+)\).*/\3.*\4/p' | sort -u)
  echo "$(wc -l <<<"$names") tests came since $begin_commit"
  ctests "[./](${names//$'\n'/|})(/|\$)" -LE long
}
encirclements() { tests safety_campaign_test 'EncirclementCampaign.*'; }
one_attacker() { tests safety_campaign_test 'BarrierCampaign.*'; }
drivers() { tests safety_campaign_test 'DrivingCampaign.*'; }
mixed_teams() { tests scenario_campaign_test 'MixedTeamCampaign.*'; }
mutants() { scripts/mutants.sh "$build" barrier; }
bench() {
  local after=$build/bin/sightline_bench
  if ! whole; then TURNS=1 LIMIT=2 scripts/accept/bench_turns.sh "$after" "$after" pair; return; fi
  [[ -x ${BEFORE:-} ]] || { echo "BEFORE = \"${BEFORE:-}\", expected the binary of commit $begin_commit"; return 1; }
  scripts/accept/bench_turns.sh "$BEFORE" "$after"
}
kills() { tests cli_campaign_test 'Killed.*'; }

all=(defects encirclements one_attacker drivers mixed_teams mutants bench kills)
whole || all=(bench)
run_sections "$@"
