#!/bin/sh
# Snakemake runs this in the new environment of breaker.yaml (`snakemake --sdm conda`): scripts import
# the package, which is installed from here, editable, so that it is always the code of the rules.
# Snakemake runs a copy of this file in the folder of the results: of another project, BREAKER_ROOT
# names the folder of the code.
set -eu
root=${BREAKER_ROOT:-$PWD}
if ! grep -qs '^name = "breaker-drive"' "$root/pyproject.toml"; then
    echo "breaker is not in $root; set BREAKER_ROOT to the folder that holds its Snakefile" >&2
    exit 1
fi
python -m pip install --no-deps --no-build-isolation --no-index --editable "$root"
python -c "import breaker"
