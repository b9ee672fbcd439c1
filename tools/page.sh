#!/usr/bin/env bash
# Tests the coordinator's page in a browser: Chromium by Playwright, against a coordinator and a worker of the given program.
# usage, in the project's root: tools/page.sh [--program PROGRAM] [--screenshots] [further options of pytest]
#        tools/page.sh [--program PROGRAM] --cost
# --screenshots also writes the pictures of docs/PAGE.md. --cost measures instead what an open page takes from a coordinator, in two minutes. Python packages go into a folder that is kept in the user's cache. Two minutes.
set -euo pipefail
program=target/release/photonfarm
options=() cost=
while [ $# -gt 0 ]; do
    case $1 in
    --program) program=$2 && shift 2 ;;
    --cost) cost=yes && shift ;;
    *) options+=("$1") && shift ;;
    esac
done
program=$(realpath "$program")
if ! command -v chromium >/dev/null; then
    apt-get update -qq && apt-get install -y -qq chromium >/dev/null
fi
python=${XDG_CACHE_HOME:-$HOME/.cache}/photonfarm-page-tests
[ -x "$python/bin/pytest" ] || python3 -m venv "$python"
"$python/bin/pip" install --quiet --disable-pip-version-check -r tools/page/requirements.txt
[ -z "$cost" ] || exec "$python/bin/python" tools/page/cost.py "$program"
exec "$python/bin/pytest" -q -p no:cacheprovider tools/page --program "$program" ${options[@]+"${options[@]}"}
