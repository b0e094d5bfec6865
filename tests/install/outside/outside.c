/* SPDX-License-Identifier: MIT
 * A program outside the source tree that opens an asset. */
#include <phongsplat/phongsplat.h>
#include <stdio.h>

int main(int argc, char **argv) {
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    if (argc != 2 || psplat_asset_open(argv[1], NULL, &asset, &error)) return puts(error.text), 1;
    printf("%zu batches\n", psplat_asset_batch_count(asset));
    psplat_asset_destroy(asset);
    return 0;
}
