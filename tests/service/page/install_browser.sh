#!/usr/bin/env bash
# The tests of the service's page look at it in Chromium. Installs one where none is and one can be had; says so
# otherwise, and lets those tests skip.
set -euo pipefail

python=${1:-python3}

present() {
  for name in chromium chromium-headless-shell google-chrome; do
    command -v "$name" >/dev/null && return
  done
  "$python" - <<'END'
import pathlib
from playwright.sync_api import sync_playwright
with sync_playwright() as playwright:
    raise SystemExit(not pathlib.Path(playwright.chromium.executable_path).exists())
END
}

if present; then
  exit 0
fi
if [ "$(id -u)" -eq 0 ] && command -v apt-get >/dev/null; then
  echo "installing chromium-headless-shell through apt-get"
  export DEBIAN_FRONTEND=noninteractive
  { apt-get update -qq && apt-get install -y -qq --no-install-recommends chromium-headless-shell; } >/dev/null || true
fi
if ! present; then
  echo "installing Chromium through playwright"
  timeout 300 "$python" -m playwright install chromium >/dev/null || true
fi
if ! present; then
  echo "expected a Chromium, found none: the tests of the service's page will be skipped." >&2
  echo "Install one (Debian: apt-get install chromium) to have them run." >&2
fi
