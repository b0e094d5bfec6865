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

typedef struct viewer viewer;

/* A ball in the scene; radius 0: nothing there. */
typedef struct sphere {
    double center[3];
    double radius;
} sphere;

/* ---- settings.c: how to draw, as keys and options change it -------------------------------- */

typedef struct settings {
    int mode;     /* psplat_mode */
    int shading;  /* psplat_shading */
    int culling;  /* psplat_culling */
    int lights;   /* a rig of lights.c */
    int backdrop; /* of backdrop_names */
    int has_no_shadows;
    int has_no_filter;
    int has_environment;
    int is_orthographic;
    int is_smooth;  /* four samples a pixel */
    int is_turning; /* the turntable runs */
} settings;

/* Names for the command line, the title and messages; the lists end with NULL. Only modes that
 * show something to people are listed. */
extern const char *const mode_names[];
extern const char *const shading_names[];
extern const char *const culling_names[];
extern const char *const lights_names[];
extern const char *const backdrop_names[];

int names_count(const char *const *names);

/* ---- options.c: the command line ----------------------------------------------------------- */

typedef struct options {
    settings settings;
    int width, height;       /* of the window; 0: the default, scaled as the screen asks */
    int is_gles;             /* a GLES 3.0 context instead of GL 3.3 */
    const char *screenshots; /* directory; NULL: beside the asset */
    char **files;            /* file_count of them; moved to the end of argv */
    int file_count;
} options;

typedef enum parse_result { PARSE_OK, PARSE_HELP, PARSE_VERSION, PARSE_ERROR } parse_result;

/* For one call in a process: getopt_long keeps a state of its own. error gets the cause of
 * PARSE_ERROR. Prints nothing. */
parse_result options_parse(int argc, char **argv, options *o, psplat_error *error);
void options_print_help(void);

/* ---- report.c: the error line and the exit code -------------------------------------------- */

/* The codes of the command line of phongsplat, so that scripts need not tell them apart. */
int report_exit_code(psplat_result result);
/* Prints "phongsplat-viewer: subject: cause" (subject may be NULL) and returns the exit code. */
int report_error(const char *subject, const psplat_error *error);

/* ---- bounds.c ------------------------------------------------------------------------------ */

/* A sphere around what the asset's splats show: unlike psplat_asset_bounds it leaves out what
 * their clip lines cut away. */
sphere bounds_of(const psplat_asset *asset);

/* ---- loader.c: assets opened and watched on a worker thread ------------------------------- */

typedef struct loader loader;

typedef struct loaded_file {
    char *path;
    psplat_asset *asset; /* NULL: error says why */
    psplat_error error;
    sphere bounds; /* around the splats of asset */
    size_t splat_count;
} loaded_file;

/* Whether path names a file that can be read. */
psplat_result loader_check(const char *path, psplat_error *error);

/* Files that were opened together. */
typedef struct load {
    loaded_file *files;
    size_t count;
    int is_reload; /* some of the watched files; otherwise a new set */
    struct load *next;
} load;

/* wake is called on the worker's thread whenever loader_take has something to give. NULL where
 * there is no memory or no thread. */
loader *loader_create(void (*wake)(void));
/* Waits for the file that is being opened. NULL is accepted. */
void loader_destroy(loader *l);

/* Asks for a new set of files; copies the paths. A set asked for while another waits replaces it.
 * The files are watched from then on: one that changes and then rests for a moment is opened
 * again. Where none of a set can be opened the set before stays watched. 0 when out of memory. */
int loader_open(loader *l, const char *const *paths, size_t count);
void loader_reload(loader *l); /* of all watched files, changed or not */
int loader_is_busy(loader *l); /* with a new set */

/* The oldest finished load, owned by the caller; NULL where there is none. */
load *loader_take(loader *l);
void load_destroy(load *l); /* NULL is accepted */

/* ---- exhibit.c: what is shown ---------------------------------------------------------------- */

typedef struct exhibit_entry {
    char *path;
    psplat_model *model; /* NULL: never opened successfully */
    sphere bounds;
    size_t splat_count;
    psplat_error error; /* of the latest load; code 0: none */
} exhibit_entry;

typedef struct exhibit {
    psplat_renderer *renderer;
    exhibit_entry *entries;
    psplat_item *items; /* one per entry with a model */
    size_t entry_count, item_count;
    sphere bounds;
    size_t splat_count;
    int is_side_by_side; /* models in a row, equally large; otherwise where the files place them */
    char refused_path[256]; /* the file because of which a set was not shown; "": none */
    psplat_error refused;
} exhibit;

