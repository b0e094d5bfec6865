#!/bin/sh
# SPDX-License-Identifier: MIT
# Installs into FOLDER/node_modules what FOLDER/package-lock.json says, unless it is there already: npm_ci.sh FOLDER.
# npm writes its hidden lock file last, so that half an installation is not taken for a whole one. Packages beyond those of
# the lock file are left alone, and those of another platform need not be there.
set -eu
folder=$1
if node - "$folder" <<'SCRIPT'
const { readFileSync } = require('fs');
const packages = (name) => JSON.parse(readFileSync(process.argv[2] + '/' + name, 'utf8')).packages;
const wanted = packages('package-lock.json');
let installed = {};
try {
    installed = packages('node_modules/.package-lock.json');
} catch {
    /* nothing is installed */
}
const isThere = ([path, one]) => !path || (installed[path] ? installed[path].version === one.version : one.optional);
process.exit(Object.entries(wanted).every(isThere) && Object.keys(installed).length ? 0 : 1);
SCRIPT
then
    exit 0
fi
exec npm ci --prefix "$folder" --no-audit --no-fund --loglevel=error
