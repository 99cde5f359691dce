#!/bin/sh
# Each public header compiles alone, as C99 and as C++11, without a warning.
set -eu
cd "$(dirname "$0")/.."

warnings="-Wall -Wextra -Wpedantic -Wshadow -Werror -fsyntax-only -Iinclude"
failed=0
for header in include/airlight/*.h; do
    line="#include \"airlight/$(basename "$header")\""
    echo "$line" | "${CC:-cc}" -std=c99 $warnings -x c - || failed=1
    echo "$line" | "${CXX:-c++}" -std=c++11 $warnings -x c++ - || failed=1
done
exit $failed
