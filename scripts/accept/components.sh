#!/usr/bin/env bash
# Builds without one component of the library each, section by section:  scripts/accept/components.sh [--short] [SECTION ...]
# The command line is built, flies, and names the component of a command that it lacks. --short, for
# CI, configures alone.
set -uo pipefail
cd "$(dirname "$0")/../.." || exit 1
. scripts/accept/sections.sh

# $1: the component; $2: the others; $3: one of its commands.
without() {
  local build=build/without_$1 bin=build/without_$1/bin/sightline
  cmake --preset release -B "$build" -DSIGHTLINE_{TESTS,BENCH}=OFF "-DSIGHTLINE_COMPONENTS=$2" | grep 'for want of'
  if grep -rlE "(src/sightline|cli)/$1/.*cpp" "$build" --include={build.ninja,unity\*.cxx} || (($? > 1)); then return 1; fi
  whole || return 0
  cmake --build "$build" --target sightline_cli | tail -n 1
  "$bin" run scenarios/cooperative_localization.toml -o "$out/$1" && "$bin" check scenarios/paper_7_1.toml || return 1
  "$bin" "$3" x.toml 2>&1 | grep "with the component $1:" && [[ $("$bin" --help) != *"$3 "* ]]
}
campaign() { without campaign 'analysis;server' campaign; }
analysis() { without analysis 'campaign;server' explain; }
server() { without server 'campaign;analysis' view; }

all=(campaign analysis server)
run_sections "$@"
