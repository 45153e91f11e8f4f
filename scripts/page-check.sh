#!/bin/sh
# Opens report.html of results in headless Chromium from file:, narrow and wide, light and dark, and uses it: brush, sort, CSV,
# keyboard, zoom, map; also printed and without scripts. Fails on an error of the page, a request, or a page wider than the window.
#   Usage: sh scripts/page-check.sh out/smoke ...
set -eu
check=$(dirname "$0")/page_check.py
command -v python3 > /dev/null || { echo "page-check: skipped, no python3"; exit 0; }
for browser in "${CHROMIUM:-}" chromium chromium-browser google-chrome; do
  [ -n "$browser" ] && command -v "$browser" > /dev/null && exec python3 "$check" "$browser" "$@"
done
echo "page-check: skipped, no Chromium; install it, or name its program in CHROMIUM"
