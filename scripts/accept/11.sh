#!/usr/bin/env bash
# Every figure that "Ready for the world" asks for, section by section:  scripts/accept/11.sh [--short] [SECTION ...]
# What is finished stays in out/accept/11/ and is not done again; delete it to begin anew. Needs the release preset, and
# `npm ci --prefix tests/npm`. BEFORE=path names the binary of the commit before, which flies the scenarios of its time. --short is for CI: a log against itself.
set -uo pipefail
cd "$(dirname "$0")/../.." || exit 1
begin_commit=22aaa23  # the last one before
build=build/release
form=whole out=out/accept/11
if [[ ${1:-} == --short ]]; then
  form=short out=$(mktemp -d) begin_commit=HEAD
  trap 'rm -rf "$out"' EXIT
  BEFORE=$build/bin/sightline
  shift
fi
mkdir -p "$out"

# The log of every shipped scenario, seed 1, is the same before and after, message by message.
logs() {
  local before=${BEFORE:-} after=$build/bin/sightline name told bad=0 flown=0
  [[ -x $before ]] || { echo "BEFORE = \"$before\", expected the binary of the commit before"; return 1; }
  local -a scenarios=(scenarios/*.toml)
  [[ $form == whole ]] || scenarios=(scenarios/handover.toml)
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

# GCC and clang print the same kernels and fly every shipped scenario, seed 1, to the same messages. Builds the preset
# clang, library and command line, into build/clang; --short: the kernels alone.
bits() {
  local other=build/clang kernels=$out/clang_kernels name told bad=0 flown=0 side
  local target=sightline_cli
  [[ $form == whole ]] || target=sightline_generate
  cmake --preset clang -DSIGHTLINE_TESTS=OFF -DSIGHTLINE_BENCH=OFF >/dev/null &&
    cmake --build --preset clang --target "$target" | tail -n 1
  ((PIPESTATUS[0] == 0)) && "$other/bin/sightline_generate" "$kernels" && diff -rq "$build/generated/kernels" "$kernels" || return 1
  echo "$(find "$kernels" -name '*.cpp' | wc -l) files of kernels, all the same"
  [[ $form == whole ]] || return 0
  local -a scenarios=(scenarios/*.toml)
  for scenario in "${scenarios[@]}"; do
    name=$(basename "$scenario" .toml)
    for side in "$build" "$other"; do
      "$side/bin/sightline" run "$scenario" --seed 1 -o "$out/$side/$name" >"$out/$name.txt" 2>&1
      (($? <= 1)) || { echo "$side: $scenario did not fly"; tail -n 3 "$out/$name.txt"; bad=$((bad + 1)); continue 2; }
    done
    if told=$(node tests/npm/same_mcap.mjs "$out/$build/$name/run.mcap" "$out/$other/$name/run.mcap" 2>&1); then
      flown=$((flown + 1))
    else
      bad=$((bad + 1))
    fi
    printf '%-40s %s\n' "$scenario" "$told"
    rm -rf "$out/$build/$name" "$out/$other/$name" "$out/$name.txt"
  done
  echo "$flown logs the same, $bad not"
  ((bad == 0 && flown > 0))
}

all=(logs bits)
sections=("$@")
((${#sections[@]} > 0)) || sections=("${all[@]}")
bad=0
for section in "${sections[@]}"; do
  [[ " ${all[*]} " == *" $section "* ]] || { echo "11.sh: SECTION = $section, expected one of ${all[*]}" >&2; exit 2; }
  result=$out/$section.txt
  [[ -f $result ]] && continue
  echo "=== $section"
  if "$section" 2>&1 | tee "$result.part"; ((PIPESTATUS[0] == 0)); then
    mv "$result.part" "$result"
  else
    bad=$((bad + 1))
  fi
done
echo "$((${#sections[@]} - bad)) passed, $bad failed"
((bad == 0))
