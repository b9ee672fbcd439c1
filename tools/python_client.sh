#!/usr/bin/env bash
# Installs the Python client into a fresh environment, checks its types, and tests it against real coordinators.
# usage: tools/python_client.sh --program PROGRAM [further options of pytest]
# PYTHON may name another interpreter. 75 to 110 s on two busy cores; the last line is pytest's.
set -euo pipefail
[ "${1:-}" = --program ] || { echo "say which photonfarm to test with: --program PROGRAM" >&2; exit 2; }
program=$(realpath "${2:?--program needs a path}")
shift 2
cd "$(dirname "$0")/../clients/python"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/python"
"$folder/python/bin/pip" install --quiet --disable-pip-version-check '.[check]'
"$folder/python/bin/mypy" --cache-dir "$folder/types"
# Without -m, so that this folder is not searched for the package.
"$folder/python/bin/pytest" -c pyproject.toml -p no:cacheprovider --program="$program" "$@" tests
