/* SPDX-License-Identifier: MIT
 *
 * test_archive.c - tests tilesets in a .3tz archive: that they are those of the files in it, and
 * that wrong archives are refused.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <stdlib.h>
#include <cmocka.h>

#include "tiles_fixture.h"

/* ---- writing -----------------------------------------------------------------------------------
 */

typedef struct zip {
    uint8_t *data;
    size_t size, capacity;
    uint8_t directory[1 << 17];
    size_t directory_size, count, start;
    size_t reads; /* bytes that were read */
    int has_descriptors, is_zip64;
} zip;

static void put_bytes(zip *z, const void *bytes, size_t size) {
    if (z->size + size > z->capacity) {
        z->capacity = 2 * (z->size + size);
        z->data = realloc(z->data, z->capacity);
        assert_non_null(z->data);
    }
    if (size) memcpy(z->data + z->size, bytes, size);
    z->size += size;
}

static size_t write_number(uint8_t *out, uint64_t value, int count) {
    for (int i = 0; i < count; ++i) out[i] = (uint8_t)(value >> (8 * i));
    return (size_t)count;
}

static void put(zip *z, uint64_t value, int count) {
    uint8_t bytes[8];
    put_bytes(z, bytes, write_number(bytes, value, count));
}

static void list(zip *z, uint64_t value, int count) {
    assert_true(z->directory_size + 8 < sizeof z->directory);
    z->directory_size += write_number(z->directory + z->directory_size, value, count);
}

/* Adds a file. With descriptors the local header tells no sizes, as writers of streams do; its
 * extra field is longer than that of the directory, as of some writers. */
static void zip_add(zip *z, const char *name, const void *data, size_t size, int method) {
    size_t offset = z->size, length = strlen(name);
    int flags = z->has_descriptors ? 8 : 0;
    put(z, 0x04034b50, 4);
    put(z, 20, 2);
    put(z, (uint64_t)flags, 2);
    put(z, (uint64_t)method, 2);
    put(z, 0, 8); /* time, checksum: not looked at */
    put(z, z->has_descriptors ? 0 : size, 4);
    put(z, z->has_descriptors ? 0 : size, 4);
    put(z, length, 2);
    put(z, 7, 2);
    put_bytes(z, name, length);
    put_bytes(z, "\x99\x00\x03\x00xyz", 7);
    put_bytes(z, data, size);
    if (z->has_descriptors) put(z, 0x08074b50, 4);
    if (z->has_descriptors) put(z, 0, 4), put(z, size, 4), put(z, size, 4);
    list(z, 0x02014b50, 4);
    list(z, 20, 2);
    list(z, 20, 2);
    list(z, (uint64_t)flags, 2);
    list(z, (uint64_t)method, 2);
    list(z, 0, 8);
    list(z, z->is_zip64 ? 0xffffffff : size, 4);
    list(z, size, 4);
    list(z, length, 2);
    list(z, z->is_zip64 ? 20 : 0, 2);
    list(z, 0, 4);
    list(z, 0, 6);
    list(z, z->is_zip64 ? 0xffffffff : offset, 4);
    memcpy(z->directory + z->directory_size, name, length);
    z->directory_size += length;
    if (z->is_zip64) list(z, 1, 2), list(z, 16, 2), list(z, size, 8), list(z, offset, 8);
    ++z->count;
}

static void zip_end(zip *z, const char *comment) {
    size_t end64;
    z->start = z->size;
    put_bytes(z, z->directory, z->directory_size);
    end64 = z->size;
    if (z->is_zip64) {
        put(z, 0x06064b50, 4);
        put(z, 44, 8);
        put(z, 0, 4);
        put(z, 0, 8);
        put(z, z->count, 8);
        put(z, z->count, 8);
        put(z, z->directory_size, 8);
        put(z, z->start, 8);
        put(z, 0x07064b50, 4);
        put(z, 0, 4);
        put(z, end64, 8);
        put(z, 1, 4);
    }
    put(z, 0x06054b50, 4);
    put(z, 0, 4);
    put(z, z->is_zip64 ? 0xffff : z->count, 2);
    put(z, z->is_zip64 ? 0xffff : z->count, 2);
    put(z, z->is_zip64 ? 0xffffffff : z->directory_size, 4);
    put(z, z->is_zip64 ? 0xffffffff : z->start, 4);
    put(z, strlen(comment), 2);
    put_bytes(z, comment, strlen(comment));
}

