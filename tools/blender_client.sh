#!/usr/bin/env bash
# Tests the Blender add-on in Blender itself, which comes from PyPI as the module bpy (400 MB), against a real coordinator.
# usage: tools/blender_client.sh --program PROGRAM [further options of pytest]
# PYTHON has to name a Python for which bpy 5.0 or later has a wheel, for example 3.11 for 5.0. About a minute; the last line is pytest's.
set -euo pipefail
[ "${1:-}" = --program ] || { echo "say which photonfarm to test with: --program PROGRAM" >&2; exit 2; }
program=$(realpath "${2:?--program needs a path}")
shift 2
cd "$(dirname "$0")/../clients/blender"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/python"
"$folder/python/bin/pip" install --quiet --disable-pip-version-check 'bpy>=5.0' 'pytest>=9,<10' ../python
PYTHONDONTWRITEBYTECODE=1 "$folder/python/bin/pytest" -q -p no:cacheprovider --rootdir . --program="$program" "$@" tests
