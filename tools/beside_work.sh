#!/bin/sh
# Run the tests several times beside four busy loops: what fails here hangs on how fast a machine is.
# tools/beside_work.sh [TIMES]
set -eu
cd "$(dirname "$0")/.."
times=${1:-3}

loops=
stop() { kill $loops 2>/dev/null || true; }
trap stop EXIT
trap 'exit 130' INT TERM
for _ in 1 2 3 4; do
    (while :; do :; done) &
    loops="$loops $!"
done

run=1
while [ "$run" -le "$times" ]; do
    echo "beside four busy loops: run $run of $times"
    make --no-print-directory test
    run=$((run + 1))
done
