#!/usr/bin/env bash
# Makes the charts and tables of docs/measured/SPEED-AND-ACCURACY.md: every method on every reference and on four scenes of our own, with
# Mitsuba's path tracer beside it. About an hour and a half of one core; stopped, it goes on where it was.
#
#   tools/speed_and_accuracy.sh FOLDER [MITSUBA_PYTHON]
#
# FOLDER keeps the results; MITSUBA_PYTHON is a Python with Mitsuba 3 (see tools/mitsuba_curve.py); without it that curve is left out.
set -euo pipefail
folder=$1
python=${2:-}
cd "$(dirname "$0")/.."
cargo build --release --quiet
photonfarm=target/release/photonfarm
own="gallery kitchen-counter rooms scene6"
budgets=1,4,16

# References of our own scenes: bdpt is unbiased and finds all their light. 330 seconds of one core leave relMSE around 0.002; the layer
# `error` says how much, and it is subtracted.
for scene in $own; do
    place=$folder/own/$scene
    if [ ! -e "$place/ref.exr" ]; then
        mkdir -p "$place"
        cp -r "scenes/$scene/." "$place"
        $photonfarm render "$place/scene.xml" -D size=128 --method bdpt --seconds 330 --threads 1 --seed 99 --layers error \
            -o "$place/ref.exr"
    fi
done
$photonfarm evaluate tests/references/*/ --seconds $budgets --seeds 1 -o "$folder/results.jsonl" --pictures
$photonfarm evaluate $(printf "$folder/own/%s " $own) -D size=128 --seconds $budgets --seeds 1 -o "$folder/own.jsonl" --pictures
peers=()
if [ -n "$python" ]; then
    # Mitsuba 3.9.1 does not get past loading textured-env in this variant.
    "$python" tools/mitsuba_curve.py $(ls -d tests/references/*/ | grep -v textured-env) --variant llvm_ad_rgb --seconds $budgets --seeds 1 -o "$folder/mitsuba.json"
    peers=(--peers "$folder/mitsuba.json")
fi
pictures=docs/measured/pictures/speed-and-accuracy
mkdir -p $pictures
$photonfarm chart "$folder/results.jsonl" "${peers[@]}" -o $pictures/references.png
$photonfarm chart "$folder/results.jsonl" "${peers[@]}" --kind time -o $pictures/time.png
$photonfarm chart "$folder/results.jsonl" --kind best -o $pictures/best.png
$photonfarm chart "$folder/own.jsonl" -o $pictures/own.png
$photonfarm chart "$folder/own.jsonl" --kind best -o $pictures/own-best.png
$photonfarm chart "$folder/results.jsonl" "${peers[@]}" -o "$folder/report.html"
python3 tools/regret.py "$photonfarm" "$folder/results.jsonl" tests/references > "$folder/regret.md"
python3 tools/regret.py "$photonfarm" "$folder/own.jsonl" "$folder/own" -D size=128 >> "$folder/regret.md"
