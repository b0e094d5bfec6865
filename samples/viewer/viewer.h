/* SPDX-License-Identifier: MIT
 *
 * viewer.h - what the parts of phongsplat-viewer share, in the order in which a frame comes about:
 * settings, options, files, models, camera, lights, picture, window, keys. One section = one file.
 *
 * All but loader.c's worker runs on the main thread. Everything is zero-initialised and belongs to
 * the viewer struct at the end; there are no globals.
 */
#ifndef PHONGSPLAT_VIEWER_H
#define PHONGSPLAT_VIEWER_H

#include <phongsplat/phongsplat.h>
#include <phongsplat/tiles.h>

typedef struct viewer viewer;

/* A sphere in the scene; radius 0: empty. */
typedef struct sphere {
    double center[3];
    double radius;
} sphere;

/* ---- settings.c: how to draw, as keys and options change it --------------------------------- */

typedef struct settings {
    int mode;     /* psplat_mode */
    int shading;  /* psplat_shading */
    int culling;  /* psplat_culling */
    int lights;   /* index of lights_names */
    int backdrop; /* index of backdrop_names */
    int has_no_shadows;
    int has_no_filter;
    int has_environment;
    int is_orthographic;
    int is_smooth;       /* four samples a pixel */
    int is_turning;      /* the turntable turns */
    int is_paused;       /* animations stand still */
    int has_tile_report; /* numbers of tiles are shown */
    double pixels;       /* greatest error of tiles, in pixels of the window */
} settings;

/* The names are used on the command line, in the title and in messages. Each list ends with NULL.
 * Modes that are only for tests are not listed. */
extern const char *const mode_names[];
extern const char *const shading_names[];
extern const char *const culling_names[];
extern const char *const lights_names[];
extern const char *const backdrop_names[];

int names_count(const char *const *names);

/* ---- viewer_options.c: the command line ----------------------------------------------------- */

typedef struct options {
    settings settings;
    int width, height;       /* of the window; 0: the default, scaled as the screen asks */
    int is_gles;             /* a GLES 3.0 context instead of GL 3.3 */
    const char *screenshots; /* directory; NULL: that of the asset */
    int max_splats;          /* of tilesets, drawn at most; 0: any number */
    int max_megabytes;       /* of tiles in memory; 0: the default of the runtime */
    char **files;            /* file_count of them; moved to the end of argv */
    int file_count;
} options;

typedef enum parse_result { PARSE_OK, PARSE_HELP, PARSE_VERSION, PARSE_ERROR } parse_result;

/* Must be called only once in a process, because getopt_long keeps a state of its own. error gets
 * the cause of PARSE_ERROR. Prints nothing. */
parse_result options_parse(int argc, char **argv, options *o, psplat_error *error);
void options_print_help(void);

/* ---- asset_report.c: the error line and the exit code --------------------------------------- */

/* Returns the exit code, the same as that of the command line phongsplat, so that scripts can treat
 * both alike. */
int report_exit_code(psplat_result result);
/* Prints "phongsplat-viewer: subject: cause" (subject may be NULL) and returns the exit code. */
int report_error(const char *subject, const psplat_error *error);

/* ---- bounds.c ------------------------------------------------------------------------------- */

/* Returns a sphere around the visible parts of the asset's splats, at rest and at some times of its
 * animations. Unlike psplat_asset_bounds it
 * leaves out what their clip lines cut away. */
sphere bounds_of(const psplat_asset *asset);

/* ---- loader.c: assets opened and watched on a worker thread --------------------------------- */

typedef struct loader loader;

typedef struct loaded_file {
    char *path;
    psplat_asset *asset;   /* NULL where it is a tileset or error says why */
    psplat_tiles *tiles;   /* or NULL */
    psplat_pixels *images; /* those of asset, decoded */
    psplat_error error;
    sphere bounds; /* around the splats */
    size_t splat_count;
} loaded_file;

/* ---- tileset_path.c ------------------------------------------------------------------------- */

enum { MAX_PATH = 4096 };

/* Tells whether path is that of a tileset, a directory, a .json file or a .3tz archive, and writes
 * the file's name (0 where size is too small). */
int tileset_path(const char *path, char *name, size_t size);

/* Checks that path names a file that can be read, or a directory with a tileset. */
psplat_result loader_check(const char *path, psplat_error *error);

/* ---- decoded_images.c: images of files, decoded by the worker ------------------------------- */

/* Decodes the images of file->asset into file->images, or fills file->error. */
psplat_result decoded_images_make(loaded_file *file);
/* Frees what was made, before the asset is destroyed. */
void decoded_images_free(loaded_file *file);

