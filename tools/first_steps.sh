#!/usr/bin/env bash
# Times what people do first, in a fresh clone of what is committed here: from nothing to a picture, from a Python prompt to an array, from a file
# that is dropped on the page to its picture. Prints the table of docs/measured/FIRST-STEPS.md. Ten minutes, most of them the first build.
# usage, in the project's root, once tools/page.sh has set its browser up: tools/first_steps.sh
set -euo pipefail
source=$(cd "$(dirname "$0")/.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# Runs a command and says how many seconds it took.
seconds() {
    local began
    began=$(date +%s.%N)
    "$@" >&2
    awk -v began="$began" -v ended="$(date +%s.%N)" 'BEGIN { printf "%.1f", ended - began }'
}

printf '| step | command | s |\n|---|---|---:|\n'
row() {
    printf '| %s | %s | %s |\n' "$@"
}
row clone '`git clone`' "$(seconds git clone --quiet "$source" "$folder/photonfarm")"
cd "$folder/photonfarm"
row 'first build' '`cargo build --release`' "$(seconds cargo build --release --locked --quiet)"
row 'a first look' '`cargo run --release -- render scenes/cornell-glass-mirror/scene.xml --workers 2 --passes 16`' \
    "$(seconds cargo run --release --locked --quiet -- render scenes/cornell-glass-mirror/scene.xml --workers 2 --passes 16)"
export PATH=$PWD/target/release:$PATH
install_client() {
    python3 -m venv "$folder/python"
    "$folder/python/bin/pip" install --quiet --disable-pip-version-check ./clients/python
}
row 'Python: the client' '`python3 -m venv`, `pip install ./clients/python`' "$(seconds install_client)"
# The first program of the client's README, as it stands there.
sed -n '/^```python$/,/^```$/p' clients/python/README.md | sed -n '2,/^```$/p' | sed '$d' >"$folder/first.py"
row 'Python: an array' 'the first program of [clients/python](../../clients/python/README.md): a farm, 32 passes, three files' \
    "$(seconds "$folder/python/bin/python" "$folder/first.py")"
page=${XDG_CACHE_HOME:-$HOME/.cache}/photonfarm-page-tests/bin/python
row 'page: a dropped file' 'a scene is dropped, *Submit* pressed, and the first pass seen' "$("$page" tools/page/first_picture.py target/release/photonfarm)"
