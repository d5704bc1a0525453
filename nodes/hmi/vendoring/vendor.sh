#!/usr/bin/env bash
# Bundle three.js and uPlot for the page, which loads nothing from elsewhere.
#
# The lock file beside this script pins each package by version and SHA-512; tests/nodes/hmi checks
# the result against page/vendored/SHA256SUMS. Needed only to change a version: the bundles are kept
# in the repository. Run: nodes/hmi/vendoring/vendor.sh
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
out=$here/../page/vendored
build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT

cp "$here"/{package.json,package-lock.json,three-parts.js} "$build"
cd "$build"
npm ci --ignore-scripts --no-audit --no-fund
bundle() { npx --no-install esbuild "$1" --bundle --minify --format=esm --target=es2022 \
    --legal-comments=inline --outfile="$2"; }
bundle three-parts.js "$out/three.js"
bundle node_modules/uplot/dist/uPlot.esm.js "$out/uplot.js"
cp node_modules/uplot/dist/uPlot.min.css "$out/uplot.css"
cp node_modules/three/LICENSE "$out/three.LICENSE"
cp node_modules/uplot/LICENSE "$out/uplot.LICENSE"
cd "$out"
sha256sum three.js three.LICENSE uplot.js uplot.css uplot.LICENSE > SHA256SUMS