typedef enum exhibit_change { EXHIBIT_RELOADED, EXHIBIT_OPENED } exhibit_change;

/* Takes over what a load brings: models are uploaded, those they replace are freed. What cannot be
 * opened leaves what was shown before in place. */
exhibit_change exhibit_take(exhibit *e, load *l);
/* After is_side_by_side has changed. */
void exhibit_arrange(exhibit *e);
void exhibit_clear(exhibit *e);
/* The first error to tell of, and the file it concerns; NULL where all is well. */
const psplat_error *exhibit_error(const exhibit *e, const char **path);
const char *exhibit_name(const char *path); /* without directories */

/* ---- orbit.c: the camera ------------------------------------------------------------------- */

typedef struct orbit {
    double target[3];          /* what it turns about, in the middle of the picture */
    double azimuth, elevation; /* radians; 0, 0 looks along -z; y is up; elevation > 0 looks down */
    double distance;           /* of the eye from the target; > 0 */
    double reach;              /* radius of the scene; zoom goes from thousandths to thousands */
} orbit;

/* Looks at all of the scene from where it is. */
void orbit_fit(orbit *o, const sphere *scene, double aspect);
/* All moves are in heights of the window, x to the right and y up: those of the pointer. */
void orbit_turn(orbit *o, double x, double y);
void orbit_pan(orbit *o, double x, double y);
/* steps of the wheel, towards the scene if positive; what is under the point (x, y) from the
 * middle of the window stays there. */
void orbit_zoom(orbit *o, double steps, double x, double y);
/* Fills the matrices of view, whose width and height are set. Near and far planes enclose the
 * scene. */
void orbit_view(const orbit *o, const sphere *scene, int is_orthographic, psplat_view *view);
/* right, up and back: the camera's axes in the scene. */
void orbit_axes(const orbit *o, double axes[3][3]);
/* Makes the point seen at (x, y), in heights of the window from its middle, and at window depth
 * 0 ... 1 the target, and keeps the eye's distance from it. view is what orbit_view made. */
void orbit_aim(orbit *o, const psplat_view *view, double x, double y, double depth);

/* ---- lights.c: rigs of lights -------------------------------------------------------------- */

/* Fills lights and ambient of view for a rig of lights_names. */
void lights_set(int rig, int has_shadows, const orbit *o, const sphere *scene, psplat_view *view);

/* ---- sky.c: an environment ----------------------------------------------------------------- */

/* For psplat_environment_destroy; NULL where it failed. */
psplat_environment *sky_create(psplat_renderer *renderer, psplat_error *error);

/* ---- canvas.c: rectangles and text --------------------------------------------------------- */

/* In font pixels: of a glyph, descenders included, and from line to line. */
enum { FONT_HEIGHT = 9, FONT_LINE = 11 };

typedef struct gl gl;
typedef struct canvas canvas;

/* get_proc as in psplat_renderer_desc. */
canvas *canvas_create(void *(*get_proc)(void *user, const char *name), void *user,
                      psplat_error *error);
void canvas_destroy(canvas *c); /* NULL is accepted */
const gl *canvas_gl(const canvas *c);

/* Colours are sRGB-encoded RGBA as 0xRRGGBBAA; x, y in pixels from the upper left corner. */
void canvas_begin(canvas *c, int width, int height);
void canvas_rectangle(canvas *c, int x, int y, int width, int height, uint32_t top,
                      uint32_t bottom);
/* One line of printable ASCII; anything else is a question mark. size is the side of a font pixel,
 * in which canvas_text_width measures. */
void canvas_text(canvas *c, int x, int y, int size, uint32_t color, const char *text);
int canvas_text_width(const char *text);
void canvas_end(canvas *c); /* draws into the bound framebuffer; writes no depth */

/* ---- target.c: where else to draw ---------------------------------------------------------- */

/* Zeros: none. */
typedef struct target {
    unsigned framebuffer, color, depth; /* GL's names */
    int width, height;
    int is_complete;
} target;

/* Makes it anew where its size differs; 0 where GL cannot draw into it. Changes the bound
 * framebuffer. */
int target_resize(target *t, const gl *gl, int width, int height);
void target_free(target *t, const gl *gl);

