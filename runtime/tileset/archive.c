/* SPDX-License-Identifier: MIT
 *
 * archive.c - reads the central directory at the end of a ZIP archive. The local header before each
 * file is skipped when the file has been read, since only it tells its own length.
 */
#include "tileset/archive.h"

#include <string.h>

enum {
    END = 22,       /* bytes of the end of the central directory without its comment */
    END64 = 56,     /* of the same with 64 bits */
    LOCATOR64 = 20, /* of what points to it, right before the other */
    DIRECTORY = 46, /* of an entry of the directory without its name */
    LOCAL = 30,     /* of a local header without its name */
    FIELD = 65535,  /* the most bytes of a name, a comment or extra fields */
    ENCRYPTED = 1,  /* flag */
    ZIP64 = 1       /* number of an extra field */
};

/* The most bytes of a directory. */
static const uint64_t most_directory = (uint64_t)1 << 30;

static uint64_t get(const uint8_t *bytes, int count) {
    uint64_t value = 0;
    while (count-- > 0) value = value << 8 | bytes[count];
    return value;
}

/* What is known of an archive while it is read. */
typedef struct reader {
    const psplat_tiles_source *source;
    const char *path;
    psplat_tile_archive *out;
    uint64_t size;         /* of the archive */
    uint64_t start, bytes; /* of the directory */
    uint64_t count;        /* entries */
    psplat_error *error;
} reader;

static psplat_result refuse(const reader *r, psplat_result code, uint64_t offset,
                            const char *text) {
    return psplat_fail(r->error, code, (size_t)offset, "%.150s: %s", r->path, text);
}

/* Reads bytes that must be there into the arena. */
static psplat_result read_part(const reader *r, uint64_t offset, uint64_t size,
                               const uint8_t **data) {
    uint8_t *block = psplat_arena_take(&r->out->arena, 1, (size_t)size);
    size_t got = 0;
    if (!block) return refuse(r, PSPLAT_ERROR_MEMORY, 0, "no memory for the archive's directory");
    psplat_result result =
        r->source->read(r->source->user, r->path, offset, block, (size_t)size, &got, r->error);
    if (result) return refuse(r, result, offset, psplat_result_text(result));
    if (got != size) return refuse(r, PSPLAT_ERROR_READ, offset, "the archive ends too early");
    *data = block;
    return PSPLAT_OK;
}

/* ---- the end of the archive ------------------------------------------------------------------ */

/* Reads the end with 64 bits where the other one says that it has too few. */
static psplat_result read_end64(reader *r, const uint8_t *locator) {
    const uint8_t *end = NULL;
    uint64_t at = get(locator + 8, 8);
    if (get(locator, 4) != 0x07064b50 || r->size < END64 || at > r->size - END64)
        return refuse(r, PSPLAT_ERROR_FORMAT, r->size, "the ZIP64 end is wrong");
    psplat_result result = read_part(r, at, END64, &end);
    if (result) return result;
    if (get(end, 4) != 0x06064b50)
        return refuse(r, PSPLAT_ERROR_FORMAT, at, "the ZIP64 end is wrong");
    r->count = get(end + 32, 8);
    r->bytes = get(end + 40, 8);
    r->start = get(end + 48, 8);
    return PSPLAT_OK;
}

static psplat_result read_end(reader *r) {
    uint64_t tail = END + LOCATOR64 + FIELD;
    const uint8_t *bytes = NULL;
    if (tail > r->size) tail = r->size;
    if (tail < END) return refuse(r, PSPLAT_ERROR_FORMAT, 0, "it is no ZIP archive");
    psplat_result result = read_part(r, r->size - tail, tail, &bytes);
    if (result) return result;
    size_t at = (size_t)tail - END;
    while (at && (get(bytes + at, 4) != 0x06054b50 || get(bytes + at + 20, 2) != tail - END - at))
        --at;
    if (get(bytes + at, 4) != 0x06054b50)
        return refuse(r, PSPLAT_ERROR_FORMAT, 0, "it is no ZIP archive");
    r->count = get(bytes + at + 10, 2);
    r->bytes = get(bytes + at + 12, 4);
    r->start = get(bytes + at + 16, 4);
    int is_large = r->count == 0xffff || r->bytes == 0xffffffff || r->start == 0xffffffff;
    if (is_large && at >= LOCATOR64) result = read_end64(r, bytes + at - LOCATOR64);
    if (result) return result;
    if (r->start > r->size || r->bytes > r->size - r->start || r->bytes > most_directory ||
        r->count > r->bytes / DIRECTORY)
        return refuse(r, PSPLAT_ERROR_FORMAT, r->size - tail + at,
                      "the directory is not in the archive");
    return PSPLAT_OK;
}

