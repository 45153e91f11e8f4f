#!/bin/sh
# Opens explore.html and report.html of results in headless Chromium from file:, narrow and wide, light and dark, and uses
# them: brush, sort, CSV, keyboard, zoom, map. Fails on an error of the page, a request, or a page wider than the window.
#   Usage: sh scripts/explore-check.sh out/smoke ...
set -eu
check=$(dirname "$0")/explore_check.py
command -v python3 > /dev/null || { echo "explore-check: skipped, no python3"; exit 0; }
for browser in "${CHROMIUM:-}" chromium chromium-browser google-chrome; do
  [ -n "$browser" ] && command -v "$browser" > /dev/null && exec python3 "$check" "$browser" "$@"
done
echo "explore-check: skipped, no Chromium; install it, or name its program in CHROMIUM"
