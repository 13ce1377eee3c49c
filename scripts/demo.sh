#!/usr/bin/env bash
# Builds sightline and flies two robots, one of which keeps the other in view:  scripts/demo.sh
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/deps.sh demo
# A fresh build leaves out what this flight and its page need not; one that has its tests keeps all.
options=()
grep -qsE '^SIGHTLINE_TESTS:BOOL=(ON|TRUE)$' build/release/CMakeCache.txt ||
  options=(-DSIGHTLINE_{TESTS,BENCH,DDS,MUJOCO}=OFF -DSIGHTLINE_COMPONENTS=server "-DSIGHTLINE_KERNELS=multirotor;paper_potentials")
cmake --preset release "${options[@]}" >&2
cmake --build --preset release --target sightline_cli >&2

out=out/cooperative_localization
code=0
build/release/bin/sightline run scenarios/cooperative_localization.toml -o "$out" || code=$?

echo
for file in report.html run.mcap summary.json; do
  if [[ -f $out/$file ]]; then
    printf '%-14s %s\n' "$file" "$PWD/$out/$file"
  else
    printf '%-14s %s\n' "$file" "was not written" >&2
    ((code != 0)) || code=1
  fi
done
if grep -q '"/page.js"' build/release/generated/built_page.cpp; then
  ((code != 0)) || printf '\nin a browser   build/release/bin/sightline view %s\n' "$out"
else
  printf '\n%s\n' "the build is without the page of sightline view: it lacks esbuild or libjs-three" >&2
fi
exit "$code"
