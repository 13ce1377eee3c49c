#!/usr/bin/env bash
# Writes docs/reference.md from the code that reads keys and options:  scripts/reference.sh [--check] [PROGRAM]
# --check writes nothing and ends with 1 where the file differs. PROGRAM: build/release/bin/sightline_reference.
set -euo pipefail
cd "$(dirname "$0")/.."
page=docs/reference.md
check=
if [[ ${1:-} == --check ]]; then check=1 && shift; fi
made=$("${1:-build/release/bin/sightline_reference}")
if [[ -z $check ]]; then
  printf '%s\n' "$made" >"$page"
elif ! diff -u "$page" <(printf '%s\n' "$made"); then
  echo "reference.sh: $page differs from the code, expected what scripts/reference.sh writes" >&2
  exit 1
fi
