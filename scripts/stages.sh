# Stages of a script with their times and a count of those that passed; source it at the root of the
# tree.

passed=0 failed=0
stage() {
  local begin=$SECONDS name=$1 code=0
  shift
  echo "=== $name"
  "$@" || code=$?
  ((code == 0)) && passed=$((passed + 1)) || failed=$((failed + 1))
  echo "=== $name: $((SECONDS - begin)) s, exit $code"
  return "$code"
}
finish() {
  echo "$passed passed, $failed failed"
  ((failed == 0 && passed > 0))
  exit
}
refuse() { echo "${0##*/}: $*" >&2; exit 2; }