/* ---- the directory --------------------------------------------------------------------------- */

/* Takes numbers of 64 bits from the extra fields, in the place of those that are too large for the
 * entry. */
static int read_extra64(const uint8_t *extra, size_t size, uint64_t *const numbers[3]) {
    for (size_t at = 0; at + 4 <= size;) {
        size_t length = (size_t)get(extra + at + 2, 2), used = 0;
        if (length > size - at - 4) return 0;
        for (int i = 0; get(extra + at, 2) == ZIP64 && i < 3; ++i) {
            if (*numbers[i] != 0xffffffff) continue;
            if (length - used < 8) return 0;
            *numbers[i] = get(extra + at + 4 + used, 8);
            used += 8;
        }
        at += 4 + length;
    }
    return 1;
}

/* Reads an entry of the directory and returns where the next one begins; 0 where it is wrong. */
static size_t read_entry(const reader *r, const uint8_t *directory, size_t at,
                         psplat_tile_entry *entry) {
    const uint8_t *e = directory + at;
    if (r->bytes - at < DIRECTORY || get(e, 4) != 0x02014b50) return 0;
    size_t name = (size_t)get(e + 28, 2), extra = (size_t)get(e + 30, 2);
    size_t next = at + DIRECTORY + name + extra + (size_t)get(e + 32, 2);
    uint64_t packed = get(e + 20, 4), size = get(e + 24, 4), offset = get(e + 42, 4);
    if (next > r->bytes) return 0;
    if (!read_extra64(e + DIRECTORY + name, extra, (uint64_t *const[]){&size, &packed, &offset}))
        return 0;
    int is_stored = get(e + 10, 2) == 0 && !(get(e + 8, 2) & ENCRYPTED);
    if (offset > r->start || packed > r->start - offset || (is_stored && packed != size)) return 0;
    *entry = (psplat_tile_entry){.name = (const char *)e + DIRECTORY,
                                 .name_size = name,
                                 .offset = offset,
                                 .span = LOCAL + name + FIELD + packed,
                                 .size = packed,
                                 .is_stored = is_stored};
    return next;
}

static psplat_result read_directory(reader *r) {
    const uint8_t *directory = NULL;
    psplat_tile_archive *out = r->out;
    size_t at = 0;
    psplat_result result = read_part(r, r->start, r->bytes, &directory);
    if (result) return result;
    out->entries = psplat_arena_take(&out->arena, (size_t)r->count, sizeof *out->entries);
    if (!out->entries)
        return refuse(r, PSPLAT_ERROR_MEMORY, 0, "no memory for the archive's directory");
    for (out->entry_count = 0; out->entry_count < r->count; ++out->entry_count) {
        size_t next = read_entry(r, directory, at, &out->entries[out->entry_count]);
        if (!next)
            return refuse(r, PSPLAT_ERROR_FORMAT, r->start + at,
                          "an entry of the directory is wrong");
        at = next;
    }
    return PSPLAT_OK;
}

/* ---- order ----------------------------------------------------------------------------------- */

static int compare_names(const char *a, size_t a_size, const char *b, size_t b_size) {
    size_t size = a_size < b_size ? a_size : b_size;
    int order = size ? memcmp(a, b, size) : 0;
    return order ? order : a_size < b_size ? -1 : a_size > b_size;
}

static int by_name(const psplat_tile_entry *a, const psplat_tile_entry *b) {
    return compare_names(a->name, a->name_size, b->name, b->name_size);
}

static int by_offset(const psplat_tile_entry *a, const psplat_tile_entry *b) {
    return a->offset < b->offset ? -1 : a->offset > b->offset;
}

typedef int comparison(const psplat_tile_entry *a, const psplat_tile_entry *b);

static void sink(psplat_tile_entry *heap, size_t count, size_t at, comparison *compare) {
    psplat_tile_entry entry = heap[at];
    for (size_t child = 2 * at + 1; child < count; child = 2 * at + 1) {
        if (child + 1 < count && compare(&heap[child], &heap[child + 1]) < 0) ++child;
        if (compare(&entry, &heap[child]) >= 0) break;
        heap[at] = heap[child];
        at = child;
    }
    heap[at] = entry;
}

