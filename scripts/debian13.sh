#!/usr/bin/env bash
# Builds sightline and runs its demo and all tests on Debian 13, in a root that debootstrap makes:
#   scripts/debian13.sh [--demo]
# --demo: without the tests. The root, build/debian13, is kept with its packages and its build; delete it to begin anew.
# Its packages come from where this machine's come from. Needs root, debootstrap, and `npm ci --prefix tests/npm`.
set -uo pipefail
cd "$(dirname "$0")/.." || exit 1

release=trixie
stages=(demo test)
case ${1:-} in
  "") ;;
  --demo) stages=(demo) ;;
  *) echo "debian13.sh: argument = $1, expected --demo or none" >&2; exit 2 ;;
esac
root=$PWD/build/debian13

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
refuse() { echo "debian13.sh: $*" >&2; exit 2; }

((EUID == 0)) || refuse "user = $(id -un), expected root, whom chroot is for"
command -v debootstrap >/dev/null || refuse "debootstrap is missing, expected Debian's package of that name"
[[ tests/npm/node_modules/.package-lock.json -nt tests/npm/package-lock.json ]] || npm ci --prefix tests/npm --no-audit --no-fund >&2 ||
  refuse "the libraries of tests are missing, expected npm ci --prefix tests/npm to pass"

# Where this machine has the packages of a suite from; nothing where it has none.
mirror() { apt-get indextargets --format '$(REPO_URI)' "Identifier: Packages" "Component: main" "Codename: $1" | head -n 1; }
make_root() {
  [[ -f $root/etc/apt/sources.list.d/own.list ]] && return
  local own main security
  own=$(. /etc/os-release && echo "$VERSION_CODENAME")
  main=$(mirror "$own") security=$(mirror "$own-security")
  [[ -n $main ]] || { echo "apt has no packages of $own, expected a mirror of Debian among its sources" >&2; return 1; }
  rm -rf "$root" && mkdir -p "$root" || return
  debootstrap --variant=minbase --include=ca-certificates "$release" "$root" "$main" >"$root.txt" || { tail -n 5 "$root.txt" >&2; return 1; }
  { [[ -z $security ]] || echo "deb $security $release-security main"; } >"$root/etc/apt/sources.list.d/own.list"
}
# The files that git knows, with their times, so that what did not change is not built again.
copy_tree() {
  local tree=$root/sightline
  mkdir -p "$tree" &&
    find "$tree" -mindepth 1 -maxdepth 1 ! -name build ! -name out -exec rm -rf {} + &&
    git ls-files -z --cached --others --exclude-standard |
      while IFS= read -rd '' file; do [[ ! -e $file ]] || printf '%s\0' "$file"; done |
      tar -c --null -T - | tar -x -C "$tree" &&
    cp -a tests/npm/node_modules "$tree/tests/npm/"
}
# A command in the tree there; whatever it starts ends with it.
inside() {
  cp -L /etc/resolv.conf "$root/etc/resolv.conf"
  unshare --mount --pid --fork --kill-child bash -c '
    root=$1 && shift
    mount -t proc proc "$root/proc" && mount --rbind /dev "$root/dev" && mount --rbind /sys "$root/sys" &&
      exec chroot "$root" /usr/bin/env -i -C /sightline HOME=/root LC_ALL=C.UTF-8 TERM=dumb \
        PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin "$@"' _ "$root" "$@"
}

stage "root of $release" make_root || finish
stage "copy of the tree" copy_tree || finish
for name in "${stages[@]}"; do stage "scripts/$name.sh" inside "scripts/$name.sh"; done
finish
