#!/usr/bin/env bash
# Runs what the documents promise:  scripts/docs_blocks.sh [FILE.md ...]
# Blocks opened by "```sh test" run in a shell at the root of the tree, with an out/ of their own (a
# campaign of an older program would be refused there), build/release/bin in the path; blocks opened
# by "```sh test mujoco" and "```sh test dds" where the world of MuJoCo and the bridge to DDS were
# built; blocks opened by "```py test" are whole programs of Python, run where the module was built;
# blocks opened by "```cpp test" are whole programs, built against an installed sightline, as a user
# would, and run. So are the examples of one's own potential and one's own robot, with their
# formulas compiled and without: both print the same.
set -euo pipefail
cd "$(dirname "$0")/.."
root=$PWD
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

files=("$@")
((${#files[@]} > 0)) || files=(README.md CONTRIBUTING.md docs/*.md)
mkdir -p "$work/blocks" "$work/trees"
# Recorded data stand beside the tree; blocks that need them end at once where they are absent.
[[ ! -e ../shared ]] || ln -s "$root/../shared" "$work/trees/shared"
mujoco=$(ls build/release/lib/libsightline_mujoco.* 2>/dev/null || true)
dds=$(ls build/release/lib/libsightline_dds.* 2>/dev/null || true)
module=$(ls build/release/python/sightline/_sightline.* 2>/dev/null || true)
# The python that the module is for.
python=$(sed -n 's/^Python_EXECUTABLE:[A-Z]*=//p' build/release/CMakeCache.txt 2>/dev/null || true)
for file in "${files[@]}"; do
  [[ -f $file ]] || continue
  # One file a block, called <document>-<line>.<language>.
  awk -v to="$work/blocks/$(basename "$file" .md)" -v mujoco="$mujoco" -v dds="$dds" -v module="$module" '
    /^```(sh|cpp) test *$/ || ($0 == "```py test" && module) || ($0 == "```sh test mujoco" && mujoco) || ($0 == "```sh test dds" && dds) { language = substr($1, 4); block = sprintf("%s-%03d.%s", to, NR, language); next }
    /^```/ { block = "" }
    block { print > block }' "$file"
done

shopt -s nullglob
programs=("$work"/blocks/*.cpp)
if ((${#programs[@]} > 0)); then
  cmake --build --preset release >/dev/null
  cmake --install build/release --prefix "$work/installed" >/dev/null
  cat >"$work/CMakeLists.txt" <<'CMAKE'
cmake_minimum_required(VERSION 3.25)
project(documents LANGUAGES C CXX)
find_package(sightline REQUIRED)
file(GLOB blocks blocks/*.cpp)
foreach(block IN LISTS blocks)
  cmake_path(GET block STEM name)
  add_executable(${name} ${block})
  target_link_libraries(${name} PRIVATE sightline::sightline)
endforeach()
foreach(example own_potential own_robot)
  foreach(name ${example}_compiled ${example}_interpreted)
    add_executable(${name} ${examples}/${example}.cpp)
    target_link_libraries(${name} PRIVATE sightline::sightline)
  endforeach()
  sightline_add_formulas(${example}_compiled ${examples}/${example}.hpp)
endforeach()
CMAKE
  cmake -S "$work" -B "$work/build" -G Ninja -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_PREFIX_PATH="$work/installed" -Dexamples="$root/examples" >/dev/null
  for example in own_potential own_robot; do
    cat >"$work/blocks/$example-example.sh" <<SH
flock '$work/build' cmake --build '$work/build' --target ${example}_compiled ${example}_interpreted
'$work/build/${example}_compiled' | tee '$work/$example.flight'
'$work/build/${example}_interpreted' | diff '$work/$example.flight' -
SH
  done
fi

# Runs one block:  run_block BLOCK
run_block() {
  local program
  case $1 in
    *.py) PYTHONPATH=$root/build/release/python timeout 300 "$python" -B "$1" ;;
    *.sh) timeout 300 bash -euo pipefail -c 'trap "jobs -p | xargs -r kill" EXIT; . "$0"' "$1" ;;
    *.cpp)
      program=$(basename "$1" .cpp)
      flock "$work/build" cmake --build "$work/build" --target "$program" && timeout 300 "$work/build/$program"
      ;;
  esac
}

# Blocks of one document follow each other in one tree; documents have nothing to do with each
# other. A flight by the clock may fail where others compute: what failed is said, and tried once
# more.
run_document() {
  local document=$1 block name try code bad=0
  local tree=$work/trees/$document output=$work/$document.output entry
  mkdir -p "$tree"
  for entry in "$root"/*; do [[ $entry == "$root/out" ]] || ln -s "$entry" "$tree/"; done
  cd "$tree"
  for block in "$work/blocks/$document"-*; do
    name=$(basename "$block")
    for try in again failed; do
      code=0
      run_block "$block" </dev/null >"$output" 2>&1 || code=$?
      ((code != 0)) || break
      printf '%-8s%s\n' "$try" "$name (exit $code)" && tail -n 30 "$output"
    done
    if ((code == 0)); then printf '%-8s%s\n' ok "$name"; else bad=1; fi
  done
  return $bad
}

export PATH=$root/build/release/bin:$PATH root work python
export -f run_block run_document
documents=("$work"/blocks/*)
documents=("${documents[@]##*/}")
printf '%s\n' "${documents[@]%-*}" | sort -u | xargs -P "$(nproc)" -I '{}' bash -euo pipefail -c 'run_document {}'
