#!/bin/sh
# SPDX-License-Identifier: MIT
# Installs into FOLDER/node_modules what FOLDER/package-lock.json says, unless it is there already: npm_ci.sh FOLDER.
# npm writes its hidden lock file last, so that half an installation is not taken for a whole one; packages that were deleted
# since then have no package.json. Packages beyond those of the lock file are left alone, and those of another platform need
# not be there.
set -eu
folder=$1
if node - "$folder" <<'SCRIPT'
const { existsSync, readFileSync } = require('fs');
const packages = (name) => JSON.parse(readFileSync(process.argv[2] + '/' + name, 'utf8')).packages;
const wanted = packages('package-lock.json');
let installed = {};
try {
    installed = packages('node_modules/.package-lock.json');
} catch {
    /* nothing is installed */
}
const isWhole = (path, version) => installed[path].version === version && existsSync(process.argv[2] + '/' + path + '/package.json');
const isThere = ([path, one]) => !path || (installed[path] ? isWhole(path, one.version) : one.optional);
process.exit(Object.entries(wanted).every(isThere) && Object.keys(installed).length ? 0 : 1);
SCRIPT
then
    exit 0
fi
exec npm ci --prefix "$folder" --no-audit --no-fund --loglevel=error
