#!/usr/bin/env bash
# Flies 300 encirclements by 2 to 6 pursuers and 2000 flights among strangers that turn at will,
# with the table of docs/safety.md ("Measured"). About a minute.
#   scripts/accept/encirclements.sh [PRESET]     # release, whose safety_campaign_test is built
set -euo pipefail
cd "$(dirname "$0")/../.."
SIGHTLINE_CAMPAIGN=whole "build/${1:-release}/tests/safety_campaign_test" --gtest_filter='EncirclementCampaign.*'
