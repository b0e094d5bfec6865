/* SPDX-License-Identifier: MIT
 *
 * attribute_types.c - the attributes of a primitive of splats: their names and the forms in which
 * each version of the extension stores them (spec 3.2 and 3.9).
 */
#include "asset/gltf.h"

#define BIT(type) (1u << ((type)-PSPLAT_BYTE))
#define FLOATS BIT(PSPLAT_FLOAT)
#define SIGNED (BIT(PSPLAT_BYTE) | BIT(PSPLAT_SHORT))
#define UNSIGNED (BIT(PSPLAT_UNSIGNED_BYTE) | BIT(PSPLAT_UNSIGNED_SHORT))

/* The last number of a line is its bend, where it has one more than version 2 knows. */
#define CLIP(k)                                                                                    \
    {                                                                                              \
        PSPLAT_EXTENSION ":CLIP_" #k, {                                                            \
            {1, 3, 3, FLOATS, 0}, {2, 2, 2, SIGNED, 0}, {3, 4, 4, FLOATS, 0}, {                    \
                3, 3, 3, SIGNED, 0                                                                 \
            }                                                                                      \
        }                                                                                          \
    }

const psplat_attribute_type psplat_attribute_types[PSPLAT_ATTRIBUTES] = {
    {"POSITION", {{1, 3, 3, FLOATS, 0}, {2, 3, 3, SIGNED | UNSIGNED, 1}}},
    {"NORMAL", {{1, 3, 3, FLOATS, 0}, {2, 3, 3, SIGNED, 0}}},
    {"COLOR_0", {{1, 3, 4, FLOATS | UNSIGNED, 0}}},
    {PSPLAT_EXTENSION ":ROTATION", {{1, 4, 4, FLOATS | SIGNED, 0}}},
    {PSPLAT_EXTENSION ":TURN", {{2, 1, 1, FLOATS | UNSIGNED, 0}}},
    {PSPLAT_EXTENSION ":TILT", {{2, 2, 2, FLOATS | SIGNED, 0}}},
    {PSPLAT_EXTENSION ":SCALE", {{1, 2, 2, FLOATS, 0}, {2, 2, 2, UNSIGNED, 0}}},
    {PSPLAT_EXTENSION ":NORMAL_FIELD", {{1, 2, 3, FLOATS, 0}, {2, 2, 3, SIGNED, 0}}},
    {PSPLAT_EXTENSION ":SHAPE", {{3, 3, 3, FLOATS | SIGNED, 0}}},
    CLIP(0),
    CLIP(1),
    CLIP(2),
    CLIP(3),
    {PSPLAT_EXTENSION ":COLOR_U", {{2, 3, 3, FLOATS | SIGNED, 0}}},
    {PSPLAT_EXTENSION ":COLOR_V", {{2, 3, 3, FLOATS | SIGNED, 0}}},
    {PSPLAT_EXTENSION ":OCCLUSION_ROUGHNESS_METALLIC", {{2, 3, 3, FLOATS | UNSIGNED, 0}}},
    {PSPLAT_EXTENSION ":EMISSIVE", {{2, 3, 3, FLOATS | UNSIGNED, 0}}},
    {"TEXCOORD_0", {{3, 2, 2, FLOATS | SIGNED | UNSIGNED, 1}}},
    {PSPLAT_EXTENSION ":TEXCOORD_U", {{3, 2, 2, FLOATS | SIGNED, 0}}},
    {PSPLAT_EXTENSION ":TEXCOORD_V", {{3, 2, 2, FLOATS | SIGNED, 0}}},
    {PSPLAT_EXTENSION ":TEXCOORD_UU", {{3, 2, 2, FLOATS | SIGNED, 0}}},
    {PSPLAT_EXTENSION ":TEXCOORD_UV", {{3, 2, 2, FLOATS | SIGNED, 0}}},
    {PSPLAT_EXTENSION ":TEXCOORD_VV", {{3, 2, 2, FLOATS | SIGNED, 0}}},
};
