#!/usr/bin/env bash
# Keys of a fleet for DDS security:  scripts/dds_keys.sh [--days N] [--only TOPIC]... FOLDER [NAME ...]
# FOLDER gets an authority (public/, private/) and of each NAME, by default flyer and vehicles, a
# folder with the six files that SROS 2 has in an enclave, good for N days (365). An authority that
# is there already is used again: a name can be added later; names that are there are refused.
# Nobody but the authority needs private/: keep it elsewhere.
# flyer may not write what robots write (PX4's fmu/out), vehicles not what flyers write (fmu/in),
# any other NAME may listen alone; with
# --only, NAME writes nothing but these topics, as on the wire: rt/cf1/odom, with * for anything.
set -euo pipefail

usage() { echo "dds_keys.sh: $1, expected [--days N] [--only TOPIC]... FOLDER [NAME ...]" >&2; exit 2; }
days=365 only=()
while [[ ${1:-} == --* ]]; do
  case $1 in
    --days) [[ ${2:-} =~ ^-?[0-9]{1,5}$ ]] || usage "--days = ${2:-}"; days=$2 ;;
    --only) [[ ${2:-} =~ ^[A-Za-z0-9_/*]+$ ]] || usage "--only = ${2:-}"; only+=("$2") ;;
    *) usage "option $1" ;;
  esac
  shift 2
done
[[ -n ${1:-} ]] || usage "no FOLDER"
folder=$1
shift
names=("$@")
((${#names[@]} > 0)) || names=(flyer vehicles)
for name in "${names[@]}"; do
  [[ $name =~ ^[A-Za-z0-9_]+$ && $name != public && $name != private ]] || usage "NAME = $name"
  [[ ! -e $folder/$name ]] || { echo "dds_keys.sh: $folder/$name is there already: remove it to make it anew" >&2; exit 2; }
done
command -v openssl >/dev/null || { echo "dds_keys.sh: openssl is missing: apt-get install openssl" >&2; exit 2; }

umask 077
mkdir -p "$folder"/{public,private}
cd "$folder"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
quiet() { "$@" 2>"$work/said" || { cat "$work/said" >&2; exit 1; }; }
new_key() { quiet openssl ecparam -name prime256v1 -genkey -noout -out "$1"; }
# Signs the document $1 for all who have the authority's certificate.
sign() { quiet openssl smime -sign -in "$1" -text -out "$2" -signer public/ca.cert.pem -inkey private/ca.key.pem; }
head='<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901'
domains='<domains><id_range><min>0</min><max>230</max></id_range></domains>'

if [[ ! -e public/ca.cert.pem ]]; then
  new_key private/ca.key.pem
  quiet openssl req -new -x509 -days 3650 -key private/ca.key.pem -subj "/CN=authority of a sightline fleet" -out public/ca.cert.pem
  # As SROS 2 has it: who is not of the fleet is not spoken to, and all that is said is encrypted.
  cat >"$work/governance.xml" <<XML
$head/omg_shared_ca_governance.xsd">
<domain_access_rules><domain_rule>
  $domains
  <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
  <enable_join_access_control>true</enable_join_access_control>
  <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
  <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
  <rtps_protection_kind>SIGN</rtps_protection_kind>
  <topic_access_rules><topic_rule>
    <topic_expression>*</topic_expression>
    <enable_discovery_protection>true</enable_discovery_protection>
    <enable_liveliness_protection>true</enable_liveliness_protection>
    <enable_read_access_control>true</enable_read_access_control>
    <enable_write_access_control>true</enable_write_access_control>
    <metadata_protection_kind>ENCRYPT</metadata_protection_kind>
    <data_protection_kind>ENCRYPT</data_protection_kind>
  </topic_rule></topic_access_rules>
</domain_rule></domain_access_rules>
</dds>
XML
  sign "$work/governance.xml" public/governance.p7s
fi

# Of certificates and permissions: for clocks that are behind, from yesterday on. OpenSSL before 3.4
# has no way to say so.
begin=$((days > 0 ? -1 : days - 1))
validity=(-days "$days")
if openssl x509 -help 2>&1 | grep -q -- -not_before; then
  validity=(-not_before "$(date -u -d "$begin days" +%Y%m%d%H%M%SZ)" -not_after "$(date -u -d "$days days" +%Y%m%d%H%M%SZ)")
fi

# $1: publish or subscribe; the rest: topics.
topics() {
  local kind=$1 topic
  shift
  echo "  <$kind><topics>"
  for topic in "$@"; do echo "    <topic>$topic</topic>"; done
  echo "  </topics></$kind>"
}
# What every node of ROS 2 writes besides.
of_every_node=(ros_discovery_info rt/rosout rt/parameter_events)
# The rules of the name $1; the first that fits counts, and Cyclone DDS lets a topic be named by
# either.
rules() {
  local -a may=('*')
  echo " <allow_rule>$domains$(topics subscribe '*')</allow_rule>"
  if ((${#only[@]} > 0)); then
    may=("${only[@]}" "${of_every_node[@]}")
  else
    case $1 in
      flyer) echo " <deny_rule>$domains$(topics publish 'rt/*fmu/out/*')</deny_rule>" ;;
      vehicles) echo " <deny_rule>$domains$(topics publish 'rt/*fmu/in/*')</deny_rule>" ;;
      *) may=("${of_every_node[@]}") ;;
    esac
  fi
  echo " <allow_rule>$domains$(topics publish "${may[@]}")</allow_rule>"
}

for name in "${names[@]}"; do
  made=$work/$name
  mkdir "$made"
  new_key "$made/key.pem"
  quiet openssl req -new -key "$made/key.pem" -subj "/CN=$name" -out "$work/request"
  quiet openssl x509 -req "${validity[@]}" -in "$work/request" -CA public/ca.cert.pem -CAkey private/ca.key.pem \
    -set_serial "0x$(openssl rand -hex 16)" -out "$made/cert.pem"
  cat >"$work/permissions.xml" <<XML
$head/omg_shared_ca_permissions.xsd">
<permissions><grant name="$name">
 <subject_name>CN=$name</subject_name>
 <validity><not_before>$(date -u -d "$begin days" +%FT%TZ)</not_before><not_after>$(date -u -d "$days days" +%FT%TZ)</not_after></validity>
$(rules "$name")
 <default>DENY</default>
</grant></permissions>
</dds>
XML
  sign "$work/permissions.xml" "$made/permissions.p7s"
  for authority in identity_ca permissions_ca; do cp public/ca.cert.pem "$made/$authority.cert.pem"; done
  cp public/governance.p7s "$made"
  mv "$made" "$name"
done
echo "dds_keys.sh: $folder has keys of ${names[*]} for $days days; private/ is the authority's alone" >&2
