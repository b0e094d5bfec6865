/* SPDX-License-Identifier: MIT
 *
 * test_shrink_images.c - tests of halving images: colours are averaged in linear light, other
 * numbers as they are, formats stay, and what is small enough is not touched.
 */
#include "picture_bytes.h"

#include "material/image.h"
#include "material/shrink_images.h"
#include "material/source_materials.h"

#include <stdlib.h>
#include <string.h>

enum { SIDE = 8, IMAGES = 4 };

/* Checks of single texels, black and white, so that every mean of four is a half. */
static psplat_image checks(int is_jpeg, int alpha) {
    uint8_t rgba[SIDE][SIDE][4], rgb[SIDE][SIDE][3];
    psplat_image image;
    size_t size;
    for (size_t i = 0; i < SIDE * SIDE; ++i) {
        memset((&rgba[0][0][0]) + 4 * i, (i + i / SIDE) % 2 ? 255 : 0, 3);
        (&rgba[0][0][0])[4 * i + 3] = (uint8_t)alpha;
        memset((&rgb[0][0][0]) + 3 * i, 200, 3); /* what JPEG holds without loss */
    }
    uint8_t *data = is_jpeg ? jpeg_of(&rgb[0][0][0], SIDE, SIDE, 3, 0, &size)
                            : png_of(rgba, SIDE, SIDE, PNG_FORMAT_RGBA, NULL, &size);
    assert_int_equal(psplat_image_read(data, size, &image, NULL), PSPLAT_OK);
    free(data);
    return image;
}

static void expect(const psplat_image *image, uint32_t side, int value, int alpha, int tolerance) {
    psplat_image decoded;
    assert_int_equal(image->width, side);
    assert_int_equal(image->height, side);
    assert_int_equal(psplat_image_decode(image->bytes, image->size, &decoded, NULL), PSPLAT_OK);
    assert_int_equal(decoded.width, side);
    for (int k = 0; k < 4; ++k) {
        int wanted = k < 3 ? value : alpha;
        assert_in_range(image->pixels[k], wanted - tolerance, wanted + tolerance);
        assert_in_range(decoded.pixels[k], wanted - tolerance, wanted + tolerance);
    }
    psplat_image_free(&decoded);
}

static void test_halved(void **state) {
    (void)state;
    psplat_image images[IMAGES] = {checks(0, 255), checks(0, 255), checks(1, 255), checks(0, 100)};
    psplat_source_material material = {.emissive = {.image = &images[0]},
                                       .normal = {.image = &images[1]},
                                       .base_color = {.image = &images[2]},
                                       .occlusion = {.image = &images[3]}};
    psplat_source_materials materials = {&material, 1, images, IMAGES, NULL};
    images[0].name = malloc(6);
    strcpy(images[0].name, "a.png");
    size_t size = images[1].size;
    assert_int_equal(psplat_images_shrink(&materials, SIDE, NULL), PSPLAT_OK);
    assert_int_equal(images[1].width, SIDE);
    assert_int_equal(images[1].size, size);
    assert_int_equal(psplat_images_shrink(&materials, 3, NULL), PSPLAT_OK);
    expect(&images[0], 2, 188, 255, 0); /* linear 0.5 */
    expect(&images[1], 2, 128, 255, 0);
    expect(&images[2], 2, 200, 255, 2); /* of the second JPEG */
    expect(&images[3], 2, 128, 100, 0);
    assert_string_equal(images[0].name, "a.png");
    assert_string_equal(images[2].mime_type, "image/jpeg");
    for (int i = 0; i < IMAGES; ++i) psplat_image_free(&images[i]);
}

int test_shrink_images_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_halved),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
