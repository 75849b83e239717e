#!/usr/bin/env bash
# Makes the playground in a folder: the page, its scripts, the module, and models to begin with.
# Needs Node with npm, and a standard library for wasm32-unknown-unknown: that of the compiler
# that is used, which is taken from rustup if it is not there, or, where rustup has none, Debian's
# (amd64), which is made from its source by Debian's compiler, both unpacked under the target
# folder; nothing is installed. PROFILE names a cargo profile [release]; STD is `rustup` or
# `debian` where only that one shall be tried; STEREOTOMY_WEB a copy of crates/view/web in which
# npm has installed its packages.
set -euo pipefail
out=$(realpath -m "${1:?name a folder for the playground}")
here=$(cd "$(dirname "$0")" && pwd)
web=$here/../view/web
target=wasm32-unknown-unknown
profile=${PROFILE:-release}

cd "$here"
target_folder=$(cargo metadata --format-version 1 --no-deps |
    python3 -c 'import json, sys; print(json.load(sys.stdin)["target_directory"])')

# Debian's compiler, the source of its standard library, and what they need.
debian() {
    local root=$target_folder/debian-rust linker
    linker=$(find "$(rustc --print sysroot)/lib/rustlib" -name rust-lld | head -n 1)
    [ -n "$linker" ] || linker=$(command -v wasm-ld) || {
        echo "no linker for $target: install Debian's lld" >&2
        return 1
    }
    if [ ! -x "$root/usr/bin/rustc" ]; then
        rm -rf "$root"
        mkdir -p "$root/packages"
        (
            cd "$root/packages"
            apt-get download -qq rustc-web libstd-rust-web-dev rust-web-src
            # The library that the compiler is, and LLVM.
            for needs in libstd-rust-web-dev libstd-rust-web-1; do
                dpkg-deb -f "$needs"*.deb Depends | tr , '\n' | sed 's/(.*//; s/ //g' |
                    grep -E '^(libstd-rust-web-|libllvm)' | xargs apt-get download -qq
            done
        )
        for package in "$root"/packages/*.deb; do dpkg-deb -x "$package" "$root"; done
        rm -r "$root/packages"
    fi
    export LD_LIBRARY_PATH=$root/usr/lib/x86_64-linux-gnu
    export RUSTC=$root/usr/bin/rustc RUSTC_BOOTSTRAP=1
    export CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER=$linker
    export CARGO_TARGET_DIR=$target_folder/debian
    more=(-Z build-std=std,panic_abort)
    echo "standard library: that of Debian's $("$RUSTC" --version), from its source"
}

more=()
if [ "${STD:-}" = debian ]; then
    debian
elif [ -d "$(rustc --print sysroot)/lib/rustlib/$target" ]; then
    echo "standard library: that of $(rustc --version), installed"
elif command -v rustup >/dev/null && rustup target add "$target"; then
    echo "standard library: that of $(rustc --version), by rustup"
elif [ "${STD:-}" != rustup ] && command -v apt-get >/dev/null; then
    debian
else
    echo "no standard library for $target: install it for $(rustc --version)" >&2
    exit 1
fi
# Names and lines of functions would be four fifths of it.
cargo rustc "${more[@]}" -p playground --lib --crate-type cdylib --target "$target" --profile "$profile" -- -C strip=symbols
folder=$profile
if [ "$profile" = dev ]; then folder=debug; fi
module=${CARGO_TARGET_DIR:-$target_folder}/$target/$folder/playground.wasm

mkdir -p "$out/models"
cp "$module" "$out/"
cp "$web/page.html" "$out/index.html"
cp "$web/first.js" "$web/view.css" "$out/"
cp "$here"/../../models/*.csg "$out/models/"
(cd "$out/models" && printf '%s\n' *.csg | sed 's/\.csg$//' |
    python3 -c 'import json, sys; print(json.dumps(sys.stdin.read().split()))') >"$out/models.json"
tools=${STEREOTOMY_WEB:-$web}
[ -d "$tools/node_modules" ] || (cd "$tools" && npm ci --no-audit --no-fund --ignore-scripts --loglevel=error)
(cd "$tools" && node build.js "$out" playground)
ls -l "$out"
