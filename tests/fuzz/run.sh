#!/bin/sh
# Fuzzes one loader: tests/fuzz/run.sh NAME SECONDS, NAME as in tests/fuzz/fuzz_NAME.c.
# Seeds: tests/fuzz/corpus/NAME, and the scenes of ../shared where they are. What is found stays in the build folder
# (build/fuzz, or $AIR_FUZZ_BUILD): new inputs in found/NAME, crashes beside them; nothing in the repository changes.
set -eu
if [ $# -ne 2 ]; then
    echo "usage: $0 NAME SECONDS" >&2
    exit 2
fi
name=$1
seconds=$2
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
build=${AIR_FUZZ_BUILD:-$root/build/fuzz}

cmake -S "$root" -B "$build" -G Ninja -DCMAKE_C_COMPILER=clang -DCMAKE_BUILD_TYPE=RelWithDebInfo -DAIR_FUZZ=ON >/dev/null
cmake --build "$build" --target "fuzz_$name" >&2

found=$build/found/$name
seeds=$build/seeds/$name
mkdir -p "$found" "$seeds"
cp "$here/corpus/$name"/* "$seeds"
case $name in
gltf | lightmap_gltf) endings='gltf glb' ;;
vol) endings='vol' ;;
nvdb) endings='nvdb' ;;
hdr) endings='hdr' ;;
image) endings='exr png ktx2' ;;
obj | ply | serialized) endings=$name ;;
mitsuba) endings='xml' ;;
*) endings='' ;;
esac
for ending in $endings; do
    # large files make slow runs: of them only the beginning
    find "$root/../shared/scenes" -name "*.$ending" 2>/dev/null | while read -r file; do
        head -c 65536 "$file" >"$seeds/$(echo "$file" | cksum | cut -d' ' -f1).$ending"
    done
done
chmod -R u+w "$seeds"

dictionary=
words=${name#lightmap_}
[ ! -f "$here/$words.dict" ] || dictionary="-dict=$here/$words.dict"

cd "$found"
# shellcheck disable=SC2086 # no dictionary is no argument
exec "$build/tests/fuzz/fuzz_$name" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=4000 -max_len=65536 \
    -print_final_stats=1 -artifact_prefix="$found-" $dictionary "$found" "$seeds"