/* Files that were opened together. */
typedef struct load {
    loaded_file *files;
    size_t count;
    int is_reload; /* some of the watched files; otherwise a new set */
    struct load *next;
} load;

/* wake is called on the worker's thread whenever loader_take has something to give. max_bytes is
 * for psplat_tiles_desc. Returns NULL where there is no memory or no thread. */
loader *loader_create(void (*wake)(void), size_t max_bytes);
/* Waits for the file that is being opened. NULL is accepted. */
void loader_destroy(loader *l);

/* Requests a new set of files and copies the paths. It replaces a set that still waits. The files
 * are watched from then on: a file that changes and then rests for a moment is opened again. Where
 * no file of a set can be opened, the earlier set stays watched. Returns 0 when out of memory. */
int loader_open(loader *l, const char *const *paths, size_t count);
void loader_reload(loader *l); /* all watched files, changed or not */
int loader_is_busy(loader *l); /* whether a new set is being opened */

/* Returns the oldest finished load, owned by the caller, or NULL where there is none. */
load *loader_take(loader *l);
void load_destroy(load *l); /* NULL is accepted */

/* ---- tile_reader.c: threads that read tiles ------------------------------------------------- */

typedef struct tile_reader tile_reader;

/* How many tiles are under way at a time. */
enum { TILE_REQUESTS = 32 };

/* path is that of the tileset. wake is called on a worker's thread whenever a tile was handed in.
 * Returns NULL where there is no memory or no thread. */
tile_reader *tile_reader_create(psplat_tiles *tiles, const char *path, void (*wake)(void));
/* Waits for the tiles that are being read, before the tileset is destroyed. NULL is accepted. */
void tile_reader_destroy(tile_reader *r);
/* Asks the threads for what the tileset wants. */
void tile_reader_feed(tile_reader *r);
/* Returns whether something has been handed in since the last call. */
int tile_reader_has_news(tile_reader *r);

/* ---- shown_asset.c: the assets that are shown ----------------------------------------------- */

typedef struct shown_asset {
    char *path;
    psplat_model *model; /* NULL: never opened successfully, or a tileset */
    psplat_tiles *tiles; /* or NULL */
    tile_reader *reader; /* of tiles */
    double tiles_transform[16];
    psplat_asset *asset; /* of the pose, NULL without animations */
    psplat_pose *pose;   /* NULL: at rest */
    sphere bounds;
    size_t splat_count;
    psplat_error error; /* of the latest load; code 0: none */
} shown_asset;

typedef struct shown_assets {
    psplat_renderer *renderer;
    const loaded_file *uploading; /* whose model is being made, or NULL */
    shown_asset *entries;
    psplat_item *items; /* one per entry with a model */
    size_t entry_count, item_count;
    psplat_item *frame_items; /* these and those of tilesets, as the last frame has drawn them */
    size_t frame_capacity;
    sphere bounds;
    size_t splat_count;  /* of models; those of tiles change with each frame */
    void (*wake)(void);  /* for the threads of tilesets */
    int is_side_by_side; /* models in a row, equally large; otherwise where the files place them */
    char refused_path[256]; /* the file because of which a set was not shown, or "" */
    psplat_error refused;
} shown_assets;

typedef enum shown_change { SHOWN_RELOADED, SHOWN_OPENED } shown_change;

/* Takes over what a load brings: new models are uploaded, the models they replace are freed. A file
 * that cannot be opened leaves the earlier model in place. */
shown_change shown_assets_take(shown_assets *s, load *l);
/* Places the models anew after is_side_by_side has changed. */
void shown_assets_arrange(shown_assets *s);
void shown_assets_clear(shown_assets *s);
/* Returns the first error to report and the file it concerns, or NULL where there is no error. */
const psplat_error *shown_assets_error(const shown_assets *s, const char **path);
const char *shown_asset_name(const char *path);    /* the path's last part */
int shown_assets_are_empty(const shown_assets *s); /* whether there is nothing to draw */
/* Returns what hands the images of shown->uploading to the renderer. */
psplat_images decoded_images(shown_assets *shown);

/* ---- shown_tiles.c: the tiles of a frame ---------------------------------------------------- */

int shown_tiles_exist(const shown_assets *s);
/* Returns whether tiles have come since the last call. */
int shown_tiles_have_news(shown_assets *s);
/* Chooses the tiles of a view that has samples of its pixels across one of the window's, and notes
 * their numbers in v->tiles_state, with the error in pixels of the window. *items and *count are
 * all that is to be drawn, until the next call. Sets v->needs_redraw where the next frame would
 * differ. */