/* Heapsort, since that of the C library may allocate. */
static void sort(psplat_tile_entry *entries, size_t count, comparison *compare) {
    for (size_t i = count / 2; i-- > 0;) sink(entries, count, i, compare);
    for (size_t i = count; i-- > 1;) {
        psplat_tile_entry first = entries[0];
        entries[0] = entries[i];
        entries[i] = first;
        sink(entries, i, 0, compare);
    }
}

/* Ends each span where the next file begins. Files do not overlap. */
static psplat_result find_spans(const reader *r) {
    psplat_tile_entry *entries = r->out->entries;
    size_t count = r->out->entry_count;
    sort(entries, count, by_offset);
    for (size_t i = 0; i < count; ++i) {
        uint64_t room = (i + 1 < count ? entries[i + 1].offset : r->start) - entries[i].offset;
        if (entries[i].span > room) entries[i].span = room;
        if (entries[i].span < LOCAL + entries[i].name_size + entries[i].size)
            return refuse(r, PSPLAT_ERROR_FORMAT, entries[i].offset, "files overlap");
    }
    sort(entries, count, by_name);
    for (size_t i = 1; i < count; ++i)
        if (!by_name(&entries[i - 1], &entries[i]))
            return refuse(r, PSPLAT_ERROR_FORMAT, entries[i].offset, "two files have one name");
    return PSPLAT_OK;
}

/* ---- the public functions -------------------------------------------------------------------- */

static psplat_result copy_name(reader *r) {
    const char *name = r->path;
    for (const char *c = r->path; *c; ++c)
        if (*c == '/' || *c == '\\') name = c + 1;
    size_t size = strlen(name) + 1;
    char *copy = psplat_arena_take(&r->out->arena, size, 1);
    if (!copy) return refuse(r, PSPLAT_ERROR_MEMORY, 0, "no memory for its name");
    memcpy(copy, name, size);
    r->out->name = copy;
    return PSPLAT_OK;
}

psplat_result psplat_tile_archive_open(const psplat_tiles_source *source, const char *path,
                                       const psplat_allocator *allocator,
                                       psplat_tile_archive *archive, psplat_error *error) {
    reader r = {.source = source, .path = path, .out = archive, .error = error};
    *archive = (psplat_tile_archive){.arena = {.allocator = psplat_allocator_default(allocator)}};
    if (!source->size)
        return refuse(&r, PSPLAT_ERROR_UNSUPPORTED, 0, "the source tells no sizes of archives");
    psplat_result result = source->size(source->user, path, &r.size, error);
    if (result) result = refuse(&r, result, 0, psplat_result_text(result));
    if (!result) result = copy_name(&r);
    if (!result) result = read_end(&r);
    if (!result) result = read_directory(&r);
    if (!result) result = find_spans(&r);
    if (!result) return PSPLAT_OK;
    psplat_arena_release(&archive->arena);
    archive->name = NULL;
    return result;
}

const psplat_tile_entry *psplat_tile_archive_find(const psplat_tile_archive *archive,
                                                  const char *name) {
    size_t low = 0, high = archive->entry_count, size = strlen(name);
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        const psplat_tile_entry *entry = &archive->entries[middle];
        int order = compare_names(name, size, entry->name, entry->name_size);
        if (!order) return entry;
        if (order < 0)
            high = middle;
        else
            low = middle + 1;
    }
    return NULL;
}

psplat_result psplat_tile_archive_unpack(const void *span, size_t span_size, uint64_t file_size,
                                         const void **data, psplat_error *error) {
    const uint8_t *bytes = span;
    if (span_size < LOCAL || get(bytes, 4) != 0x04034b50)
        return psplat_fail(error, PSPLAT_ERROR_FORMAT, 0, "no file begins here in the archive");
    size_t begin = LOCAL + (size_t)get(bytes + 26, 2) + (size_t)get(bytes + 28, 2);
    if (begin > span_size || file_size > span_size - begin)
        return psplat_fail(error, PSPLAT_ERROR_FORMAT, 26, "a file reaches into the next one");
    *data = bytes + begin;
    return PSPLAT_OK;
}
