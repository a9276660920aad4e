#!/usr/bin/env bash
# Makes the pictures of docs/GUIDE.md anew, by the commands that it shows. Takes some seconds.
set -euo pipefail
cd "$(dirname "$0")/../.."
cargo build --release -p genx -p compute -p display
export PATH="${CARGO_TARGET_DIR:-$PWD/target}/release:$PATH"
pictures=$PWD/docs/guide
work=$(mktemp -d)
trap 'rm -r "$work"' EXIT
cd "$work"

cat >squares.obj <<'OBJ'
o lower
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
f 1 2 3 4
o upper
v 0 0 1
v 0 1 1
v 1 1 1
v 1 0 1
f 5 6 7 8
OBJ
run() {
    "$@" --backend cpu 2>&1
}

# 1. Two squares.
genx squares.rad squares.obj --max-area 0.02
run compute squares.rad squares.rad --view-factors squares.csv --target-error 0.1%
cut -d, -f1-3 squares.csv
# 2. A hemicube unfolded.
genx box.rad cornell --max-area 0.001
run compute box.rad solved.rad
display solved.rad --hemicube 300 --resolution 96 --out "$pictures/2-hemicube.png"
# 3. Multiplier maps.
display --maps --resolution 96 --out "$pictures/3-maps.png"
# 4. Bounces.
run compute box.rad bounces.rad --layers bounces
view=(--size 256x256)
display bounces.rad "${view[@]}" --mix "bounce 2=0,bounces 3 to 5=0,bounces from 6=0" --out "$pictures/4-one.png"
display bounces.rad "${view[@]}" --mix "bounces 3 to 5=0,bounces from 6=0" --out "$pictures/4-two.png"
display bounces.rad "${view[@]}" --out "$pictures/4-all.png"
# 5. A mesh too coarse.
genx coarse.rad cornell --max-area 0.02
run compute coarse.rad coarse-solved.rad --quality mesh
display coarse-solved.rad "${view[@]}" --out "$pictures/5-coarse.png"
display coarse-solved.rad "${view[@]}" --compare solved.rad --out "$pictures/5-difference.png"
# 6. The function between patches.
run compute coarse.rad function.rad
display function.rad "${view[@]}" --out "$pictures/6-function.png"
display function.rad "${view[@]}" --compare solved.rad --out "$pictures/6-difference.png"
# 7. Lamps.
genx hall.rad 2
run compute hall.rad hall.rad --layers lamps
hall=(--size 320x208)
display hall.rad "${hall[@]}" --out "$pictures/7-all.png"
display hall.rad "${hall[@]}" --mix "ceiling panels=0.05,back panel=0.3:0.6:1" --out "$pictures/7-evening.png"
# 8. A furnace.
genx furnace.rad furnace
run compute furnace.rad furnace.rad --quality mesh
display furnace.rad --by object
# 9. The thesis's maps.
run compute box.rad exact.rad 64 --quality mesh --points centroid --lamps off
run compute box.rad thesis.rad 64 --quality mesh --points centroid --lamps off --maps thesis
display thesis.rad "${view[@]}" --compare exact.rad --out "$pictures/9-difference.png"
# 10. Illuminance with contours.
display solved.rad --size 340x256 --quantity irradiance --luminous --mode false-color --contours 50,100,150 \
    --out "$pictures/10-lux.png"
