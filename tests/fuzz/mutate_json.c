/* SPDX-License-Identifier: MIT
 *
 * mutate_json.c - changes a JSON document by whole values. Most documents stay well-formed that
 * way, so that the code behind the grammar is reached. See fuzz.h.
 */
#include "fuzz.h"

#include <stdlib.h>
#include <string.h>

typedef struct span {
    size_t begin, end;
} span;

/* ---- values ------------------------------------------------------------------------------- */

static size_t string_end(const fuzz_text *text, size_t at) {
    for (++at; at < text->size && text->data[at] != '"'; ++at)
        if (text->data[at] == '\\') ++at;
    return at < text->size ? at + 1 : text->size;
}

static size_t word_end(const fuzz_text *text, size_t at) {
    while (at < text->size && text->data[at] && !strchr(",:[]{}\" \t\r\n", text->data[at])) ++at;
    return at;
}

/* Returns the end of the string, container or word at `at`. */
static size_t value_end(const fuzz_text *text, size_t at) {
    if (text->data[at] == '"') return string_end(text, at);
    if (text->data[at] != '{' && text->data[at] != '[') return word_end(text, at);
    for (size_t depth = 0; at < text->size;) {
        uint8_t c = text->data[at];
        if (c == '{' || c == '[') ++depth;
        if (c == '}' || c == ']') --depth;
        at = c == '"' ? string_end(text, at) : at + 1;
        if (!depth) break;
    }
    return at;
}

static int begins_value(uint8_t c) {
    return c && !strchr(",:]} \t\r\n", c);
}

/* Picks a value or key anywhere in the document, except its own braces, all with equal
 * probability. */
static span pick(const fuzz_text *text, uint32_t *random) {
    span picked = {0, 0};
    size_t count = 0;
    for (size_t at = 0; at < text->size;) {
        uint8_t c = text->data[at];
        size_t begin = at;
        if (c == '"')
            at = string_end(text, at);
        else if (c == '{' || c == '[' || !begins_value(c))
            ++at;
        else
            at = word_end(text, at);
        if (at == begin) ++at; /* at a zero byte */
        if (begins_value(c) && begin && !fuzz_random(random, ++count)) picked.begin = begin;
    }
    if (count) picked.end = value_end(text, picked.begin);
    return picked;
}

static size_t skip_blanks(const fuzz_text *text, size_t at) {
    while (at < text->size && text->data[at] && strchr(" \t\r\n", text->data[at])) ++at;
    return at;
}

/* Returns the value and, where it is a key, also the value that it is the key of. */
static span member_of(const fuzz_text *text, span s) {
    size_t at = skip_blanks(text, s.end);
    if (at >= text->size || text->data[at] != ':') return s;
    at = skip_blanks(text, at + 1);
    if (at < text->size && begins_value(text->data[at])) s.end = value_end(text, at);
    return s;
}

/* ---- changes ------------------------------------------------------------------------------ */

int fuzz_splice(fuzz_text *text, size_t begin, size_t end, const void *bytes, size_t size) {
    size_t rest = text->size - end;
    if (begin + size + rest > text->capacity) return 0;
    memmove(text->data + begin + size, text->data + end, rest);
    if (size) memcpy(text->data + begin, bytes, size);
    text->size = begin + size + rest;
    return 1;
}

/* The words of this file are written with ' for ", because JSON has no other use for '. */
static void splice_word(fuzz_text *text, span s, const char *word) {
    size_t size = strlen(word);
    if (!fuzz_splice(text, s.begin, s.end, word, size)) return;
    for (size_t i = 0; i < size; ++i)
        if (word[i] == '\'') text->data[s.begin + i] = '"';
}

/* Puts a copy of another place's bytes, followed by a separator, in the place of s. */
static void splice_copy(fuzz_text *text, span s, span other, const char *separator) {
    size_t size = other.end - other.begin, more = strlen(separator);
    char *copy = malloc(size + more + 1);
    if (!copy) return;
    memcpy(copy, text->data + other.begin, size);
    memcpy(copy + size, separator, more);
    fuzz_splice(text, s.begin, s.end, copy, size + more);
    free(copy);
}

static void replace_by_constant(fuzz_text *text, span s, uint32_t *random) {
    static const char *const constants[] = {"0",
                                            "1",
                                            "2",
                                            "3",
                                            "4",
                                            "5",
                                            "-1",
                                            "0.5",
                                            "1.005",
                                            "-0.0",
                                            "1e-3",
                                            "1e38",
                                            "-1e308",
                                            "1e400",
                                            "255",
                                            "65535",
                                            "5120",
                                            "5121",
                                            "5122",
                                            "5123",
                                            "5125",
                                            "5126",
                                            "4294967295",
                                            "4294967296",
                                            "9007199254740992",
                                            "9007199254740993",
                                            "18446744073709551615",
                                            "true",
                                            "false",
                                            "null",
                                            "''",
                                            "[]",
                                            "{}",
                                            "[0,0,0]",
                                            "[0,0,0,1]",
                                            "[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]",
                                            "'SCALAR'",
                                            "'VEC2'",
                                            "'VEC3'",
                                            "'VEC4'",
                                            "'ATTRIBUTES'",
                                            "'NONE'",
                                            "'OCTAHEDRAL'",
                                            "'QUATERNION'",
                                            "'EXPONENTIAL'",
                                            "'MAT4'",
                                            "'\\u00e9'",
                                            "'\\ud83d\\ude00'",
                                            "'\\ud83d'",
                                            "'data:;base64,AAAA'",
                                            "'x.bin'",
                                            "'read'",
                                            "'memory'",
                                            "'empty'",
                                            "'%41%2f'",
                                            "'../x'",
                                            "'a/../x'",
                                            "'/x'",
                                            "'http:x'",
                                            "'2.0'",
                                            "'2.9'",
                                            "'3.0'"};
    size_t count = sizeof constants / sizeof *constants;
    splice_word(text, s, constants[fuzz_random(random, count)]);
}

