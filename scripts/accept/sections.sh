# Sections of an acceptance script, to be sourced with its arguments. What is finished stays in
# out/accept/NAME/ and is not done again; delete it to begin anew. --short, for CI, sets form=short
# and forgets what it finds.
form=whole out=out/accept/$(basename "$0" .sh)
if [[ ${1:-} == --short ]]; then
  form=short out=$(mktemp -d)
  trap 'rm -rf "$out"' EXIT
  shift
fi
mkdir -p "$out"
whole() { [[ $form == whole ]]; }

# $1: program of tests; $2: which. What they print, and that there were any.
tests() {
  local said code=0
  said=$(SIGHTLINE_CAMPAIGN=$form "$build/tests/$1" --gtest_filter="$2" 2>&1) || code=$?
  grep -vE '^(\[(==|--| RUN)|Note: |$)' <<<"$said"
  grep -qE 'PASSED  \] [1-9]' <<<"$said" && ((code == 0))
}

# Blocks of numbers side by side, each of which leaves what it printed in $out/random/: what is
# there is not done again. $1, $2, $3: first, size of a block, last; $4: a function of the first
# number and the size.
blocks() {
  mkdir -p "$out/random"
  export -f "$4"
  export build
  seq "$1" "$2" "$3" | xargs -P "$(nproc)" -I{} bash -c '
    done=$1/$(printf %04d "$2").txt
    [[ -s $done ]] && exit 0
    "$4" "$2" "$3" >"$done.part" 2>&1
    mv "$done.part" "$done"' _ "$out/random" {} "$2" "$4"
}
# $1: lines to show, as Perl has expressions; the rest: files of blocks that failed, which are flown
# again the next time.
failed_blocks() {
  local shown=$1
  shift
  (($# == 0)) && return
  grep -hP "$shown" "$@" | head -n 60
  rm -f "$@"
  return 1
}
# $1: tests of ctest by a regular expression; the rest: more for ctest. Those that failed, and how
# many passed; none is a failure.
ctests() {
  ctest --preset release -j "$(nproc)" --no-tests=error -R "$@" | grep -E 'tests passed|Failed|Timeout'
  ((PIPESTATUS[0] == 0))
}

# $@: the sections to run, functions of `all`; without any, all of them.
run_sections() {
  local -a sections=("$@")
  local section result verdict begin bad=0 table=''
  ((${#sections[@]} > 0)) || sections=("${all[@]}")
  for section in "${sections[@]}"; do
    [[ " ${all[*]} " == *" $section "* ]] || { echo "$(basename "$0"): SECTION = $section, expected one of ${all[*]}" >&2; exit 2; }
    result=$out/$section.txt
    if [[ ! -f $result ]]; then
      begin=$SECONDS
      echo "=== $section"
      if "$section" 2>&1 | tee "$result.part"; ((PIPESTATUS[0] == 0)); then
        echo "$((SECONDS - begin)) s" >>"$result.part"
        mv "$result.part" "$result"
      fi
    fi
    verdict=pass
    [[ -f $result ]] || { verdict=FAIL; bad=$((bad + 1)); result=$result.part; }
    table+=$(printf '%-4s  %-13s  %s' "$verdict" "$section" "$(tail -n 2 "$result" | tr '\n' ' ')")$'\n'
  done
  printf '\n%s' "$table"
  echo "$((${#sections[@]} - bad)) passed, $bad failed"
  ((bad == 0))
}