/* ---- reading -----------------------------------------------------------------------------------
 */

static psplat_result read_zip(void *user, const char *path, uint64_t offset, void *data,
                              size_t size, size_t *got, psplat_error *error) {
    zip *z = user;
    (void)error;
    assert_string_equal(path, "dir/scene.3tz");
    size_t rest = offset < z->size ? z->size - (size_t)offset : 0;
    *got = size < rest ? size : rest;
    if (*got) memcpy(data, z->data + offset, *got);
    z->reads += *got;
    return PSPLAT_OK;
}

static psplat_result size_zip(void *user, const char *path, uint64_t *size, psplat_error *error) {
    (void)path;
    (void)error;
    *size = ((const zip *)user)->size;
    return PSPLAT_OK;
}

static psplat_result open_zip(zip *z, const psplat_allocator *allocator, psplat_tiles **tiles,
                              psplat_error *error) {
    psplat_tiles_desc desc = {.source = {read_zip, z, size_zip}};
    if (allocator) desc.allocator = *allocator;
    psplat_result result = psplat_tiles_open(&desc, "dir/scene.3tz", tiles, error);
    assert_int_equal(result == PSPLAT_OK, *tiles != NULL);
    if (*tiles) (*tiles)->models = &mock_models;
    return result;
}

/* Puts all files of a world into an archive. */
static void pack(zip *z, const world *w, psplat_tiles *all) {
    for (int i = 0; i < w->file_count; ++i)
        zip_add(z, w->paths[i], w->texts[i].data, w->texts[i].size, 0);
    for (size_t i = 0; i < all->content_count; ++i) {
        const psplat_tile_content *c = &all->contents[i];
        uint32_t which = path_hash(c->path) % WORLD_GLBS;
        if (c->is_tileset) continue;
        zip_add(z, c->path, w->glbs[which], w->glb_sizes[which], 0);
    }
    zip_add(z, "@3dtilesIndex1@", "", 0, 0);
}

static void free_zip(zip *z) {
    free(z->data);
    free(z);
}

static psplat_view view_all(void) {
    psplat_view view = {.width = 400, .height = 300};
    view_perspective(&view, 0.5, 0.01, 100);
    view_look_at(&view, (double[]){9, 4, 7}, (double[]){0, 0, 0});
    return view;
}

static size_t settle(zip *z, psplat_tiles *tiles, const psplat_tiles_view *v) {
    size_t total = 0;
    for (int i = 0; i < 30; ++i) {
        psplat_tile_request requests[16];
        psplat_error error = {0};
        assert_int_equal(psplat_tiles_select(tiles, v, NULL), PSPLAT_OK);
        size_t count = psplat_tiles_wanted(tiles, requests, 16);
        for (size_t k = 0; k < count; ++k) {
            assert_string_equal(requests[k].path, "scene.3tz");
            assert_true(requests[k].offset + requests[k].size <= z->start);
            uint8_t *bytes =
                malloc((size_t)requests[k].size); /* so that the sanitizer sees its end */
            assert_non_null(bytes);
            memcpy(bytes, z->data + requests[k].offset, (size_t)requests[k].size);
            psplat_result result = psplat_tiles_supply(tiles, requests[k].tile, bytes,
                                                       (size_t)requests[k].size, &error);
            if (result) print_error("%s\n", error.text);
            assert_int_equal(result, PSPLAT_OK);
            free(bytes);
        }
        total += count;
        assert_int_equal(psplat_tiles_upload(tiles, NULL, SIZE_MAX, NULL), PSPLAT_OK);
    }
    return total;
}

