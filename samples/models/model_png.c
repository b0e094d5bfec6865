/* SPDX-License-Identifier: MIT
 *
 * model_png.c - the smallest encoder that a PNG reader accepts (ISO/IEC 15948): 8-bit RGB, no
 * filter, and deflate blocks that are stored instead of compressed (RFC 1951, 3.2.4).
 */
#include "generate.h"

#include <stdlib.h>
#include <string.h>

static uint8_t *put_u32(uint8_t *at, uint32_t value) {
    for (int i = 0; i < 4; ++i) *at++ = (uint8_t)(value >> (24 - 8 * i));
    return at;
}

static uint32_t crc(const uint8_t *data, size_t size) {
    uint32_t value = 0xffffffffu;
    for (size_t i = 0; i < size; ++i) {
        value ^= data[i];
        for (int k = 0; k < 8; ++k) value = value >> 1 ^ (value & 1 ? 0xedb88320u : 0);
    }
    return ~value;
}

static uint32_t adler(const uint8_t *data, size_t size) {
    uint32_t a = 1, b = 0;
    for (size_t i = 0; i < size; ++i) {
        a = (a + data[i]) % 65521;
        b = (b + a) % 65521;
    }
    return b << 16 | a;
}

static uint8_t *put_chunk(uint8_t *at, const char *type, const uint8_t *data, size_t size) {
    at = put_u32(at, (uint32_t)size);
    uint8_t *begin = at;
    memcpy(at, type, 4);
    if (size) memcpy(at + 4, data, size);
    at += 4 + size;
    return put_u32(at, crc(begin, (size_t)(at - begin)));
}

/* Writes zlib's format (RFC 1950) around stored blocks of at most 65535 bytes. */
static size_t store(uint8_t *out, const uint8_t *data, size_t size) {
    uint8_t *at = out;
    *at++ = 0x78;
    *at++ = 0x01;
    for (size_t done = 0; done < size;) {
        size_t length = size - done < 65535 ? size - done : 65535;
        *at++ = done + length == size;
        *at++ = (uint8_t)length;
        *at++ = (uint8_t)(length >> 8);
        *at++ = (uint8_t)~length;
        *at++ = (uint8_t)(~length >> 8);
        memcpy(at, data + done, length);
        at += length;
        done += length;
    }
    at = put_u32(at, adler(data, size));
    return (size_t)(at - out);
}

uint8_t *make_png(const uint8_t *rgb, uint32_t width, uint32_t height, size_t *size) {
    static const uint8_t signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    size_t row = 1 + (size_t)width * 3, raw_size = row * height;
    uint8_t *raw = resize(NULL, raw_size), *packed = resize(NULL, raw_size + raw_size / 1000 + 64);
    uint8_t *png = resize(NULL, raw_size + raw_size / 1000 + 256), *at = png;
    for (uint32_t y = 0; y < height; ++y) {
        raw[y * row] = 0;
        memcpy(raw + y * row + 1, rgb + (size_t)y * width * 3, row - 1);
    }
    uint8_t header[13] = {0, 0, 0, 0, 0, 0, 0, 0, 8, 2, 0, 0, 0};
    put_u32(put_u32(header, width), height);
    memcpy(at, signature, sizeof signature);
    at = put_chunk(at + sizeof signature, "IHDR", header, sizeof header);
    at = put_chunk(at, "IDAT", packed, store(packed, raw, raw_size));
    at = put_chunk(at, "IEND", NULL, 0);
    free(raw);
    free(packed);
    *size = (size_t)(at - png);
    return png;
}
