#!/usr/bin/env bash
# Builds the release preset and runs all tests:  scripts/test.sh [--long]
# Campaigns run in a short form unless --long; the last line says how many tests passed and failed.
set -uo pipefail
cd "$(dirname "$0")/.." || exit 1

export SIGHTLINE_CAMPAIGN=${SIGHTLINE_CAMPAIGN:-short}
case ${1:-} in
  "") ;;
  --long) SIGHTLINE_CAMPAIGN=whole ;;
  *) echo "test.sh: argument = $1, expected --long or none" >&2 && exit 2 ;;
esac

passed=0
failed=0
finish() {
  echo "$passed passed, $failed failed"
  ((failed == 0 && passed > 0))
  exit
}
need() {
  "$@" && return
  echo "test.sh: failed: $*" >&2
  failed=$((failed + 1))
  finish
}
# Runs ctest and adds its counts; a run that ends without them is one failure.
count() {
  local log counts
  log=$(mktemp)
  ctest --preset release "$@" | tee "$log"
  counts=$(sed -nE 's/^[0-9]+% tests passed, ([0-9]+) tests? failed out of ([0-9]+)$/\1 \2/p' "$log")
  if [[ -n $counts ]]; then
    read -r bad all <<<"$counts"
    passed=$((passed + all - bad))
    failed=$((failed + bad))
  elif ! grep -q '^No tests were found' "$log" || [[ $* == "-LE "* ]]; then
    failed=$((failed + 1))
  fi
  rm -f "$log"
}

need scripts/deps.sh test
# The tests read the log with the format's own library, and look at the page in a browser.
lock=tests/npm/package-lock.json
if [[ ! tests/npm/node_modules/.package-lock.json -nt $lock ]]; then
  need npm ci --prefix tests/npm --no-audit --no-fund
fi
need cmake --preset release
need cmake --build --preset release

jobs=$(nproc)
waiting=$((4 * jobs))
count -LE '^(long|dds)$' -j "$jobs"
# The tests of the bridge wait for the clock more than they compute.
count -L '^dds$' --no-tests=ignore -j "$waiting"
# Whole campaigns take all processors, one after the other.
[[ $SIGHTLINE_CAMPAIGN == short ]] || jobs=1 waiting=1
count -L long -R '^dds\.' --no-tests=ignore -j "$waiting"
count -L long -E '^dds\.' --no-tests=ignore -j "$jobs"
finish