/* ---- tests -------------------------------------------------------------------------------------
 */

/* The archive's tileset is that of the directory: of archives that tell sizes before files or after
 * them, in 32 bits or in 64, with a comment. */
static void test_same_tiles(void **state) {
    (void)state;
    world w = {.depth = 6, .external_depth = 3, .missing = 0.15f, .has_extras = 1};
    world_make_tree(&w);
    psplat_view view = view_all();
    const psplat_tiles_view v = {.view = &view, .pixels = 1};
    psplat_tiles *directory = world_open(&w, (psplat_tiles_desc){0});
    size_t requests = world_settle(&w, directory, &v);
    for (int kind = 0; kind < 4; ++kind) {
        zip *z = calloc(1, sizeof *z);
        psplat_tiles *tiles = NULL;
        psplat_error error = {0};
        assert_non_null(z);
        z->has_descriptors = kind & 1;
        z->is_zip64 = kind >> 1;
        pack(z, &w, directory);
        zip_end(z, kind == 1 ? "a comment that begins as an end: PK\x05\x06, and goes on" : "");
        psplat_result result = open_zip(z, NULL, &tiles, &error);
        if (result) print_error("%s at %zu\n", error.text, error.offset);
        assert_int_equal(result, PSPLAT_OK);
        assert_true(z->reads < 90000 + z->directory_size + w.texts[0].size);
        assert_int_equal(settle(z, tiles, &v), requests);
        psplat_tiles_state a = psplat_tiles_describe(directory), b = psplat_tiles_describe(tiles);
        assert_int_equal(a.drawn, b.drawn);
        assert_int_equal(a.splats, b.splats);
        assert_int_equal(a.bytes, b.bytes);
        assert_int_equal(b.failed + b.missing, 0);
        psplat_tiles_destroy(tiles, NULL);
        free_zip(z);
    }
    psplat_tiles_destroy(directory, NULL);
    world_free(&w);
}

static const char tileset[] =
    "{\"asset\":{\"version\":\"1.1\"},\"geometricError\":1,\"root\":{\"refine\":\"REPLACE\","
    "\"geometricError\":1,\"boundingVolume\":{\"sphere\":[0,0,0,1]},"
    "\"content\":{\"uri\":\"a.glb\"}}}";

static zip *small_zip(int method, const char *first, const char *second) {
    zip *z = calloc(1, sizeof *z);
    assert_non_null(z);
    zip_add(z, first, tileset, sizeof tileset - 1, 0);
    zip_add(z, second, "12345678", 8, method);
    zip_end(z, "");
    return z;
}

static void expect_refusal(zip *z, psplat_result code, const char *cause) {
    psplat_tiles *tiles = NULL;
    psplat_error error = {0};
    psplat_result result = open_zip(z, NULL, &tiles, &error);
    if (result != code || !strstr(error.text, cause))
        print_error("%d: %s, not %s\n", (int)result, error.text, cause);
    assert_int_equal(result, code);
    assert_non_null(strstr(error.text, cause));
    free_zip(z);
}

