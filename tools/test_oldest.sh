#!/usr/bin/env bash
# The wheel on a Python 3.11 with the oldest libraries that pyproject.toml lets in: the lower bounds, to the letter.
# tools/test_oldest.sh [PYTHON]. Needs PyPI, and hatchling in .venv.
set -euo pipefail
cd "$(dirname "$0")/.."
python=${1:-python3.11}
place=$(mktemp -d)
trap 'rm -rf --one-file-system "$place"' EXIT

.venv/bin/python - >"$place/oldest.txt" <<'PYTHON'
import re, tomllib
project = tomllib.load(open("pyproject.toml", "rb"))["project"]
extras = project["optional-dependencies"]
for bound in sorted({*project["dependencies"], *extras["workbench"], *extras["logger"]}):
    name, oldest = re.fullmatch(r"([\w-]+)>=([\d.]+)(?:,<[\d.]+)?", bound).groups()
    print(f"{name}=={oldest}")
PYTHON
.venv/bin/python -m hatchling build --target wheel --directory "$place" >/dev/null 2>&1
"$python" -m venv "$place/env"
wheel=$(echo "$place"/*.whl)
"$place/env/bin/pip" install -qq --disable-pip-version-check --only-binary :all: -c "$place/oldest.txt" \
  "$wheel[workbench,logger]" pytest hypothesis jsonschema
tr '\n' ' ' <"$place/oldest.txt"; echo
"$place/env/bin/python" -c "import wheelhop.workbench.app"
"$place/env/bin/pytest" -p no:cacheprovider --disable-warnings \
  tests/api/test_{public,results,saving,frames}.py tests/files/test_{toml,schemas,write}.py \
  tests/formats/test_{parquet,text}.py tests/report/test_{model_file,thesis_page}.py
