/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * image_jpeg.c - JPEG to pixels through libjpeg(-turbo), in memory. The library reports errors by
 * a function that must not return: longjmp, which stays in this file.
 */
#include "material/image.h"

#include <setjmp.h>
#include <stdio.h> /* jpeglib.h needs it */

#include <jerror.h>
#include <jpeglib.h>

/* A progressive file may ask for any number of passes over the image; real ones have about ten. */
enum { MOST_SCANS = 200 };

typedef struct decoder {
    struct jpeg_decompress_struct jpeg;
    struct jpeg_error_mgr handler;
    struct jpeg_progress_mgr progress;
    jmp_buf escape;
    psplat_image *image;
    psplat_result result;
    psplat_error *error;
} decoder;

static void on_error(j_common_ptr jpeg) {
    decoder *d = jpeg->client_data;
    char message[JMSG_LENGTH_MAX];
    jpeg->err->format_message(jpeg, message);
    psplat_result code =
        jpeg->err->msg_code == JERR_OUT_OF_MEMORY ? PSPLAT_ERROR_MEMORY : PSPLAT_ERROR_FORMAT;
    if (!d->result) d->result = psplat_fail(d->error, code, 0, "JPEG: %.120s", message);
    longjmp(d->escape, 1);
}

/* Of warnings only the end of the data matters: the library would make up the rest in grey. */
static void on_message(j_common_ptr jpeg, int level) {
    if (level < 0 && jpeg->err->msg_code == JWRN_JPEG_EOF) on_error(jpeg);
}

static void on_progress(j_common_ptr jpeg) {
    decoder *d = jpeg->client_data;
    if (d->jpeg.input_scan_number <= MOST_SCANS) return;
    d->result =
        psplat_fail(d->error, PSPLAT_ERROR_RANGE, 0, "JPEG: more than %d scans", MOST_SCANS);
    longjmp(d->escape, 1);
}

static void decode(decoder *d, const void *data, size_t size) {
    jpeg_create_decompress(&d->jpeg);
    d->jpeg.progress = &d->progress;
    jpeg_mem_src(&d->jpeg, data, (unsigned long)size);
    jpeg_read_header(&d->jpeg, TRUE);
    d->result =
        psplat_image_allocate(d->image, d->jpeg.image_width, d->jpeg.image_height, d->error);
    if (d->result) return;
    d->jpeg.out_color_space = JCS_EXT_RGBA;
    jpeg_start_decompress(&d->jpeg);
    while (d->jpeg.output_scanline < d->jpeg.output_height) {
        JSAMPROW row = d->image->pixels + (size_t)d->jpeg.output_scanline * d->image->width * 4;
        jpeg_read_scanlines(&d->jpeg, &row, 1);
    }
    jpeg_finish_decompress(&d->jpeg);
}

psplat_result psplat_image_decode_jpeg(const void *data, size_t size, psplat_image *image,
                                       psplat_error *error) {
    decoder d = {.image = image, .error = error};
    d.jpeg.err = jpeg_std_error(&d.handler);
    d.jpeg.client_data = &d;
    d.handler.error_exit = on_error;
    d.handler.emit_message = on_message;
    d.progress.progress_monitor = on_progress;
    if (setjmp(d.escape) == 0) decode(&d, data, size);
    jpeg_destroy_decompress(&d.jpeg);
    if (d.result) psplat_image_free(image);
    return d.result;
}
