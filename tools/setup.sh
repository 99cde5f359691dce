#!/bin/sh
# Installs from Debian what building needs and the machine lacks. Says what it installs; does nothing if all is there.
#
#   tools/setup.sh            what `make` needs
#   tools/setup.sh --check    also what the format and header checks need
set -eu

packages="gcc libc6-dev make cmake ninja-build pkgconf
    libembree-dev libopenexr-dev libnanovdb-dev libstb-dev libjansson-dev libexpat1-dev zlib1g-dev libzstd-dev libblosc-dev libcmocka-dev"
if [ "${1:-}" = "--check" ]; then
    packages="$packages g++ clang-format-14"
fi

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    echo "setup: not a Debian system; these must be there under whatever names they have:" $packages >&2
    exit 0
fi

missing=""
for package in $packages; do
    if ! dpkg-query -W -f '${db:Status-Status}\n' "$package" 2>/dev/null | grep -qx installed; then
        missing="$missing $package"
    fi
done
if [ -z "$missing" ]; then
    exit 0
fi

as_root=""
if [ "$(id -u)" -ne 0 ]; then
    as_root="sudo"
    if ! command -v sudo >/dev/null; then
        echo "setup: please install as root:$missing" >&2
        exit 1
    fi
fi
echo "setup: installing from Debian:$missing"
$as_root apt-get update -qq
$as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing >/dev/null
echo "setup: done"