/* Adds a member in front of a key. */
static void add_member(fuzz_text *text, span s, uint32_t *random) {
    static const char *const members[] = {
        "'mesh':0,",
        "'children':[1],",
        "'children':[],",
        "'translation':[1,2,3],",
        "'rotation':[0,0,0,1],",
        "'scale':[1,1,-1],",
        "'matrix':[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],",
        "'nodes':[0],",
        "'nodes':[{}],",
        "'scene':0,",
        "'scenes':[{}],",
        "'byteOffset':0,",
        "'byteStride':4,",
        "'byteLength':4,",
        "'normalized':true,",
        "'sparse':{},",
        "'indices':0,",
        "'targets':[],",
        "'mode':0,",
        "'uri':'data:;base64,AAAAAAAAAAAAAIA/',",
        "'uri':'x.bin',",
        "'uri':'read',",
        "'uri':'%65mpty',",
        "'uri':'memory',",
        "'min':[0],",
        "'minVersion':'2.0',",
        "'COLOR_0':0,",
        "'PSPLAT_surface_splats:NORMAL_FIELD':0,",
        "'_PSPLAT_surface_splats:CLIP_0':0,",
        "'PSPLAT_surface_splats:CLIP_3':0,",
        "'PSPLAT_surface_splats:TURN':0,",
        "'_PSPLAT_surface_splats:TILT':0,",
        "'_PSPLAT_surface_splats:EMISSIVE':1,",
        "'_PSPLAT_surface_splats:OCCLUSION_ROUGHNESS_METALLIC':1,",
        "'_PSPLAT_surface_splats:COLOR_U':1,'_PSPLAT_surface_splats:COLOR_V':0,",
        "'scaleRange':[0.5,2],",
        "'tiltRange':1,'fieldRange':2,'colorRange':0.5,",
        "'turnRange':0.5,'clipRange':[1,2],",
        "'curved':true,",
        "'version':3,'curved':true,'shapeRange':0.5,'bendRange':2,",
        "'_PSPLAT_surface_splats:SHAPE':1,",
        "'EXT_meshopt_compression':{'buffer':0,'byteLength':60,'byteStride':12,'count':2},",
        "'extensions':{'EXT_meshopt_compression':{'fallback':true}},",
        "'kernel':{'sharpness':2,'exponent':3},",
        "'kernel':{},",
        "'clipLines':1,",
        "'seamLines':1,",
        "'seamLines':[1,2],",
        "'emissiveFactor':[1,0.5,0],",
        "'doubleSided':true,",
        "'material':0,",
        "'pbrMetallicRoughness':{'metallicFactor':1,'roughnessFactor':0.5},",
        "'extensions':{'KHR_materials_unlit':{}},",
        "'extensions':{'KHR_materials_emissive_strength':{'emissiveStrength':4}},",
        "'extensionsRequired':['PSPLAT_surface_splats'],",
        "'extensionsRequired':['EXT_x'],",
        "'extras':[[],{'a':null}],"};
    size_t count = sizeof members / sizeof *members;
    splice_word(text, (span){s.begin, s.begin}, members[fuzz_random(random, count)]);
}

/* Drops a value with one of the commas around it. */
static void drop(fuzz_text *text, span s) {
    size_t after = skip_blanks(text, s.end), before = s.begin;
    while (before && strchr(" \t\r\n", text->data[before - 1])) --before;
    if (after < text->size && text->data[after] == ',')
        s.end = after + 1;
    else if (before && text->data[before - 1] == ',')
        s.begin = before - 1;
    splice_word(text, s, "");
}

/* Changes the bytes of one value as libFuzzer mutates bytes. */
static void mutate_inside(fuzz_text *text, span s) {
    size_t size = s.end - s.begin, room = size + 16;
    uint8_t *copy = calloc(room, 1);
    if (!copy) return;
    memcpy(copy, text->data + s.begin, size);
    size = LLVMFuzzerMutate(copy, size, room);
    fuzz_splice(text, s.begin, s.end, copy, size);
    free(copy);
}

void fuzz_mutate_json(fuzz_text *text, uint32_t *random) {
    span s = pick(text, random), other = pick(text, random);
    if (s.end == s.begin) {
        text->size = LLVMFuzzerMutate(text->data, text->size, text->capacity);
        return;
    }
    switch (fuzz_random(random, 8)) {
    case 0:
    case 1:
        replace_by_constant(text, s, random);
        break;
    case 2:
        splice_copy(text, s, other, "");
        break;
    case 3:
        drop(text, member_of(text, s));
        break;
    case 4:
        splice_copy(text, (span){s.begin, s.begin}, member_of(text, s), ",");
        break;
    case 5:
        splice_copy(text, (span){s.begin, s.begin}, member_of(text, other), ",");
        break;
    case 6:
        add_member(text, s, random);
        break;
    default:
        mutate_inside(text, s);
    }
}
