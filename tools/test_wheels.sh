#!/usr/bin/env bash
# The wheel and the sdist in clean environments, one for each Python given: tools/test_wheels.sh [--of DIST] [PYTHON …]
# It builds them, unless a folder says where they are.
# Without arguments: python3.11 … python3.14. What is not there comes from Debian's next release, into a folder of
# its own, if this is root and `debootstrap` is installed. Needs PyPI, hatchling in .venv, and
# what tools/firmware_release.sh needs: the wheel carries the firmware.
set -euo pipefail
cd "$(dirname "$0")/.."
place=$(mktemp -d)
trap 'rm -rf --one-file-system "$place"' EXIT

if [ "${1:-}" = --of ]; then
  mkdir "$place/dist"
  cp "$2"/*.whl "$2"/*.tar.gz "$place/dist"
  shift 2
else
  tools/firmware_release.sh >/dev/null
  .venv/bin/python -m hatchling build --directory "$place/dist" >/dev/null 2>&1
fi
cp -r examples/clean "$place/clean"

# try NAME PYTHON FOLDER [chroot ROOT]: both packages of a folder, which the Python sees under this name.
try() {
  local name=$1 python=$2 folder=$3
  shift 3
  for package in "$place"/dist/*; do
    "$@" /bin/sh -ec '
      cd "$1"
      "$2" -m venv --clear env
      env/bin/pip install -qq --disable-pip-version-check "dist/$3"
      env/bin/wheelhop --help >/dev/null
      env/bin/python -c "from wheelhop.logger.flash import PACKAGED, check_hex
for name in (\"nano\", \"mega\"): check_hex(PACKAGED / f\"wheelhop-logger-{name}.hex\")"
      env/bin/wheelhop simulate clean/vehicle.toml --tracks washboard/low --speed 8 --out run.parquet >/dev/null
      env/bin/wheelhop compare clean --json result.json >/dev/null
      rm run.parquet result.json
    ' sh "$folder" "$python" "${package##*/}" 2>"$place/said" ||
      { cat "$place/said"; echo "$name, ${package##*/}: fails"; exit 1; }
    echo "$name, ${package##*/}: installs, simulates, compares"
  done
}

# from_debian VERSION: the same with a Python of Debian's next release, beside this system.
from_debian() {
  local root="$place/debian"
  debootstrap --variant=minbase --include="python$1,python$1-venv" forky "$root" http://deb.debian.org/debian sid \
    >"$place/said" 2>&1 || { tail -3 "$place/said"; echo "python$1: Debian does not give it"; return; }
  cp /etc/resolv.conf "$root/etc/"
  mkdir -p "$root/etc/ssl/certs" "$root/tmp/wheels"
  cp -L /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs/"
  cp -r "$place/dist" "$place/clean" "$root/tmp/wheels/"
  try "Python $1 of Debian" "python$1" /tmp/wheels chroot "$root"
  rm -rf --one-file-system "$root"
}

if [ $# -gt 0 ]; then
  for python in "$@"; do try "$("$python" --version)" "$(command -v "$python")" "$place"; done
  exit
fi
for version in 3.11 3.12 3.13 3.14; do
  there=
  for found in "$(command -v python$version || true)" "${PYENV_ROOT:-$HOME/.pyenv}"/versions/$version.*/bin/python; do
    if [ -x "$found" ] && "$found" -c '' 2>/dev/null; then there=$found; break; fi
  done
  if [ -n "$there" ]; then
    try "$("$there" --version)" "$there" "$place"
  elif [ "$(id -u)" = 0 ] && command -v debootstrap >/dev/null; then
    from_debian $version
  else
    echo "python$version: not here; root with debootstrap would try that of Debian"
  fi
done
