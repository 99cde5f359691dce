#!/bin/sh
# Holds the layers: a file includes only its own room and lower ones.
#
#   core <- image, kernels <- scene, lightmap <- path <- render, bake <- cli
#
# Rooms of one rank do not include each other; cli sees include/airlight only; OpenMP and Embree stay in core.
set -eu
cd "$(dirname "$0")/.."

find include/airlight src cli \( -name '*.c' -o -name '*.h' \) -exec grep -HE '^[[:space:]]*#[[:space:]]*include' {} + | awk '
BEGIN {
    rank["core"] = 0
    rank["atlas"] = rank["image"] = rank["collimated"] = rank["arealight"] = rank["ordinates"] = rank["impulse"] = 1
    rank["scene"] = rank["lightmap"] = 2
    rank["path"] = 3
    rank["render"] = rank["bake"] = 4
}
function refuse(reason) {
    print file ": includes " target ": " reason
    bad = 1
}
{
    colon = index($0, ":")
    file = substr($0, 1, colon - 1)
    target = substr($0, colon + 1)
    sub(/^[^"<]*["<]/, "", target)
    sub(/[">].*/, "", target)
    system_header = $0 ~ /include[[:space:]]*</
    split(file, path, "/")
    split(target, part, "/")

    if (file ~ /(util|common|misc|helper)[a-z]*\.[ch]$/) refuse("no file is named so")
    if (system_header) {
        heavy = target == "omp.h" || target ~ /^embree[0-9]/
        if (heavy && !(path[1] == "src" && path[2] == "core")) refuse("OpenMP and Embree stay in core")
        next
    }
    if (part[1] == "airlight") next
    if (path[1] == "include") refuse("a public header includes public headers only")
    else if (path[1] == "cli") {
        if (target ~ /\//) refuse("cli sees include/airlight only")
    } else if (!(path[2] in rank)) refuse("room " path[2] " has no rank in tools/check_layers.sh")
    else if (!(part[1] in rank)) refuse("not a path from src/")
    else if (part[1] != path[2] && rank[part[1]] >= rank[path[2]]) refuse("not a lower room")
}
END { exit bad }'
