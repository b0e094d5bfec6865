/* SPDX-License-Identifier: MIT
 * Writes a GLB of each scene of support into the directory named by the first argument, for the
 * tests in this directory. */
#include "scene.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int failed;

static void write_scene(const char *directory, const char *name, scene s) {
    char path[1024];
    size_t size = 0;
    uint8_t *data = scene_glb(&s, &size);
    snprintf(path, sizeof path, "%s/%s.glb", directory, name);
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(data, 1, size, file) != size || fclose(file)) {
        fprintf(stderr, "cannot write %s\n", path);
        failed = 1;
    }
    free(data);
    scene_free(&s);
}

/* Everything a file may hold: colours, a kernel, an origin, each material factor. */
static scene decorated(void) {
    scene s = scene_ellipses(60, 4, 3);
    s.material = (psplat_material){.base_color = {0.1f, 0.2f, 0.3f, 1},
                                   .emissive = {0.5f, 1.0f / 3, 3},
                                   .metallic = 0.25f,
                                   .roughness = 0.7f,
                                   .double_sided = 1};
    s.kernel = (psplat_kernel){1.5f, 3};
    s.origin[0] = 1e6 + 0.125;
    s.origin[2] = -0.1;
    return s;
}

static scene unlit(void) {
    scene s = scene_sphere(50, 1e-3f);
    s.material.unlit = 1;
    s.material.emissive[0] = 2;
    return s;
}

static scene default_material(void) {
    scene s = scene_disc(0.1f);
    s.material.metallic = s.material.roughness = 1;
    return s;
}

int main(int argc, char **argv) {
    if (argc != 2) return 2;
    write_scene(argv[1], "disc", scene_disc(1));
    write_scene(argv[1], "sphere", scene_sphere(500, 1));
    write_scene(argv[1], "cube", scene_cube(1));
    write_scene(argv[1], "ellipses", scene_ellipses(200, 4, 1));
    write_scene(argv[1], "decorated", decorated());
    write_scene(argv[1], "unlit", unlit());
    write_scene(argv[1], "default_material", default_material());
    return failed;
}
