#!/usr/bin/env bash
# Makes the playground in a folder: the page, its scripts, the module, and models to begin with.
# Needs Node with npm, and the target wasm32-unknown-unknown of the compiler that is used, which
# is taken from rustup if it is not there. PROFILE names a cargo profile [release];
# STEREOTOMY_WEB a copy of crates/view/web in which npm has installed its packages.
set -euo pipefail
out=$(realpath -m "${1:?name a folder for the playground}")
here=$(cd "$(dirname "$0")" && pwd)
web=$here/../view/web
target=wasm32-unknown-unknown
profile=${PROFILE:-release}

cd "$here"
if [ -d "$(rustc --print sysroot)/lib/rustlib/$target" ]; then
    echo "standard library: that of $(rustc --version), installed"
elif command -v rustup >/dev/null; then
    echo "standard library: that of $(rustc --version), by rustup"
    rustup target add "$target"
else
    echo "no standard library for $target: install it for $(rustc --version)" >&2
    exit 1
fi
# Names and lines of functions would be four fifths of it.
cargo rustc -p playground --lib --crate-type cdylib --target "$target" --profile "$profile" -- -C strip=symbols
folder=$profile
if [ "$profile" = dev ]; then folder=debug; fi
target_folder=$(cargo metadata --format-version 1 --no-deps |
    python3 -c 'import json, sys; print(json.load(sys.stdin)["target_directory"])')

mkdir -p "$out/models"
cp "$target_folder/$target/$folder/playground.wasm" "$out/"
cp "$web/page.html" "$out/index.html"
cp "$web/view.css" "$out/"
cp "$here"/../../models/*.csg "$out/models/"
(cd "$out/models" && printf '%s\n' *.csg | sed 's/\.csg$//' |
    python3 -c 'import json, sys; print(json.dumps(sys.stdin.read().split()))') >"$out/models.json"
tools=${STEREOTOMY_WEB:-$web}
[ -d "$tools/node_modules" ] || (cd "$tools" && npm ci --no-audit --no-fund --ignore-scripts --loglevel=error)
(cd "$tools" && node build.js "$out" playground)
ls -l "$out"
