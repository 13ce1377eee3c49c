#!/usr/bin/env bash
# Flies fleets/desk.toml on real PX4 firmware in its own simulation (SIH), on this machine, and
# replays each flight:
#   scripts/px4_lab.sh PX4_BUILD AGENT [FLIGHTS] [sightline fly's options]
# PX4_BUILD: build folder of `make px4_sitl_default`, 1.16. AGENT: the program MicroXRCEAgent, 2.4.
# FLIGHTS: 3 without a number; the vehicles start anew before the first alone. Results are in
# out/px4_lab/. Exit code 1 if a flight is lost, or its replay differs. SIGHTLINE_BINARY: another
# program than that of the release preset. The flights plan with the delay that `sightline identify`
# finds for models without lags (lumped): without it the heading swings at 0.65 Hz.
set -uo pipefail
cd "$(dirname "$0")/.." || exit 1

refuse() { echo "px4_lab.sh: $*" >&2; exit 2; }
(($# >= 2)) || refuse "expected PX4_BUILD AGENT [FLIGHTS] [options]"
px4=$1 agent=$2
shift 2
flights=3
if [[ ${1:-} =~ ^[0-9]+$ ]]; then flights=$1; shift; fi
sightline=${SIGHTLINE_BINARY:-build/release/bin/sightline}
[[ -x $px4/bin/px4 ]] || refuse "PX4_BUILD = $px4, expected a build folder with bin/px4"
[[ -x $(command -v "$agent") ]] || refuse "AGENT = $agent, expected the program MicroXRCEAgent"
[[ -x $sightline ]] || refuse "$sightline is missing, expected a build of the release preset"
px4=$(realpath "$px4") agent=$(realpath "$(command -v "$agent")")
for tool in jq setsid; do command -v "$tool" >/dev/null || refuse "$tool is missing"; done

out=$PWD/out/px4_lab
rm -rf "$out"
mkdir -p "$out"
pids=()
# shellcheck disable=SC2317  # called by trap
finish() { ((${#pids[@]} == 0)) || kill "${pids[@]}" 2>/dev/null; }
trap finish EXIT

# Parameters by the environment hold for this run alone: the folders are new.
export ROS_DOMAIN_ID=77 PX4_SYS_AUTOSTART=10040 PX4_SIM_MODEL=sihsim_quadx PX4_SIMULATOR=sihsim
export PX4_PARAM_UXRCE_DDS_PTCFG=1 PX4_PARAM_MIS_TAKEOFF_ALT=1.0 PX4_PARAM_NAV_DLL_ACT=0 PX4_PARAM_COM_RCL_EXCEPT=4
export PX4_PARAM_COM_OBL_RC_ACT=4 PX4_PARAM_SDLOG_MODE=-1 PX4_HOME_LAT=47.4 PX4_HOME_ALT=489.4
setsid "$agent" udp4 -p 8888 >"$out/agent.txt" 2>&1 </dev/null &
pids+=($!)
# 1.7 m apart to the east, as in the file: 1.7 / (111319 cos(47.4 deg)) of a degree.
for vehicle in "1 8.5" "2 8.5000226"; do
  read -r instance longitude <<<"$vehicle"
  mkdir "$out/px4_$instance"
  (cd "$out/px4_$instance" && PX4_HOME_LON=$longitude exec setsid "$px4/bin/px4" -i "$instance" -d "$px4/etc" -w "$PWD" \
    >"$out/px4_$instance.txt" 2>&1 </dev/null) &
  pids+=($!)
done
echo "waits 30 s for the estimators"
sleep 30
"$sightline" doctor fleets/desk.toml >"$out/doctor.txt" 2>&1
(($? < 2)) || refuse "$(tail -n 1 "$out/doctor.txt")"
grep ' red ' "$out/doctor.txt"

delays=(--set agent.uav0.command_delay=0.185 --set agent.uav1.command_delay=0.185)
lost=0
for ((k = 1; k <= flights; k++)); do
  folder=$out/flight_$k
  "$sightline" fly fleets/desk.toml "${delays[@]}" -o "$folder" "$@" >"$folder.txt" 2>&1 </dev/null
  code=$?
  replay=$("$sightline" replay "$folder" 2>&1 | tail -n 1)
  [[ $code == 0 && $replay == *", 0 differ" ]] || lost=$((lost + 1))
  row=$(jq -r 'def mm: . * 1000 | round / 1000; "distance \(.pairs[0].distance.min | mm) to \(.pairs[0].distance.max | mm) m, " +
    "angle at most \(.pairs[0].view_angle_max | mm) rad, error of uav1 \(.agents[1].rms_position_error | mm) m"' \
    "$folder/summary.json" 2>/dev/null)
  echo "flight $k: exit $code, ${row:-no summary}; replay: $replay"
done
echo "$((flights - lost)) passed, $lost failed"
((lost == 0))
