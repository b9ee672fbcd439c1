#!/usr/bin/env bash
# What dependencies are: licences, sources and, where the database of advisories can be reached, known weaknesses. deny.toml says what may be.
# Installs cargo-deny where it is not there, which takes two minutes of processor time. usage, in the project's root: tools/check_dependencies.sh
set -euo pipefail
if ! cargo deny --version >/dev/null 2>&1; then
    cargo install --quiet --debug --locked --root target/tools cargo-deny
    PATH=$PWD/target/tools/bin:$PATH
fi
cargo deny check licenses bans sources
if timeout 20 git ls-remote --quiet https://github.com/RustSec/advisory-db HEAD >/dev/null 2>&1; then
    cargo deny check advisories
else
    echo "advisories were not checked: their database cannot be reached from here" >&2
fi