psplat_result shown_tiles_choose(viewer *v, const psplat_view *view, double samples,
                                 const psplat_item **items, size_t *count, psplat_error *error);

/* ---- animation.c: what plays ---------------------------------------------------------------- */

/* Returns the greatest number of animations of a file. */
int animation_count(const shown_assets *s);
const char *animation_name(const shown_assets *s, int index);
int animation_is_playing(const viewer *v);
/* Poses all files after so many seconds of their animation of this index, which repeats. */
void animation_pose(shown_assets *s, int index, double seconds);
/* Lets what plays go on to the time that window_seconds tells. */
void animation_advance(viewer *v, double now);

/* ---- orbit.c: the camera -------------------------------------------------------------------- */

typedef struct orbit {
    double target[3]; /* the point that the camera turns about, in the middle of the picture */
    double azimuth, elevation; /* radians; 0, 0 looks along -z; y is up; elevation > 0 looks down */
    double distance;           /* of the eye from the target; > 0 */
    double reach; /* radius of the scene; zoom goes from thousandths to thousands of it */
} orbit;

/* Keeps the direction and moves so that all of the scene is in the picture. */
void orbit_fit(orbit *o, const sphere *scene, double aspect);
/* All moves are those of the pointer, in heights of the window, x to the right and y up. */
void orbit_turn(orbit *o, double x, double y);
void orbit_pan(orbit *o, double x, double y);
/* Moves by steps of the wheel, towards the scene where positive. What is under the point (x, y),
 * measured from the middle of the window, stays there. */
void orbit_zoom(orbit *o, double steps, double x, double y);
/* Fills the matrices of view, whose width and height are set. Near and far planes enclose the
 * scene. */
void orbit_view(const orbit *o, const sphere *scene, int is_orthographic, psplat_view *view);
/* Computes the camera's axes in the scene: right, up and back. */
void orbit_axes(const orbit *o, double axes[3][3]);
/* Makes a point the target and keeps the eye's distance from it: the point seen at (x, y), in
 * heights of the window from its middle, at window depth 0 ... 1. view is what orbit_view made. */
void orbit_aim(orbit *o, const psplat_view *view, double x, double y, double depth);

/* ---- light_setups.c: rigs of lights --------------------------------------------------------- */

/* Fills lights and ambient of view for a rig of lights_names. */
void lights_set(int rig, int has_shadows, const orbit *o, const sphere *scene, psplat_view *view);

/* ---- sky.c: an environment ------------------------------------------------------------------ */

/* Returns NULL on failure. The caller frees the sky with psplat_environment_destroy. */
psplat_environment *sky_create(psplat_renderer *renderer, psplat_error *error);

/* ---- canvas.c: rectangles and text ---------------------------------------------------------- */

/* Both in font pixels: the height of a glyph with descenders, and the distance between lines. */
enum { FONT_HEIGHT = 9, FONT_LINE = 11 };

typedef struct gl gl;
typedef struct canvas canvas;

/* get_proc is as in psplat_renderer_desc. */
canvas *canvas_create(void *(*get_proc)(void *user, const char *name), void *user,
                      psplat_error *error);
void canvas_destroy(canvas *c); /* NULL is accepted */
const gl *canvas_gl(const canvas *c);

/* Colours are sRGB-encoded RGBA as 0xRRGGBBAA; x, y in pixels from the upper left corner. */
void canvas_begin(canvas *c, int width, int height);
void canvas_rectangle(canvas *c, int x, int y, int width, int height, uint32_t top,
                      uint32_t bottom);
/* Draws one line of printable ASCII; other characters become question marks. size is the side of a
 * font pixel; canvas_text_width measures in font pixels. */
void canvas_text(canvas *c, int x, int y, int size, uint32_t color, const char *text);
int canvas_text_width(const char *text);
void canvas_end(canvas *c); /* draws into the bound framebuffer; writes no depth */

/* ---- multisample_target.c: a framebuffer that belongs to no window -------------------------- */

/* All zeros where there is no target. */
typedef struct target {
    unsigned framebuffer, color, depth; /* GL's names */
    int width, height;
    int is_complete;
} target;

/* Makes the target anew where its size differs. Returns 0 where GL cannot draw into it. Changes the
 * bound framebuffer. */
int target_resize(target *t, const gl *gl, int width, int height);
void target_free(target *t, const gl *gl);

/* ---- overlay.c: what is written over the picture -------------------------------------------- */