static void test_refusals(void **state) {
    (void)state;
    zip *z = small_zip(0, "tileset.json", "a.glb");
    psplat_tiles *tiles = NULL;
    assert_int_equal(open_zip(z, NULL, &tiles, NULL), PSPLAT_OK);
    psplat_tiles_destroy(tiles, NULL);
    free_zip(z);
    expect_refusal(small_zip(8, "tileset.json", "a.glb"), PSPLAT_ERROR_UNSUPPORTED, "compressed");
    expect_refusal(small_zip(0, "tileset.json", "b.glb"), PSPLAT_ERROR_FORMAT, "no such file");
    expect_refusal(small_zip(0, "x/tileset.json", "a.glb"), PSPLAT_ERROR_UNSUPPORTED,
                   "no tileset.json");
    expect_refusal(small_zip(0, "a.glb", "a.glb"), PSPLAT_ERROR_FORMAT, "one name");
    z = small_zip(0, "tileset.json", "a.glb");
    z->size -= 1;
    expect_refusal(z, PSPLAT_ERROR_FORMAT, "no ZIP archive");
    z = small_zip(0, "tileset.json", "a.glb");
    z->size = 10;
    expect_refusal(z, PSPLAT_ERROR_FORMAT, "no ZIP archive");
    z = small_zip(0, "tileset.json", "a.glb");
    write_number(z->data + z->size - 6, z->size, 4);
    expect_refusal(z, PSPLAT_ERROR_FORMAT, "directory is not in the archive");
    z = small_zip(0, "tileset.json", "a.glb");
    write_number(z->data + z->start + 42, 20, 4); /* the first file begins later */
    expect_refusal(z, PSPLAT_ERROR_FORMAT, "overlap");
    z = small_zip(0, "tileset.json", "a.glb");
    write_number(z->data + z->start + 20, 1 << 20, 4);
    expect_refusal(z, PSPLAT_ERROR_FORMAT, "entry of the directory");
    z = small_zip(0, "tileset.json", "a.glb");
    z->data[0] = 'Q'; /* of the local header */
    expect_refusal(z, PSPLAT_ERROR_FORMAT, "no file begins here");
    const psplat_tiles_desc sizeless = {.source = {.read = read_zip}};
    assert_int_equal(psplat_tiles_open(&sizeless, "dir/scene.3TZ", &tiles, NULL),
                     PSPLAT_ERROR_UNSUPPORTED);
}

/* Every byte of a small archive is changed and every end cut off: nothing is read beyond what is
 * there, and nothing leaks. */
static void test_broken_bytes(void **state) {
    (void)state;
    zip *z = small_zip(0, "tileset.json", "a.glb");
    size_t size = z->size, opened = 0;
    for (size_t i = 0; i < size; ++i)
        for (int bit = 0; bit < 8; bit += 3) {
            psplat_tiles *tiles = NULL;
            z->data[i] ^= (uint8_t)(1 << bit);
            opened += open_zip(z, NULL, &tiles, NULL) == PSPLAT_OK;
            psplat_tiles_destroy(tiles, NULL);
            z->data[i] ^= (uint8_t)(1 << bit);
        }
    assert_true(opened > 0 && opened < 3 * size);
    for (z->size = 0; z->size < size; ++z->size) {
        psplat_tiles *tiles = NULL;
        assert_int_not_equal(open_zip(z, NULL, &tiles, NULL), PSPLAT_OK);
    }
    free_zip(z);
}

static void test_no_memory(void **state) {
    (void)state;
    zip *z = small_zip(0, "tileset.json", "a.glb");
    psplat_result result = PSPLAT_ERROR_MEMORY;
    for (int i = 0; result; ++i) {
        ledger l = {.fail_at = i};
        psplat_allocator allocator = ledger_allocator(&l);
        psplat_tiles *tiles = NULL;
        result = open_zip(z, &allocator, &tiles, NULL);
        assert_true(!result || result == PSPLAT_ERROR_MEMORY);
        psplat_tiles_destroy(tiles, NULL);
        assert_int_equal(l.bytes, 0);
        assert_true(i < 100);
    }
    free_zip(z);
}

/* The default source reads archives, too. */
static void test_stdio(void **state) {
    (void)state;
    const char *path = PSPLAT_BINARY_DIR "/test_archive.3tz";
    zip *z = small_zip(0, "tileset.json", "a.glb");
    FILE *file = fopen(path, "wb");
    psplat_tiles *tiles = NULL;
    assert_non_null(file);
    assert_int_equal(fwrite(z->data, 1, z->size, file), z->size);
    fclose(file);
    assert_int_equal(psplat_tiles_open(NULL, path, &tiles, NULL), PSPLAT_OK);
    psplat_tiles_destroy(tiles, NULL);
    remove(path);
    free_zip(z);
}

int test_archive_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same_tiles),   cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_broken_bytes), cmocka_unit_test(test_no_memory),
        cmocka_unit_test(test_stdio),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
