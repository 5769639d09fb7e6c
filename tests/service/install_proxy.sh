#!/usr/bin/env bash
# The tests of compose.yaml put its proxy, nginx, before two services. Installs one where none is and one can be had;
# says so otherwise, and lets those tests skip.
set -euo pipefail

present() {
  PATH="$PATH:/usr/sbin" command -v nginx >/dev/null
}

if present; then
  exit 0
fi
if [ "$(id -u)" -eq 0 ] && command -v apt-get >/dev/null; then
  echo "installing nginx-light through apt-get"
  export DEBIAN_FRONTEND=noninteractive
  { apt-get update -qq && apt-get install -y -qq --no-install-recommends nginx-light; } >/dev/null || true
fi
if ! present; then
  echo "expected nginx, found none: the test of compose.yaml's proxy will be skipped." >&2
  echo "Install it (Debian: apt-get install nginx-light) to have it run." >&2
fi
