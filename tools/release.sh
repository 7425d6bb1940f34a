#!/usr/bin/env bash
# Everything of a release, into dist/: sdist, the wheel made of it where there is no git, both .hex files, the pages,
# an SBOM and the licences of what is shipped, SHA256SUMS. tools/release.sh [PYTHON …]: those the packages are tried on.
# On a commit without a tag it does the same, and says that this is no release. Nothing is uploaded.
set -euo pipefail
cd "$(dirname "$0")/.."
place=$(mktemp -d)
trap 'rm -rf --one-file-system "$place"' EXIT
step() { echo "$(date +%T) $*"; }

version=$(.venv/bin/python -m hatchling version)
head=$(sed -n 's/^## \([0-9.]*\), .*/\1/p;T;q' CHANGELOG.md)
day=$(sed -n 's/^date-released: //p' CITATION.cff)
complain() { echo "release: $*" >&2; exit 2; }
[ -z "$(git status --porcelain)" ] || complain "what is not committed would come along: git status"
if [ "$(git describe --tags --exact-match --match 'v*' 2>/dev/null)" = "v$version" ]; then
  grep -q "^## $version, $day\$" CHANGELOG.md || complain "CHANGELOG.md does not begin with $version, $day, the day in CITATION.cff"
  grep -q "^fallback-version = \"$version\"" pyproject.toml || complain "fallback-version in pyproject.toml is not $version"
else
  echo "no tag here: this is $version, a rehearsal of $head"
fi
grep -q '^\[project.urls\]' pyproject.toml || echo "pyproject.toml has no [project.urls]: where the project is hosted, add them"

rm -rf dist
step "firmware"
tools/firmware_release.sh >/dev/null
step "sdist, and the wheel of it"
.venv/bin/python -m hatchling build --target sdist --directory dist >/dev/null 2>&1
mkdir "$place/source"
tar xzf dist/*.tar.gz -C "$place/source" --strip-components 1
(cd "$place/source" && "$OLDPWD/.venv/bin/python" -m hatchling build --target wheel --directory "$OLDPWD/dist") >/dev/null 2>&1
[ -f "dist/wheelhop-$version-py3-none-any.whl" ] || complain "the wheel of the sdist has another version than $version"
cp build/release/wheelhop-logger-*.hex dist/

step "pages"
make --no-print-directory docs
tar czf "dist/wheelhop-$version-docs.tar.gz" --transform "s,^site,wheelhop-$version-docs," site

step "packages in clean environments"
mkdir "$place/packages"
cp dist/*.whl "dist/wheelhop-$version.tar.gz" "$place/packages/"
tools/test_wheels.sh --of "$place/packages" "$@"

step "SBOM and licences"
"${1:-.venv/bin/python}" -m venv "$place/env"
"$place/env/bin/pip" install -qq --disable-pip-version-check "$(echo "$place"/packages/*.whl)[workbench,logger]"
"$place/env/bin/python" tools/sbom.py "dist/wheelhop-$version.cdx.json" 'wheelhop[workbench,logger]' \
  >"dist/wheelhop-$version-licences.txt"

cd dist
sha256sum -- * >"$place/SHA256SUMS"
mv "$place/SHA256SUMS" .
step "done: dist/"
ls -l --block-size=1 | awk 'NR > 1 { print $5, $9 }'
cat SHA256SUMS
