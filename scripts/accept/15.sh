#!/usr/bin/env bash
# The figures of the Python module and of the page, section by section:  scripts/accept/15.sh [--short] [SECTION ...]
# What is finished stays in out/accept/15/ and is not done again; delete it to begin anew. Needs the
# release preset.
# --short is for CI: less of each, by wider limits.
set -uo pipefail
cd "$(dirname "$0")/../.." || exit 1
build=build/release
. scripts/accept/sections.sh
python=$(sed -n 's/^Python_EXECUTABLE:[A-Z]*=//p' $build/CMakeCache.txt)

figure() {
  local -a options=()
  whole || options=(--short)
  PYTHONPATH=$build/python "$python" -B bench/python_figures.py "$1" "${options[@]}"
}
page() {
  local -a options=()
  whole || options=(--short)
  CHROMIUM=${CHROMIUM:-/usr/bin/chromium} "$python" -B bench/page_figures.py "$1" $build/bin/sightline "${options[@]}"
}
# Pictures a second in headless Chromium, of logs and of a flight in real time. A log that is still
# written, and one that was killed.
frames() { page frames; }
growing() { page growing; }
# What an update costs from Python; eight threads; a potential in Python and as text; memory.
solve() { figure solve; }
threads() { figure threads; }
formula() { figure formula; }
cycles() { figure cycles; }
# Ten clients of the page and of Foxglove's protocol, one of which reads nothing, beside a flight
# without a server.
clients() { python3 bench/client_figures.py $(whole || echo --short); }

# A flight that is tuned: changed within 0.2 s, no input steps, written and replayed to the same
# commands; refused, and bounded. In a browser.
tune() {
  tests server_test 'Tuner.*:Tuning.*' && tests cli_test 'View.*Tun*' && tests record_test 'TunedLog.*' || return 1
  if [[ -x $build/tests/viewer_test ]]; then tests viewer_test 'Page.AFlightIsTunedInTheBrowser'; fi
}

all=(frames growing solve threads formula cycles clients tune)
run_sections "$@"
