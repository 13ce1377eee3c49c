#!/usr/bin/env bash
# Builds sightline in a fresh root of a Debian release, which debootstrap makes:
#   scripts/debian.sh bookworm|trixie [demo|test|packages]...   (demo and test if not said)
# demo, test: README's two commands. packages: the packages of debian/, checked by lintian, then
# installed in a second fresh root, used there without a compiler, and removed; they stay in
# build/debian/RELEASE.packages. build/debian/RELEASE is kept with what it installed and built;
# delete it to begin anew. Packages come from where this machine's come from. Needs root,
# debootstrap, and for demo and test `npm ci --prefix tests/npm`.
set -uo pipefail
cd "$(dirname "$0")/.." || exit 1

release=${1:-}
case $release in
  bookworm | trixie) shift ;;
  *) echo "debian.sh: release = ${release:-missing}, expected bookworm or trixie" >&2; exit 2 ;;
esac
stages=("${@:-demo}")
(($# > 0)) || stages=(demo test)
for name in "${stages[@]}"; do
  case $name in
    demo | test | packages) ;;
    *) echo "debian.sh: argument = $name, expected demo, test or packages" >&2; exit 2 ;;
  esac
done
folder=$PWD/build/debian root=$PWD/build/debian/$release

. scripts/stages.sh

((EUID == 0)) || refuse "user = $(id -un), expected root, whom chroot is for"
command -v debootstrap >/dev/null || refuse "debootstrap is missing, expected Debian's package of that name"
[[ ${stages[*]} == packages || tests/npm/node_modules/.package-lock.json -nt tests/npm/package-lock.json ]] || npm ci --prefix tests/npm --no-audit --no-fund >&2 ||
  refuse "the libraries of tests are missing, expected npm ci --prefix tests/npm to pass"

# Where this machine has the packages of a suite from; nothing where it has none.
mirror() { apt-get indextargets --format '$(REPO_URI)' "Identifier: Packages" "Component: main" "Codename: $1" | head -n 1; }
# A root with nothing but the release's smallest system, $1.
make_root() {
  [[ -f $1/etc/apt/sources.list.d/own.list ]] && return
  local own main security
  own=$(. /etc/os-release && echo "$VERSION_CODENAME")
  main=$(mirror "$own") security=$(mirror "$own-security")
  [[ -n $main ]] || { echo "apt has no packages of $own, expected a mirror of Debian among its sources" >&2; return 1; }
  rm -rf "$1" && mkdir -p "$1" || return
  debootstrap --variant=minbase --include=ca-certificates "$release" "$1" "$main" >"$1.txt" || { tail -n 5 "$1.txt" >&2; return 1; }
  { [[ -z $security ]] || echo "deb $security $release-security main"; } >"$1/etc/apt/sources.list.d/own.list"
}
# The files that git knows, with their times, so that what did not change is not built again.
copy_tree() {
  local tree=$root/sightline
  mkdir -p "$tree" &&
    find "$tree" -mindepth 1 -maxdepth 1 ! -name build ! -name out -exec rm -rf {} + &&
    git ls-files -z --cached --others --exclude-standard |
      while IFS= read -rd '' file; do [[ ! -e $file ]] || printf '%s\0' "$file"; done |
      tar -c --null -T - | tar -x -C "$tree" &&
    { [[ ! -d tests/npm/node_modules ]] || cp -a tests/npm/node_modules "$tree/tests/npm/"; }
}
# A command in a folder of a root, $1 and $2; whatever it starts ends with it.
inside() {
  cp -L /etc/resolv.conf "$1/etc/resolv.conf"
  unshare --mount --pid --fork --kill-child bash -c '
    root=$1 folder=$2 && shift 2
    mount -t proc proc "$root/proc" && mount --rbind /dev "$root/dev" && mount --rbind /sys "$root/sys" &&
      exec chroot "$root" /usr/bin/env -i -C "$folder" HOME=/root LC_ALL=C.UTF-8 TERM=dumb DEBIAN_FRONTEND=noninteractive \
        PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin "$@"' _ "$@"
}

build_packages() {
  inside "$root" /sightline scripts/packages.sh build >"$root.build.txt" 2>&1 || { tail -n 20 "$root.build.txt" >&2; return 1; }
  tail -n 3 "$root.build.txt"
  rm -rf "$root.packages" && mkdir -p "$root.packages" && mv "$root"/*sightline*.deb "$root.packages"
}
# What a user does who has the packages alone.
use_packages() {
  local fresh=$root.fresh
  rm -rf "$fresh" && make_root "$fresh" && cp -r "$root.packages" "$fresh/packages" && cp scripts/packages.sh "$fresh/packages" &&
    inside "$fresh" /packages ./packages.sh use /packages
}

stage "root of $release" make_root "$root" || finish
stage "copy of the tree" copy_tree || finish
for name in "${stages[@]}"; do
  if [[ $name == packages ]]; then
    stage "packages of $release" build_packages && stage "use of the packages" use_packages
  else
    stage "scripts/$name.sh" inside "$root" /sightline "scripts/$name.sh"
  fi
done
finish
