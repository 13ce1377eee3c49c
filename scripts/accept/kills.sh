#!/usr/bin/env bash
# Kills 20 flights, 20 flights that begin in the folder of another, and a campaign up to 20 times,
# at random moments. Looks for all that docs/design.md ("Files") and docs/campaign.md ("Stopping and
# resuming") promise. 3 min.
#   scripts/accept/kills.sh [PRESET]     # release, whose cli_campaign_test is built
set -euo pipefail
cd "$(dirname "$0")/../.."
SIGHTLINE_CAMPAIGN=whole "build/${1:-release}/tests/cli_campaign_test" --gtest_filter='Killed.*'
