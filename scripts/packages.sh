#!/usr/bin/env bash
# Debian packages of sightline, on the Debian 12 or 13 that it runs on, as root:
#   scripts/packages.sh build          builds them from this tree into its parent folder, and checks them by lintian
#   scripts/packages.sh use FOLDER     installs those of FOLDER, flies, opens the page, imports the module, and removes them
# scripts/debian.sh RELEASE packages does so in fresh roots, the Dockerfile in fresh images.
set -euo pipefail

build() {
  cd "$(dirname "$0")/.."
  apt-get -q update
  apt-get -qy install --no-install-recommends dpkg-dev lintian
  apt-get -qy build-dep --no-install-recommends ./
  rm -f ../sightline_*.changes
  dpkg-buildpackage -b -us -uc
  lintian --allow-root --fail-on error,warning ../sightline_*.changes
}

use() {
  local folder begin=$SECONDS page left work
  folder=$(realpath "$1")
  work=$(mktemp -d)
  apt-get -q update >/dev/null
  # shellcheck disable=SC2046
  apt-get -qy install --no-install-recommends $(ls "$folder"/*.deb | grep -v dbgsym) >"$work/install.txt"
  echo "installed in $((SECONDS - begin)) s: $(dpkg-query -W -f '${Package} ' '*sightline*')"
  if command -v c++ >/dev/null; then echo "packages.sh: there is a compiler, expected a system without" >&2; return 1; fi
  local share=/usr/share/sightline
  sightline run $share/scenarios/cooperative_localization.toml -o "$work/flight"
  sightline run $share/scenarios/rotors/cooperative_localization.toml --set 'world.kind="mujoco"' -o "$work/mujoco" | head -n 1
  sightline doctor --help | head -n 1
  python3 -c "import sightline as sl; print('python', sl.__version__, str(sl.check(sl.Scenario.read('$share/scenarios/paper_7_2.toml'))).splitlines()[0])"
  sightline view "$work/flight" --port 0 >"$work/view.txt" 2>&1 &
  local server=$!
  for _ in {1..50}; do
    page=$(grep -o 'http://[^ ]*' "$work/view.txt" | head -n 1) && break
    sleep 0.1
  done
  python3 -c "import sys, urllib.request as u; print('page', u.urlopen(sys.argv[1]).status, len(u.urlopen(sys.argv[1]).read()))" "$page"
  kill "$server"
  echo "installed and used in $((SECONDS - begin)) s"
  apt-get -qy purge '*sightline*' >/dev/null
  left=$(find /usr /etc -xdev -path '*sightline*' || true)
  [[ -z $left ]] || { echo "packages.sh: left behind: $left" >&2; return 1; }
}

case ${1:-} in
  build) build ;;
  use) [[ -d ${2:-} ]] || { echo "packages.sh: folder = ${2:-missing}, expected one with packages" >&2; exit 2; } && use "$2" ;;
  *) echo "packages.sh: argument = ${1:-missing}, expected build or use" >&2; exit 2 ;;
esac
