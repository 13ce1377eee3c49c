# shellcheck shell=bash
# Flights in the world "rotors" for sections of acceptance scripts, to be sourced after sections.sh.
sightline=${build:?}/bin/sightline

# cooperative_localization, or TEAM, with two vehicles. $1: preset, of the vehicles and of the
# hover_multirotor that plans them; $2: keys of each robot, one a line; further arguments: of sed
# -E, on the scenario.
rotor_team() {
  local preset=$1 keys=$2
  shift 2
  sed -E -e 's/^compare = .*//' -e "s/^robot = \"multirotor\".*/robot = \"hover_multirotor\"${keys:+\\n${keys//$'\n'/\\n}}/" \
    -e "s/^parameters = .*/parameters = { preset = \"$preset\" }/" "$@" "scenarios/${TEAM:-cooperative_localization}.toml"
  printf '\n[world]\nkind = "rotors"\n\n[agent.uav0.vehicle]\npreset = "%s"\n\n[agent.uav1.vehicle]\npreset = "%s"\n' "$preset" "$preset"
}

# Flies the scenario of standard input and leaves one line of figures, once. $1: file of the line;
# $2: function that says the line of a folder with results. A flight that ends early says so before
# its figures.
fly_once() {
  local scenario output line folder=${1%.txt} ended=''
  scenario=$(cat)
  [[ -s $1 ]] && return
  mkdir -p "$folder"
  echo "$scenario" >"$folder/flight.toml"
  if ! output=$("$sightline" run "$folder/flight.toml" -o "$folder" 2>&1 >/dev/null); then
    [[ $output == *" touched "* ]] && ended='ended '
    [[ -f $folder/summary.json ]] || { echo "$output" >&2; return 1; }
  fi
  if ! line=$("$2" "$folder") || [[ -z $line ]]; then
    echo "$folder: no figures" >&2
    return 1
  fi
  echo "$ended$line" >"$1.part" && mv "$1.part" "$1" && rm -rf "$folder"
}

# One line for a figure. $1: what it is; $2: value; $3: what is required, as "<= 0.02"; $4: unit;
# $5: "wanted" where it was never reached and a miss is no failure.
judge() {
  if awk -v a="$2" "BEGIN { exit !(a != \"\" && a $3) }"; then
    echo "$1: $2 $4, required $3: holds"
  elif [[ ${5:-} == wanted ]]; then
    echo "$1: $2 $4, required $3: missed"
  else
    echo "$1: $2 $4, required $3: FAILS"
    return 1
  fi
}

# Greatest number of a column of such lines, to four digits.  $1: column; files.
worst() { sed 's/^ended //' "${@:2}" | awk -v c="$1" 'NR == 1 || $c > w { w = $c + 0 } END { if (NR) printf "%.4f", w }'; }
