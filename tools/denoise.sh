#!/bin/sh
# Measures denoising against converged references, beside Intel's Open Image Denoise: prints the table of docs/measured/DENOISING.md.
#
#     cargo build --release && tools/denoise.sh > table.md
#
# PHOTONFARM is the program (target/release/photonfarm), SECONDS_LIST the times to render ("1 4 16"), PICTURES a folder that gets pictures to look at.
# Python packages go into a folder of their own, target/denoise-python. About 8 minutes.
set -eu
cd "$(dirname "$0")/.."
python=target/denoise-python
if [ ! -e "$python/is-complete" ]; then
    python3 -m venv "$python"
    "$python/bin/pip" install --quiet numpy OpenEXR pyoidn >&2
    touch "$python/is-complete"
fi
exec "$python/bin/python3" tools/denoise.py