void overlay_draw(viewer *v, int width, int height);
/* Shows a message for some seconds. */
void overlay_say(viewer *v, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 2, 3)))
#endif
    ;

/* ---- title.c: the window's title ------------------------------------------------------------ */

/* Writes, for example, "part.glb - 1,234 splats - phong, lit - 5.2 ms - phongsplat". */
void title_write(const viewer *v, char *text, size_t size);

/* ---- draw_frame.c: one picture -------------------------------------------------------------- */

/* Draws backdrop and splats into a framebuffer (0: the window), which is bound afterwards. */
psplat_result frame_draw(viewer *v, unsigned framebuffer, int width, int height,
                         psplat_error *error);

/* ---- screenshot.c --------------------------------------------------------------------------- */

/* Draws the frame without overlay into a new file NAME-NNN.png, NAME being the first asset's. The
 * file goes to options.screenshots or beside the asset, or into the working directory where that
 * cannot be written. It never replaces a file. path gets its name. */
psplat_result screenshot_take(viewer *v, char *path, size_t size, psplat_error *error);

/* Writes the name of screenshot n of an asset: "dir/part.glb" gives "part-007.png", in directory
 * where that is not NULL, otherwise in "dir". Returns 0 where size is too small. */
int screenshot_name(const char *asset, const char *directory, int n, char *path, size_t size);
/* Writes the first of these files that does not exist, either whole or not at all. Returns 0 or an
 * errno. */
int screenshot_create(const char *asset, const char *directory, const uint8_t *png, size_t png_size,
                      char *path, size_t size);

/* ---- window.c: GLFW ------------------------------------------------------------------------- */

typedef struct window window;

/* Makes a window, whose events go to v, and makes its context current. Fails with GRAPHICS. */
window *window_create(viewer *v, const options *o, psplat_error *error);
void window_destroy(window *w); /* NULL is accepted */
/* Hands events to input.c. Waits for one, or until the timeout (seconds) has passed. */
void window_wait(window *w, double timeout);
void window_wake(void); /* ends window_wait; may be called on any thread */
void window_present(window *w);
void window_set_title(window *w, const char *text);
void window_size(const window *w, int *width, int *height); /* in pixels; 0 while minimised */
void window_toggle_full_screen(window *w);
int window_is_closing(const window *w);
void window_close(window *w); /* window_is_closing returns 1 from now on */
double window_seconds(void);
void *window_get_proc(void *user, const char *name);

/* ---- input.c: the table of keys ------------------------------------------------------------- */

typedef struct key_binding {
    int key, modifiers; /* of GLFW; key 0: a line of the help without a key of its own */
    const char *label;  /* NULL: not in the help, because a line nearby covers it */
    const char *help;
    void (*act)(viewer *v, int value);
    int value;
    int repeats; /* repeats while the key is held */
} key_binding;

extern const key_binding key_bindings[];
extern const size_t key_binding_count;

const key_binding *input_find(int key, int modifiers); /* returns NULL where the key is not bound */
void input_key(viewer *v, int key, int modifiers, int is_repeat);
/* The pointer moves by (x, y) window heights while a button (of GLFW) is held. */
void input_drag(viewer *v, int button, int modifiers, double x, double y);
/* The pointer is at (x, y) window heights from the middle of the window. */
void input_scroll(viewer *v, double steps, double x, double y);
void input_double_click(viewer *v, double x, double y);
void input_drop(viewer *v, const char *const *paths, size_t count);

/* ---- the viewer: main.c --------------------------------------------------------------------- */

struct viewer {
    options options;
    settings settings;
    window *window;
    psplat_renderer *renderer;
    canvas *canvas;
    loader *loader;
    psplat_environment *sky; /* NULL until it is first used */
    shown_assets shown;
    target fine; /* used where settings.is_smooth */
    orbit orbit;
    int has_help;      /* the overlay shows the keys */
    int needs_redraw;  /* something on the screen has changed */
    int is_cold;       /* how it is drawn has changed: the next frame is not timed */
    int was_busy;      /* whether the loader was, when last asked */
    double frame_time; /* smoothed, in seconds; 0: none drawn yet */
    char message[320]; /* shown by overlay_say */
    double message_end;
    char title[512];
    int is_title_late;              /* set too shortly ago to be set again */
    int animation;                  /* index of what plays */
    double played;                  /* its seconds so far */
    double play_time;               /* when it last went on */
    double title_time, turn_time;   /* when the title was set and the turntable last turned */
    psplat_tiles_state tiles_state; /* of all tilesets, in the last frame */
    double pick[2];                 /* where the double click was, for orbit_aim */
    int has_pick;
};

#endif
