#!/usr/bin/env bash
# The tests' outside opinion on pictures, pyrender, draws through libEGL and libGL. Installs them where they are missing
# and can be had; says what is missing otherwise, and lets the tests skip that comparison.
set -euo pipefail

python=${1:-python3}

present() {
  "$python" -c 'import ctypes; [ctypes.CDLL(name) for name in ("libEGL.so.1", "libGL.so.1")]' 2>/dev/null
}

if present; then
  exit 0
fi
if [ "$(id -u)" -eq 0 ] && command -v apt-get >/dev/null; then
  echo "installing libegl1 and libgl1 through apt-get"
  export DEBIAN_FRONTEND=noninteractive
  { apt-get update -qq && apt-get install -y -qq --no-install-recommends libegl1 libgl1; } >/dev/null || true
fi
if ! present; then
  echo "expected libEGL.so.1 and libGL.so.1, found neither or one: the comparison with OpenGL will be skipped." >&2
  echo "Install them (Debian: apt-get install libegl1 libgl1) to have it run." >&2
fi
