/* SPDX-License-Identifier: MIT
 *
 * draw_frame.c - draws one picture: the backdrop, then the splats as the settings say.
 */
#include "viewer_gl.h"
#include "viewer.h"

/* Upper and lower colour (sRGB, RGBA), in the order of backdrop_names. */
static const uint32_t backdrops[][2] = {
    {0x3a424cff, 0x16191dff},
    {0xf6f7f9ff, 0xc4cad2ff},
    {0x000000ff, 0x000000ff},
    {0xffffffff, 0xffffffff},
};

static void draw_backdrop(viewer *v, int width, int height) {
    const gl *gl = canvas_gl(v->canvas);
    const uint32_t *colors = backdrops[v->settings.backdrop];
    gl->Viewport(0, 0, width, height);
    gl->ClearColor(0, 0, 0, 1);
    gl->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    canvas_begin(v->canvas, width, height);
    canvas_rectangle(v->canvas, 0, 0, width, height, colors[0], colors[1]);
    canvas_end(v->canvas);
}

/* Dims the rig's lights under the sky, which is the better ambient light and bright enough by
 * itself. */
static void dim_lights(psplat_view *view) {
    for (int i = 0; i < 3; ++i) {
        view->ambient[i] = 0;
        for (int k = 0; k < view->light_count; ++k) view->lights[k].color[i] *= 0.3f;
    }
}

static psplat_view view_of(const viewer *v, int width, int height) {
    const settings *s = &v->settings;
    psplat_view view = {
        .width = width,
        .height = height,
        .mode = (psplat_mode)s->mode,
        .shading = (psplat_shading)s->shading,
        .culling = (psplat_culling)s->culling,
        .no_filter = s->has_no_filter,
        .environment = s->has_environment ? v->sky : NULL,
    };
    orbit_view(&v->orbit, &v->shown.bounds, s->is_orthographic, &view);
    lights_set(s->lights, !s->has_no_shadows, &v->orbit, &v->shown.bounds, &view);
    if (view.environment) dim_lights(&view);
    return view;
}

/* Makes the camera turn about the point that a double click hit. Nothing changes where it hit the
 * backdrop. */
static void pick(viewer *v, const psplat_view *view) {
    const gl *gl = canvas_gl(v->canvas);
    float depth = 1;
    int x = (int)(0.5 * view->width + v->pick[0] * view->height);
    int y = (int)((0.5 + v->pick[1]) * view->height);
    v->has_pick = 0;
    if (v->options.is_gles) return; /* GLES cannot read depth */
    gl->ReadPixels(x, y, 1, 1, GL_DEPTH_COMPONENT, GL_FLOAT, &depth);
    if (depth >= 1) return;
    orbit_aim(&v->orbit, view, v->pick[0], v->pick[1], (double)depth);
    v->needs_redraw = 1;
}

/* samples is how many pixels of the picture are one of the window's, in each direction. */
static psplat_result draw(viewer *v, int width, int height, int samples, psplat_error *error) {
    draw_backdrop(v, width, height);
    if (shown_assets_are_empty(&v->shown)) {
        v->has_pick = 0; /* there is nothing to pick */
        return PSPLAT_OK;
    }
    const psplat_item *items = NULL;
    size_t count = 0;
    psplat_view view = view_of(v, width, height);
    psplat_result result = shown_tiles_choose(v, &view, samples, &items, &count, error);
    if (!result && count) result = psplat_draw(v->renderer, &view, items, count, error);
    if (!result && v->has_pick) pick(v, &view);
    return result;
}

/* Smooth drawing uses twice as many pixels each way. A linear filter that halves the picture takes
 * the mean of four pixels. It averages encoded colours, which makes edges a little darker than they
 * should be. Where GL cannot have so large a target, the picture is drawn without it. */
psplat_result frame_draw(viewer *v, unsigned framebuffer, int width, int height,
                         psplat_error *error) {
    const gl *gl = canvas_gl(v->canvas);
    int is_fine = v->settings.is_smooth && target_resize(&v->fine, gl, 2 * width, 2 * height);
    int n = is_fine ? 2 : 1;
    gl->BindFramebuffer(GL_FRAMEBUFFER, is_fine ? v->fine.framebuffer : framebuffer);
    psplat_result result = draw(v, n * width, n * height, n, error);
    if (is_fine) {
        gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
        gl->BlitFramebuffer(0, 0, 2 * width, 2 * height, 0, 0, width, height, GL_COLOR_BUFFER_BIT,
                            GL_LINEAR);
    }
    gl->BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    return result;
}
