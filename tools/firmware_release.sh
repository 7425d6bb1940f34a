#!/bin/sh
# Make what a release carries: build/release/wheelhop-logger-{nano,mega}.hex and SHA256SUMS.
# With one toolchain only, that of Debian 12: gcc-avr 1:5.4.0+Atmel3.6.2-3, avr-libc 1:2.0.0+Atmel3.6.2-3.
# Another makes other bytes, and what is promised of flash and stack was measured with this one.
set -eu
cd "$(dirname "$0")/.."
compiler=$(avr-gcc -dumpversion)
library=$(echo '#include <avr/version.h>' | avr-gcc -E -dM - | sed -n 's/.*LIBC_VERSION_STRING__ "\(.*\)"/\1/p')
if [ "$compiler, $library" != "5.4.0, 2.0.0" ]; then
    echo "firmware_release: a release takes avr-gcc 5.4.0 with avr-libc 2.0.0, here are $compiler and $library" >&2
    exit 2
fi
tools/build_firmware.sh nano mega
mkdir -p build/release
for env in nano mega; do
    cp "build/firmware/$env/firmware.hex" "build/release/wheelhop-logger-$env.hex"
done
cd build/release
sha256sum wheelhop-logger-*.hex > SHA256SUMS
cat SHA256SUMS
