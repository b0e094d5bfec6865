/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * command_validate.c - phongsplat validate: checks whether the runtime accepts an asset.
 */
#include "cli/command.h"
#include "cli/options.h"

#include <phongsplat/phongsplat.h>

#include <stdio.h>

static psplat_parse parse(int argc, char **argv, const char **input) {
    const psplat_syntax syntax = {
        .command = "validate",
        .operands = "A.glb",
        .summary = "Checks an asset (.glb or .gltf) against the rules of PSPLAT_surface_splats\n"
                   "(schema/README.md) and prints one line.",
        .notes = "The exit code is the verdict. General rules of glTF that splats do not depend\n"
                 "on are the business of the Khronos glTF validator.",
        .slots = {input},
    };
    return psplat_options_parse(&syntax, argc, argv);
}

int psplat_command_validate(int argc, char **argv) {
    const char *input = NULL;
    psplat_parse parsed = parse(argc, argv, &input);
    if (parsed != PSPLAT_PARSE_OK) return (int)parsed;
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    if (psplat_command_open(input, NULL, &asset, &error)) return psplat_command_fail(input, &error);
    size_t splats = 0, batches = psplat_asset_batch_count(asset);
    for (size_t i = 0; i < batches; ++i) splats += psplat_asset_batch(asset, i)->splat_count;
    printf("%s: valid, %zu splats drawn in %zu batches\n", input, splats, batches);
    psplat_asset_destroy(asset);
    return PSPLAT_EXIT_SUCCESS;
}
