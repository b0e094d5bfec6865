/* SPDX-License-Identifier: MIT
 *
 * generate.c - writes the sample models into a directory:
 *
 *     generate_models samples/models
 *
 * The files are the same on every machine, but for the last digits in which its sine and cosine
 * differ from those of others.
 */
#include "generate.h"

#include <stdio.h>

static int failures;

static const char *path_in(const char *directory, const char *name) {
    static char path[4096];
    int length = snprintf(path, sizeof path, "%s/%s", directory, name);
    return length < (int)sizeof path ? path : "";
}

static void write_model(const char *directory, const char *name, solid s,
                        int (*write)(const char *path, const solid *s)) {
    const char *path = path_in(directory, name);
    if (write(path, &s)) {
        fprintf(stderr, "generate_models: cannot write %s\n", path);
        ++failures;
    }
    solid_free(&s);
}

static void write_painted(const char *directory, const char *name) {
    const char *path = path_in(directory, name);
    solid vase = make_vase(), ribbon = make_ribbon();
    if (write_painted_glb(path, &vase, &ribbon)) {
        fprintf(stderr, "generate_models: cannot write %s\n", path);
        ++failures;
    }
    solid_free(&vase);
    solid_free(&ribbon);
}

static void write_file_by(const char *directory, const char *name, int (*write)(const char *path)) {
    const char *path = path_in(directory, name);
    if (!write(path)) return;
    fprintf(stderr, "generate_models: cannot write %s\n", path);
    ++failures;
}

int main(int argc, char **argv) {
    if (argc != 2) {
        fputs("usage: generate_models DIRECTORY\n", stderr);
        return 2;
    }
    write_model(argv[1], "part.obj", make_part(), write_obj);
    write_model(argv[1], "cube.off", make_box(2, 2, 2), write_off);
    write_model(argv[1], "sphere.ply", make_sphere(4), write_ply_binary);
    write_model(argv[1], "torus.off", make_torus(1, 0.4, 64, 32), write_off);
    write_model(argv[1], "cone.stl", make_cone(1, 2, 48), write_stl_binary);
    write_model(argv[1], "plate.stl", make_box(4, 3, 0.02), write_stl_text);
    write_model(argv[1], "slab.ply", make_box(3, 2, 0.5), write_ply_text);
    write_model(argv[1], "bracket.gltf", make_bracket(), write_gltf);
    write_model(argv[1], "scan.xyz", make_scan(1.2, 1, 0.8, 1200), write_xyz);
    write_painted(argv[1], "painted.glb");
    write_file_by(argv[1], "tiled.glb", write_tiled_glb);
    write_file_by(argv[1], "still-life.glb", write_still_life);
    write_file_by(argv[1], "clockwork.glb", write_clockwork);
    return failures ? 1 : 0;
}
