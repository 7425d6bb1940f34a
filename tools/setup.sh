#!/bin/sh
# Make .venv with a Python >= 3.11 and install wheelhop into it: tools/setup.sh '.[test]'
set -eu
cd "$(dirname "$0")/.."

find_python() {
    for name in python3.13 python3.12 python3.11 python3; do
        if "$name" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
            echo "$name"
            return
        fi
    done
    return 1
}

# Debian and Ubuntu ship Python without the part that venv needs.
can_make_venv() { "$1" -c 'import ensurepip, venv' 2>/dev/null; }

install_or_ask() { # PACKAGE, WHAT IT GIVES
    if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
        apt-get update -qq
        DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$1" >/dev/null
    else
        echo "wheelhop: $2 is missing; on Debian or Ubuntu: sudo apt-get install $1" >&2
        exit 1
    fi
}

if ! .venv/bin/python -m pip --version >/dev/null 2>&1; then
    find_python >/dev/null || install_or_ask python3 "Python 3.11 or later"
    python=$(find_python) || { echo "wheelhop: Python 3.11 or later is missing" >&2; exit 1; }
    version=$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
    can_make_venv "$python" || install_or_ask "python$version-venv" "Python's venv"
    "$python" -m venv --clear .venv
fi
# uv installs the same in a tenth of the time; where it is not to be had, pip does it by itself.
# Neither compiles: Python compiles what it imports, and most of what comes along never is.
pip_install() { .venv/bin/python -m pip install --quiet --disable-pip-version-check --no-compile "$@"; }
install_with_uv() {
    pip_install uv && .venv/bin/python -m uv pip install --quiet --python .venv/bin/python "$@"
}
install_with_uv --editable "$1" 2>/dev/null || pip_install --editable "$1"

# The firmware's tests build it and run it on a simulated board; without these they are skipped.
firmware="gcc g++ gcc-avr avr-libc arduino-core-avr libsimavr-dev libelf-dev dosfstools mtools"
firmware="$firmware clang-format cppcheck avrdude"

install_firmware_tools() {
    missing=
    for package in $firmware; do
        dpkg -s "$package" >/dev/null 2>&1 || missing="$missing $package"
    done
    [ -n "$missing" ] || return 0
    if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null && apt-get update -qq &&
        DEBIAN_FRONTEND=noninteractive \
            apt-get install -y -qq --no-install-recommends $missing >/dev/null; then
        return 0
    fi
    echo "wheelhop: the firmware's tests will be skipped; they need: sudo apt-get install$missing" >&2
}

# The workbench's tests look at it in a real browser; without one they are skipped.
install_browser() {
    command -v chromium >/dev/null || command -v chromium-browser >/dev/null && return 0
    if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null && apt-get update -qq &&
        DEBIAN_FRONTEND=noninteractive \
            apt-get install -y -qq --no-install-recommends chromium >/dev/null; then
        return 0
    fi
    echo "wheelhop: the workbench's tests will be skipped; they need: sudo apt-get install chromium" >&2
}

case "$1" in *test*)
    install_firmware_tools
    install_browser
    ;;
esac
