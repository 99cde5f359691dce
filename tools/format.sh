#!/bin/sh
# Formats all sources, or with --check only says which are not formatted. Other versions of clang-format differ.
set -eu
cd "$(dirname "$0")/.."

formatter=clang-format-14
if ! command -v "$formatter" >/dev/null; then
    echo "format: $formatter is not installed" >&2
    exit 1
fi
mode="-i"
if [ "${1:-}" = "--check" ]; then
    mode="--dry-run -Werror"
fi
find include src cli tests bench examples tools \( -name '*.c' -o -name '*.h' -o -name '*.cpp' \) -print0 |
    xargs -0 "$formatter" --style=file $mode
