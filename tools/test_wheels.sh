#!/usr/bin/env bash
# The wheel and the sdist in clean environments, one for each Python given: tools/test_wheels.sh [PYTHON …]
# Without arguments: every python3.11 … python3.14 there is. Needs PyPI, and hatchling in .venv.
set -euo pipefail
cd "$(dirname "$0")/.."
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT

.venv/bin/python -m hatchling build --directory "$place/dist" >/dev/null 2>&1

pythons=("$@")
if [ ${#pythons[@]} -eq 0 ]; then
  for version in 3.11 3.12 3.13 3.14; do
    for found in "$(command -v python$version || true)" "${PYENV_ROOT:-$HOME/.pyenv}"/versions/$version.*/bin/python; do
      if [ -x "$found" ] && "$found" -c '' 2>/dev/null; then pythons+=("$found"); break; fi
    done
  done
fi

for python in "${pythons[@]}"; do
  for package in "$place"/dist/*.whl "$place"/dist/*.tar.gz; do
    env="$place/env"
    "$python" -m venv --clear "$env"
    "$env/bin/pip" install -qq --disable-pip-version-check "$package"
    (
      cd "$place"
      "$env/bin/wheelhop" --help >/dev/null
      "$env/bin/wheelhop" simulate "$OLDPWD/examples/clean/vehicle.toml" --tracks washboard/low --speed 8 --out "$place/run.parquet" >/dev/null
      "$env/bin/wheelhop" compare "$OLDPWD/examples/clean" --json "$place/result.json" >/dev/null
      rm -f "$place/run.parquet" "$place/result.json"
    ) 2>"$place/said" || { cat "$place/said"; echo "$("$python" --version), ${package##*/}: fails"; exit 1; }
    echo "$("$python" --version), ${package##*/}: installs, simulates, compares"
  done
done