/* ---- overlay.c: what is written over the picture ------------------------------------------ */

void overlay_draw(viewer *v, int width, int height);
/* Shows a message for some seconds. */
void overlay_say(viewer *v, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 2, 3)))
#endif
    ;

/* ---- title.c: the window's title ----------------------------------------------------------- */

/* "part.glb - 1,234 splats - phong, lit - 5.2 ms - phongsplat" */
void title_write(const viewer *v, char *text, size_t size);

/* ---- frame.c: one picture ------------------------------------------------------------------ */

/* Backdrop and splats into a framebuffer (0: the window), which is bound afterwards. */
psplat_result frame_draw(viewer *v, unsigned framebuffer, int width, int height,
                         psplat_error *error);

/* ---- screenshot.c -------------------------------------------------------------------------- */

/* Draws the frame without overlay into a new file NAME-NNN.png, NAME being the first asset's, in
 * options.screenshots or beside the asset or, where that cannot be written, in the working
 * directory. Never replaces a file. path gets its name. */
psplat_result screenshot_take(viewer *v, char *path, size_t size, psplat_error *error);

/* The name of number n for an asset: "dir/part.glb" gives "part-007.png", in directory where that
 * is not NULL, otherwise in "dir". Returns 0 where size is too small. */
int screenshot_name(const char *asset, const char *directory, int n, char *path, size_t size);
/* Writes the first of these files that does not exist, whole or not at all. 0 or an errno. */
int screenshot_create(const char *asset, const char *directory, const uint8_t *png, size_t png_size,
                      char *path, size_t size);

/* ---- window.c: GLFW ------------------------------------------------------------------------ */

typedef struct window window;

/* Makes the context current. v gets the events. Errors: GRAPHICS. */
window *window_create(viewer *v, const options *o, psplat_error *error);
void window_destroy(window *w); /* NULL is accepted */
/* Hands events to input.c; waits for one, or until the timeout (seconds) has passed. */
void window_wait(window *w, double timeout);
void window_wake(void); /* ends window_wait; on any thread */
void window_present(window *w);
void window_set_title(window *w, const char *text);
void window_size(const window *w, int *width, int *height); /* pixels; 0 while minimised */
void window_toggle_full_screen(window *w);
int window_is_closing(const window *w);
void window_close(window *w); /* window_is_closing from now on */
double window_seconds(void);
void *window_get_proc(void *user, const char *name);

/* ---- input.c: the table of keys ------------------------------------------------------------ */

typedef struct key_binding {
    int key, modifiers; /* of GLFW; key 0: a line of the help that names no key of its own */
    const char *label;  /* NULL: the help does not list it, a line nearby speaks for it */
    const char *help;
    void (*act)(viewer *v, int value);
    int value;
    int repeats; /* while the key is held */
} key_binding;

extern const key_binding key_bindings[];
extern const size_t key_binding_count;

const key_binding *input_find(int key, int modifiers); /* NULL: not bound */
void input_key(viewer *v, int key, int modifiers, int is_repeat);
/* The pointer moves by (x, y) window heights with a button (of GLFW) held. */
void input_drag(viewer *v, int button, int modifiers, double x, double y);
/* At (x, y) window heights from the middle of the window. */
void input_scroll(viewer *v, double steps, double x, double y);
void input_double_click(viewer *v, double x, double y);
void input_drop(viewer *v, const char *const *paths, size_t count);

/* ---- the viewer: main.c ------------------------------------------------------------------- */

struct viewer {
    options options;
    settings settings;
    window *window;
    psplat_renderer *renderer;
    canvas *canvas;
    loader *loader;
    psplat_environment *sky; /* NULL until it is asked for */
    exhibit exhibit;
    target fine; /* of settings.is_smooth */
    orbit orbit;
    int has_help;      /* the overlay shows the keys */
    int needs_redraw;  /* something on the screen has changed */
    int is_cold;       /* how it is drawn has changed: the next frame is not timed */
    int was_busy;      /* the loader, when last asked */
    double frame_time; /* seconds that frames take, smoothed; 0: none drawn yet */
    char message[320]; /* of overlay_say */
    double message_end;
    char title[512];
    int is_title_late;            /* it was changed too shortly ago to be changed again */
    double title_time, turn_time; /* when the title was set, the turntable last turned */
    double pick[2];               /* of a double click, for orbit_aim */
    int has_pick;
};

#endif
