#!/bin/sh
# Build the firmware without PlatformIO: tools/build_firmware.sh [nano] [mega]
exec python3 "$(dirname "$0")/firmware_build.py" "$@"
