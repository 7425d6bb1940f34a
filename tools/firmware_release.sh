#!/bin/sh
# Make what a release carries: build/release/wheelhop-logger-{nano,mega}.hex and SHA256SUMS.
set -eu
cd "$(dirname "$0")/.."
tools/build_firmware.sh nano mega
mkdir -p build/release
for env in nano mega; do
    cp "build/firmware/$env/firmware.hex" "build/release/wheelhop-logger-$env.hex"
done
cd build/release
sha256sum wheelhop-logger-*.hex > SHA256SUMS
cat SHA256SUMS
