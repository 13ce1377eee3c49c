#!/usr/bin/env bash
# Installs the packages sightline needs on Debian 12 and 13:  scripts/deps.sh [demo|test|ci|arm64]   (ci if not said)
# arm64 adds to `test` a cross compiler, qemu-user and the libraries for AArch64; ci does without,
# and is of Debian 12.
set -euo pipefail

packages=(cmake esbuild g++ libboost-dev libcli11-dev libfmt-dev libjs-three liblz4-dev libsqlite3-dev libtomlplusplus-dev
  libzstd-dev ninja-build nlohmann-json3-dev pkg-config zlib1g-dev)
test_packages=(ca-certificates ccache chromium coinor-libipopt-dev cyclonedds-dev cyclonedds-tools doxygen
  file furo iproute2 libapriltag-dev libblas-dev libegl1-mesa-dev libeigen3-dev libfastcdr-dev libfastrtps-dev
  jq libgl1-mesa-dri libgmock-dev libgtest-dev libjs-katex liblapack-dev libmujoco-dev librsvg2-bin libssl-dev libtinyxml2-dev libyaml-cpp-dev openssl pandoc
  pybind11-dev python3-breathe python3-dev python3-ipykernel python3-matplotlib python3-myst-parser python3-nbclient
  python3-nbsphinx python3-numpy python3-pandas python3-pip python3-pytest python3-sphinx python3-venv qemu-user
  slurm-client slurmctld slurmd munge sqlite3 time)
arm64_packages=(g++-aarch64-linux-gnu qemu-user libboost-dev:arm64 libfmt-dev:arm64 libgmock-dev:arm64 libgtest-dev:arm64 liblz4-dev:arm64
  libsqlite3-dev:arm64 libtinyxml2-dev:arm64 libtomlplusplus-dev:arm64 libyaml-cpp-dev:arm64 libzstd-dev:arm64 zlib1g-dev:arm64)
ci_packages=(clang-14 clang-format-14 clang-tidy-14 g++-11 git libclang-rt-14-dev)

use=${1:-ci}
case $use in
  demo) ;;
  test) packages+=("${test_packages[@]}") ;;
  ci)
    release=$(. /etc/os-release && echo "${VERSION_CODENAME:-unknown}")
    if [[ $release != bookworm ]]; then
      echo "deps.sh: argument = ci on $release, expected bookworm, whose clang 14 the checks are written for; test is for both" >&2 && exit 2
    fi
    packages+=("${test_packages[@]}" "${ci_packages[@]}")
    ;;
  arm64) packages+=("${test_packages[@]}" "${arm64_packages[@]}") ;;
  *) echo "deps.sh: argument = $use, expected demo, test, ci or arm64" >&2 && exit 2 ;;
esac
if [[ $use != demo ]]; then
  # A node from elsewhere serves as well as Debian's.
  command -v node >/dev/null || packages+=(nodejs)
  command -v npm >/dev/null || packages+=(npm)
fi

missing=()
for package in "${packages[@]}"; do
  # Of a name without an architecture, this machine's.
  case $package in
    *:*) architectures=${package#*:} ;;
    *) architectures="all|$(dpkg --print-architecture)" ;;
  esac
  dpkg-query -W -f '${db:Status-Status} ${Architecture}\n' "$package" 2>/dev/null | grep -qE "^installed ($architectures)$" || missing+=("$package")
done
if ((${#missing[@]} == 0)); then
  echo "deps.sh: all ${#packages[@]} packages are there" >&2
  exit 0
fi

sudo=()
if ((EUID != 0)); then
  if ! command -v sudo >/dev/null; then
    echo "deps.sh: run as root, or install sudo, to add: ${missing[*]}" >&2
    exit 1
  fi
  sudo=(sudo)
fi
apt() { "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -o Dpkg::Use-Pty=0 "$@" </dev/null; }
install_missing() { apt update && apt install -y --no-install-recommends "${missing[@]}"; }

if [[ $use == arm64 ]]; then "${sudo[@]}" dpkg --add-architecture arm64; fi
echo "deps.sh: installing with apt-get: ${missing[*]}" >&2
# A mirror that answers badly once often answers well the second time.
install_missing >&2 || { echo "deps.sh: once more" >&2 && sleep 5 && install_missing >&2; }
