/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * stages.h - what the stages of psplat_convert hand to each other, in flow order. Internal: the
 * command line includes converter.h only.
 *
 *     mesh -> surface -> samples -> candidates -> selection -> splats -> report
 */
#ifndef PHONGSPLAT_STAGES_H
#define PHONGSPLAT_STAGES_H

#include "converter.h"
#include "paint.h"

#include <math.h>

#ifdef __cplusplus
extern "C" {
#endif

#define PSPLAT_NONE UINT32_MAX

/* ---- random.c ----------------------------------------------------------------------------- */

/* splitmix64 (Steele, Lea, Flood 2014): any seed is good, streams differ by their seed. */
uint64_t psplat_random_next(uint64_t *state);
double psplat_random_unit(uint64_t *state); /* 0 <= x < 1 */

/* ---- edges.c ------------------------------------------------------------------------------- */

/* For each edge 3 t + k of triangles (see below) the one other edge with the same ends, in either
 * direction, or PSPLAT_NONE: none or several. *borders: how many edges have one triangle. MEMORY is
 * the only failure. */
psplat_result psplat_edge_pairs(const psplat_mesh *mesh, uint32_t *pairs, size_t *borders);
/* From the start of an edge to its end. */
void psplat_edge_vector(const psplat_mesh *mesh, uint32_t edge, double vector[3]);

/* ---- surface.c, crease.c: connectivity, creases and smooth patches -------------------------- */

/* Edge k of a triangle runs from its corner k to its corner (k + 1) % 3. A crease edge bounds a
 * smooth patch: sharp, border, non-manifold, inconsistently oriented, or between two groups. */
typedef struct psplat_surface {
    const psplat_mesh *mesh;
    const psplat_paint *paint; /* NULL: the surface has no look, nor its samples */
    double *face_normals;      /* triangle_count x 3, unit */
    double *face_areas;        /* triangle_count */
    uint32_t *neighbors;       /* triangle_count x 3: triangle across the edge, or PSPLAT_NONE */
    uint8_t *creases;          /* triangle_count x 3 flags */
    uint32_t *patches;         /* triangle_count ids 0 ... patch_count - 1 */
    float *corner_normals;     /* triangle_count x 9: the file's, or averaged within creases */
    size_t patch_count;
    size_t crease_edges; /* half-edges counted once, borders not included */
    size_t border_edges;
    double roughness; /* root mean square of the dihedral angles inside patches */
    double area;
    double diagonal; /* of the bounding box of used vertices */
} psplat_surface;

/* crease_angle: dihedral angle from which an edge is a crease; PSPLAT_NO_CREASES leaves only what
 * has no neighbour to bound patches. */
#define PSPLAT_NO_CREASES HUGE_VAL
psplat_result psplat_surface_build(const psplat_mesh *mesh, double crease_angle,
                                   psplat_surface *surface, psplat_error *error);
void psplat_surface_free(psplat_surface *surface);

/* authored.c: flags of corners, whether the file has a credible normal there, and of edges, what
 * these normals say. authored: triangle_count x 3. MEMORY is the only failure. */
enum {
    PSPLAT_AUTHORED_NORMAL = 1,
    PSPLAT_AUTHORED_SMOOTH = 2,
    PSPLAT_AUTHORED_FADING = 4, /* hard at one end */
    PSPLAT_AUTHORED_HARD = 8
};
psplat_result psplat_authored_read(const psplat_surface *surface, uint8_t *authored);

/* relief.c: how edges bend, and how rough the surface is around triangles; see there. Angles in
 * radians; a bend is positive where the surface is convex. */
typedef struct psplat_relief {
    float *bends; /* triangle_count x 3 */
    float *noise; /* triangle_count: root mean square of the part that bends both ways */
    /* Without noise: */
    double *normals;   /* triangle_count x 3 */
    float *calm_bends; /* triangle_count x 3 */
    float *roughness;  /* triangle_count: root mean square of bends below the crease angle */
} psplat_relief;

/* MEMORY is the only failure; psplat_relief_free also then. */
psplat_result psplat_relief_measure(const psplat_surface *surface, double crease_angle,
                                    psplat_relief *relief);
void psplat_relief_free(psplat_relief *relief);

/* bend.c: a sharp edge is a crease, a likely one if its chain is long enough, a weak one if it is
 * connected to one, a faint one where it continues one. Whether an open edge is weak or faint is
 * asked when a crease reaches it. */
typedef enum psplat_bend {
    PSPLAT_BEND_SMOOTH = 0,
    PSPLAT_BEND_OPEN,
    PSPLAT_BEND_FAINT,
    PSPLAT_BEND_WEAK,
    PSPLAT_BEND_LIKELY,
    PSPLAT_BEND_SHARP,
    PSPLAT_BEND_GIVEN /* by the file; not judged */
} psplat_bend;

/* Of an edge that has a neighbour: SMOOTH, OPEN (it bends by weak_angle or more), LIKELY, SHARP. */
psplat_bend psplat_bend_judge(const psplat_surface *surface, const psplat_relief *relief,
                              uint32_t edge, double crease_angle, double weak_angle);
/* Of an open edge: SMOOTH, FAINT, WEAK. */
psplat_bend psplat_bend_judge_weak(const psplat_surface *surface, const psplat_relief *relief,
                                   uint32_t edge, double crease_angle, double weak_angle);

/* Marks an edge, and the same edge of its neighbour. */
void psplat_crease_set(psplat_surface *surface, uint32_t edge, uint8_t value);
/* follow.c: marks weak edges that touch creases and faint ones that continue them. kinds:
 * psplat_bend of edges; open ones are judged. MEMORY is the only failure. */
psplat_result psplat_crease_follow(psplat_surface *surface, const psplat_relief *relief,
                                   double crease_angle, double weak_angle, uint8_t *kinds);

/* Fills creases, patches and their counts of a surface whose neighbours are known. authored: of
 * psplat_authored_read. */
psplat_result psplat_crease_find(psplat_surface *surface, double crease_angle,
                                 const uint8_t *authored);

/* Barycentric coordinates of a point of a triangle. */
void psplat_surface_barycentric(const psplat_surface *surface, uint32_t triangle,
                                const double point[3], double barycentric[3]);
/* Interpolated unit normal at barycentric coordinates of a triangle. */
void psplat_surface_normal(const psplat_surface *surface, uint32_t triangle,
                           const double barycentric[3], float normal[3]);

/* ---- samples.c ---------------------------------------------------------------------------- */

/* Oriented points of a surface. Those of triangle t are order[first[t] ... first[t + 1] - 1]. */
typedef struct psplat_samples {
    double *positions; /* count x 3 */
    float *normals;    /* count x 3, unit */
    /* What the surface's paint says varies; NULL where it does not (psplat_shade): */
    float *colors;   /* count x 4 */
    float *turned;   /* count x 3, unit: normals as normal maps turn them */
    float *finishes; /* count x 3 */
    float *emissive; /* count x 3 */
    uint32_t *triangles;
    uint32_t *first; /* triangle_count + 1 */
    uint32_t *order; /* count */
    size_t count;
    double spacing; /* distance between neighbours, about */
} psplat_samples;

/* Blue-noise samples about spacing apart, and samples at half of that along creases, for each
 * side of its own. RANGE where they would be more than 32 bits count. A surface without creases
 * that is much smaller than the spacing may get none. */
psplat_result psplat_samples_draw(const psplat_surface *surface, double spacing, uint64_t seed,
                                  psplat_samples *samples, psplat_error *error);
/* count independent uniform samples: for measuring. */
psplat_result psplat_samples_draw_uniform(const psplat_surface *surface, size_t count,
                                          uint64_t seed, psplat_samples *samples,
                                          psplat_error *error);
/* Appends samples at points (count x 3) of triangles; those there before keep their indices. */
psplat_result psplat_samples_append(psplat_samples *samples, const psplat_surface *surface,
                                    const double *points, const uint32_t *triangles, size_t count,
                                    psplat_error *error);
void psplat_samples_free(psplat_samples *samples);

/* ---- adapter_cgal.cpp --------------------------------------------------------------------- */

/* count uniform random points of a triangle (CGAL::Random_points_in_triangle_3), deterministic in
 * seed. points: count x 3. */
psplat_result psplat_cgal_triangle_points(const double a[3], const double b[3], const double c[3],
                                          size_t count, uint32_t seed, double *points);

/* Distance queries against a mesh (CGAL::AABB_tree). NULL when out of memory. */
typedef struct psplat_distance psplat_distance;
psplat_distance *psplat_distance_create(const psplat_mesh *mesh);
/* Distances of count points (x 3) to the mesh. */
psplat_result psplat_distance_query(const psplat_distance *distance, const double *points,
                                    size_t count, double *result);
/* The point of the mesh that is nearest to one, and its triangle. */
psplat_result psplat_distance_nearest(const psplat_distance *distance, const double point[3],
                                      double nearest[3], uint32_t *triangle);
/* Whether the segment between two points meets the front of a triangle on its way. */
psplat_result psplat_distance_meets(const psplat_distance *distance, const double from[3],
                                    const double to[3], int *meets);
/* Whether all points lie within a distance of the mesh: faster than asking how far they are. */
psplat_result psplat_distance_within(const psplat_distance *distance, const double *points,
                                     size_t count, double tolerance, int *within);
void psplat_distance_destroy(psplat_distance *distance);

/* ---- fit.c: the numerics -------------------------------------------------------------------- */

/* Eigenvalues (ascending) and unit eigenvectors (rows) of the symmetric matrix
 * xx xy xz yy yz zz, by Jacobi rotations. */
void psplat_fit_eigen(const double matrix[6], double values[3], double vectors[3][3]);

/* Linear normal field (spec 3.5) of an ellipse with these radii, least-norm where the samples leave
 * it open. uv: count x 2 parameters, xy: count x 2 local normals with third coordinate 1. field: x,
 * y, alpha, beta, gamma; without gradients where the bound of spec 3.5 would not hold with them. */
void psplat_fit_normals(const double (*uv)[2], const double (*xy)[2], size_t count,
                        const double radius[2], double field[5]);
/* Local normal (x, y) of a field at (u, v): spec eq. 2. */
void psplat_fit_normal_at(const double field[5], const double radius[2], const double uv[2],
                          double xy[2]);

/* ---- covariance.c: sums over oriented points (PSG03 section 4) --------------------------------
 */

/* Parts of sum x x^T over x = (p, n, 1); p relative to a local origin. Zero-initialise. */
typedef struct psplat_covariance {
    double count;
    double p[3], n[3];
    double pp[6];    /* xx xy xz yy yz zz */
    double np[3][3]; /* rows: components of n */
} psplat_covariance;

/* A least-squares plane: mean, axes of the points' spread in it (u the longer one) and normal, a
 * right-handed frame, and the variances along u, v, n. */
typedef struct psplat_plane {
    double mean[3];
    double u[3], v[3], n[3];
    double variance[3];
} psplat_plane;

void psplat_covariance_add(psplat_covariance *covariance, const double p[3], const double n[3]);
/* Adds the sums of other: the covariance of the union. */
void psplat_covariance_unite(psplat_covariance *covariance, const psplat_covariance *other);
/* The sums of the same points relative to an origin farther by d. */
void psplat_covariance_move(psplat_covariance *covariance, const double d[3]);

/* The plane through the points, on the side of their mean normal; perpendicular to it where they
 * do not span a plane. count must be positive. */
void psplat_covariance_fit(const psplat_covariance *covariance, psplat_plane *plane);

/* Directions and sizes of principal curvature from the gradient of normals over the plane:
 * direction (in u, v, unit, of curvature[0]), |curvature[0]| >= |curvature[1]|. 0 where there is
 * none to be told. */
int psplat_covariance_curvature(const psplat_covariance *covariance, const psplat_plane *plane,
                                double direction[2], double curvature[2]);

/* ---- neighborhood.c: samples around a seed ----------------------------------------------------
 */

/* The distance of p is |rows (p - center)|. */
typedef struct psplat_metric {
    double center[3];
    double rows[3][3];
} psplat_metric;

typedef struct psplat_ranked {
    uint32_t key; /* that sorts as the squared distance does */
    uint32_t index;
} psplat_ranked;

typedef struct psplat_near_sample {
    double p[3], n[3]; /* relative to the origin; unit */
    uint32_t index;
} psplat_near_sample;

/* What was gathered last. Scratch of one thread for one surface: zero-initialise, grows on demand.
 */
typedef struct psplat_neighborhood {
    psplat_near_sample *samples; /* nearest first */
    size_t count;
    uint32_t *creases; /* edges (3 x triangle + side) that stopped the flood */
    size_t crease_count;
    int whole; /* these are all of the patch that is connected with the seed */
    double origin[3];
    psplat_ranked *order, *sorted; /* of samples; scratch */
    psplat_covariance *blocks;
    uint32_t *stamps; /* per triangle: flood that met it last */
    uint32_t stamp;
    uint32_t *triangles;
    size_t triangle_count, triangle_capacity, order_capacity, sorted_capacity, sample_capacity,
        crease_capacity;
} psplat_neighborhood;

/* Collects the samples within reach of the metric's centre that are connected with a triangle
 * within reach, without crossing a crease; without samples (NULL), only the creases. 0 when out of
 * memory. */
int psplat_neighborhood_gather(psplat_neighborhood *neighborhood, const psplat_surface *surface,
                               const psplat_samples *samples, const psplat_metric *metric,
                               uint32_t triangle, double reach);
/* How many of the samples lie within reach, which is at most that of the last gathering. */
size_t psplat_neighborhood_within(const psplat_neighborhood *neighborhood, double reach);
/* Sums over the nearest count samples. */
void psplat_neighborhood_covariance(const psplat_neighborhood *neighborhood, size_t count,
                                    psplat_covariance *covariance);
void psplat_neighborhood_free(psplat_neighborhood *neighborhood);

/* ---- region.c: a convex part of a plane ------------------------------------------------------ */

/* An ellipse of a plane cut by lines, as a splat is; lines in (u, v) as in spec 3.6. */
typedef struct psplat_region {
    double center[3];
    double u[3], v[3], n[3];
    double radius[2];
    double lines[PSPLAT_MAX_CLIP_LINES][3];
    uint32_t line_count;
} psplat_region;

/* Parameters (u, v) and height of a point. */
void psplat_region_local(const psplat_region *region, const double point[3], double uvh[3]);
/* Whether (u, v) lies in the region, its ellipse scaled by scale, its lines moved out by slack. */
int psplat_region_contains(const psplat_region *region, const double uv[2], double scale,
                           double slack);
/* Vertices (u, v) of the region as a polygon of at most capacity corners around the unit circle
 * (inscribed: on the circle; else circumscribed), cut by the lines. Returns their number. */
size_t psplat_region_polygon(const psplat_region *region, int inscribed, double (*polygon)[2],
                             size_t capacity);

/* Area of the inscribed polygon of 64 sides, cut by the lines. */
double psplat_region_area(const psplat_region *region);
/* Points all over a region: its middle, the corners of its outline, and others halfway. points has
 * room for PSPLAT_REGION_POINTS. Returns their number. */
#define PSPLAT_REGION_POINTS 145
size_t psplat_region_points(const psplat_region *region, double (*points)[3]);
/* Whether these points lie within the tolerance of the mesh; 1 without a distance. */
psplat_result psplat_region_near(const psplat_region *region, const psplat_distance *distance,
                                 double tolerance, int *near);

/* ---- segments.c ---------------------------------------------------------------------------- */

/* Part of a crease inside a region: its ends as (u, v, height), the surface to its left. */
typedef struct psplat_segment {
    double a[3], b[3];
    uint32_t vertex[2]; /* the crease edge's ends, before clipping */
    uint32_t across;    /* triangle on the other side, or PSPLAT_NONE */
} psplat_segment;

/* The parts inside the region of crease edges (3 x triangle + side) whose triangles face its way
 * and that come within a height of its plane. segments has room for all. Returns their number. */
size_t psplat_segments_find(const psplat_surface *surface, const uint32_t *creases,
                            size_t crease_count, const psplat_region *region, double height,
                            psplat_segment *segments);

/* ---- clip.c -------------------------------------------------------------------------------- */

/* Chooses up to four lines that keep the seed (u, v) and cut away every crease segment, letting
 * the region reach over a crease by at most slack (in the plane's units; radius scales (u, v) to
 * them). 1 on success, 0 where four lines do not suffice. */
int psplat_clip_choose(psplat_region *region, const psplat_segment *segments, size_t count,
                       const double seed[2], double slack);

/* ---- candidate.c --------------------------------------------------------------------------- */

/* What a splat must keep. Lengths in the mesh's units. */
typedef struct psplat_limits {
    double tolerance;        /* splat to surface, along the splat's normal */
    double crease_tolerance; /* the same along creases, so that crease lines stay lines */
    double crease_slack;     /* reach over a crease, within the plane */
    double margin;           /* overlap beyond the covered samples */
    double normal_tolerance; /* greatest error of the normal field, radians; 0: none */
    int constant_normals;    /* fields without gradients */
    double color_tolerance; /* greatest root mean square of a splat's colour error, sRGB; 0: none */
    int constant_colors;    /* colours without gradients */
    const psplat_precision *precision; /* what lines and fields are rounded to; NULL: not at all */
    const psplat_distance
        *distance; /* to the mesh; NULL: only the triangles of samples are asked */
} psplat_limits;

/* A possible splat and the samples that it covers. */
typedef struct psplat_candidate {
    psplat_region region;
    double field[5];  /* x, y, alpha, beta, gamma */
    double deviation; /* greatest distance from the samples covered */
    float color[4];   /* by psplat_tint, as the finish */
    psplat_finish finish;
    uint32_t triangle; /* that the candidate grew from */
    uint32_t *covered; /* sample indices, covered_count; the seed among them */
    size_t covered_count;
    int taken;   /* 0: only in the pool */
    int widened; /* by psplat_candidate_widen */
    int snapped; /* by psplat_candidate_snap */
} psplat_candidate;

/* Scratch of one thread. Zero-initialise. */
typedef struct psplat_growth {
    psplat_neighborhood near;
    double (*uvh)[3];                /* of near's samples in the region judged last */
    uint32_t *chosen;                /* those covered, indices into near */
    uint32_t *next;                  /* of near's samples, in their cell */
    double (*local)[2], (*plane)[2]; /* their parameters and normals */
    psplat_segment *segments;
    size_t capacity, segment_capacity;
} psplat_growth;

void psplat_growth_free(psplat_growth *growth);
/* Calls visit with each index below count and a scratch, on all cores. MEMORY, where one returns
 * it, is the only failure. */
psplat_result psplat_growth_each(size_t count,
                                 psplat_result (*visit)(void *user, size_t index,
                                                        psplat_growth *growth),
                                 void *user);

/* Grows the largest candidate around a sample that keeps the limits: first in a round metric,
 * then in that of the curvature found (WK04). A candidate always exists: in the worst case it
 * covers the seed alone. MEMORY is the only failure. */
psplat_result psplat_candidate_grow(const psplat_surface *surface, const psplat_samples *samples,
                                    const psplat_limits *limits, uint32_t seed,
                                    psplat_growth *growth, psplat_candidate *candidate);
/* enclose.c: a candidate around the samples of a set, near this plane (relative to origin) of
 * theirs, made as large as the limits allow. Covers nothing where they allow none. MEMORY is the
 * only failure. */
psplat_result psplat_candidate_enclose(const psplat_surface *surface, const psplat_samples *samples,
                                       const psplat_limits *limits, const uint32_t *set,
                                       size_t count, const double origin[3],
                                       const psplat_plane *plane, psplat_growth *growth,
                                       psplat_candidate *candidate);
/* widen.c: makes both axes of a candidate longer by up to a quarter, then each once more, as far as
 * the limits allow; what it covers stays on record as it is. */
psplat_result psplat_candidate_widen(const psplat_surface *surface, const psplat_samples *samples,
                                     const psplat_limits *limits, psplat_growth *growth,
                                     psplat_candidate *candidate);
/* snap.c: moves a candidate to the grid of the limits' precision, as little as they allow; it may
 * then cover less, and in the worst case is a disc next to one of its samples, which covers that
 * alone and lies as near as PSPLAT_GREATEST_PRECISION lets it. MEMORY is the only failure. */
psplat_result psplat_candidate_snap(const psplat_surface *surface, const psplat_samples *samples,
                                    const psplat_limits *limits, psplat_growth *growth,
                                    psplat_candidate *candidate);
/* Finds the samples that an existing candidate covers, after samples were appended. */
psplat_result psplat_candidate_cover(const psplat_surface *surface, const psplat_samples *samples,
                                     const psplat_limits *limits, psplat_growth *growth,
                                     psplat_candidate *candidate);
void psplat_candidate_free(psplat_candidate *candidate);

/* ---- select.c, improve.c: candidates that cover every sample ----------------------------------
 */

/* A pool of candidates, some of them taken. */
typedef struct psplat_selection {
    psplat_candidate *candidates;
    size_t count, capacity;
} psplat_selection;

/* Moves a candidate to the end of the selection. 0 when out of memory. */
int psplat_selection_push(psplat_selection *selection, psplat_candidate *candidate);
/* Grows a candidate around each of count seeds, on all cores, and pushes them in order, not taken.
 */
psplat_result psplat_selection_grow(const psplat_surface *surface, const psplat_samples *samples,
                                    const psplat_limits *limits, const uint32_t *seeds,
                                    size_t count, psplat_selection *selection);
/* Forgets candidates that are not taken. */
void psplat_selection_settle(psplat_selection *selection);
void psplat_selection_free(psplat_selection *selection);

/* Takes candidates, old ones and new, until every sample is covered: greedy cover over a growing
 * pool (WK04 section 4). What is taken already stays. */
psplat_result psplat_select_cover(const psplat_surface *surface, const psplat_samples *samples,
                                  const psplat_limits *limits, const psplat_convert_desc *desc,
                                  psplat_selection *selection, psplat_error *error);

typedef struct psplat_improvement {
    const psplat_samples *samples;
    size_t moves; /* 0: only drops what is not needed */
    size_t focus; /* moves start at samples from this index on; the number of samples: anywhere */
    int axis;     /* 0 1 2: across which the work is cut */
    uint64_t seed;
    int strict; /* only moves that save a candidate; else also those that change places */
} psplat_improvement;

/* Exchanges candidates so that fewer cover the same samples. Never takes more than before, nor
 * leaves a sample uncovered that was covered. MEMORY is the only failure. */
psplat_result psplat_improve(psplat_selection *selection, const psplat_improvement *what);
/* How many candidates are taken. */
size_t psplat_selection_taken(const psplat_selection *selection);

/* ---- tint.c -------------------------------------------------------------------------------- */

/* Means over samples in a region: what a linear fit to their values starts from. */
typedef struct psplat_moments {
    double count, mean[2], spread[3]; /* of (u, v); about the mean: uu uv vv */
    int gradients;                    /* 0: fits are constant */
} psplat_moments;

void psplat_moments_of(const double (*uv)[2], size_t count, int gradients, psplat_moments *moments);
/* value(u, v) = fitted[0] + u fitted[1] + v fitted[2] of values with this mean; along: sums of
 * values times (u, v) from their mean. */
void psplat_moments_solve(const psplat_moments *moments, double mean, const double along[2],
                          double fitted[3]);

/* Gives taken candidates colours and finishes, those of the samples they cover; gradients: colours
 * may change over a splat. MEMORY is the only failure. */
psplat_result psplat_tint(const psplat_samples *samples, int gradients,
                          psplat_selection *selection);

/* ---- frame.c ------------------------------------------------------------------------------- */

/* The rotation whose columns are u, v, n; w >= 0. */
void psplat_quaternion_of(const double u[3], const double v[3], const double n[3],
                          float rotation[4]);
/* The plane region of a stored splat, in double. */
void psplat_splat_region(const psplat_splat *splat, psplat_region *region);

/* ---- store.c ------------------------------------------------------------------------------- */

/* The plane regions of stored splats, in double; malloc'ed, NULL when out of memory. */
psplat_region *psplat_splat_regions(const psplat_splats *splats);

/* Flat are splats that leave the surface by less than half of flat_depth_tolerance. */
typedef struct psplat_storing {
    float depth_tolerance, flat_depth_tolerance;
    const uint32_t *groups; /* by triangle: the materials; NULL: all are 0 */
    int has_color, has_finish;
} psplat_storing;

/* The selection in its stored form: single precision, sorted by clip lines, flat ones first, by
 * materials, and then along a Morton curve. Fills splats, finishes, runs, their counts and
 * has_color; what of these there was is freed. */
psplat_result psplat_store_splats(const psplat_selection *selection, const psplat_storing *storing,
                                  psplat_splats *splats);

/* ---- fold.c -------------------------------------------------------------------------------- */

/* Colours and finishes that all splats of a material share become its factors; finishes of which
 * then nothing is left go. MEMORY is the only failure. */
psplat_result psplat_fold(psplat_splats *splats);

/* ---- locate.c: which regions are near a point ------------------------------------------------ */

typedef struct psplat_locator psplat_locator;
/* reach: distance around each region at which it is found. The regions are not kept. NULL when out
 * of memory. */
psplat_locator *psplat_locator_create(const psplat_region *regions, size_t count, double reach);
/* Calls visit with the index of each region whose box, grown by reach, holds the point, until visit
 * returns other than 0. */
void psplat_locator_visit(const psplat_locator *locator, const double point[3],
                          int (*visit)(void *user, uint32_t region), void *user);
/* The same for regions whose box, grown by reach, meets another box. */
void psplat_locator_visit_box(const psplat_locator *locator, const double low[3],
                              const double high[3], int (*visit)(void *user, uint32_t region),
                              void *user);
void psplat_locator_destroy(psplat_locator *locator);

/* ---- join.c -------------------------------------------------------------------------------- */

/* Moves clip lines out to where the plane meets those of the candidates across the crease, so that
 * neighbouring faces close. */
psplat_result psplat_join_lines(const psplat_surface *surface, const psplat_limits *limits,
                                psplat_selection *selection);

/* ---- convert.c ----------------------------------------------------------------------------- */

/* What a conversion is made of. */
typedef struct psplat_conversion {
    const psplat_convert_desc *desc;
    psplat_mesh shown; /* what masks leave of the mesh; empty: it has none */
    psplat_surface surface;
    psplat_paint paint;
    psplat_samples samples;
    psplat_limits limits;
    psplat_distance *distance;
    psplat_selection selection;
    psplat_splats *splats;
    double tolerance; /* in the mesh's units */
    double finest;    /* spacing of samples that suffices everywhere; the same */
    double percent;   /* tolerance as a part of diagonal */
    double diagonal;
} psplat_conversion;

/* Builds the surface and sets the limits of c, which holds desc: all that does not depend on
 * samples. psplat_conversion_free must follow, also where it fails. */
psplat_result psplat_conversion_begin(psplat_conversion *c, const psplat_mesh *mesh,
                                      psplat_error *error);
/* Frees all but the splats. */
void psplat_conversion_free(psplat_conversion *c);
/* How often the selection is improved. */
int psplat_improving_rounds(const psplat_convert_desc *desc);

/* ---- precision.c --------------------------------------------------------------------------- */

/* The grid that suits the tolerance and the candidates taken, as desc->precision wants it; zeros
 * where it wants floats, or no grid is fine enough. */
psplat_precision psplat_precision_choose(const psplat_conversion *c);
/* Rounds all of stored splats to their precision. */
void psplat_precision_apply(psplat_splats *splats);

/* ---- spacing.c ----------------------------------------------------------------------------- */

/* Draws samples as dense as the limits make splats small, and sets the limits' margin. */
psplat_result psplat_sample(psplat_conversion *c, psplat_error *error);

/* ---- relax.c ------------------------------------------------------------------------------- */

/* Adds to the pool: candidates around what each taken one alone covers, and around what each two
 * neighbours alone cover where one splat can. MEMORY is the only failure. */
psplat_result psplat_relax(psplat_conversion *c);

/* ---- repair.c ------------------------------------------------------------------------------ */

/* Finds holes between the splats taken, makes points in them samples to cover, and covers these,
 * until there is none. The splats are those taken, stored. */
psplat_result psplat_repair_holes(psplat_conversion *c, psplat_error *error);

/* ---- measured.c ---------------------------------------------------------------------------- */

/* How a splat blends: its normals n(u, v) = normals[0] + u normals[1] + v normals[2] (spec 3.5), in
 * the space of its region, and its weight. */
typedef struct psplat_field {
    double normals[3][3];
    double colors[3][3]; /* the same of colours (spec 3.10), with the material's factor, */
    double factor[3];    /* which they may not exceed */
    psplat_kernel kernel;
    double depth; /* epsilon of spec 5.3 along its normal */
} psplat_field;

/* Stored splats, ready to be measured. */
typedef struct psplat_measured {
    psplat_region *regions; /* count */
    psplat_field *fields;   /* count */
    size_t count;
    psplat_locator *locator;
    double tolerance; /* wider than promised by rounding */
} psplat_measured;

/* reach: how far from a point its splats may be. No depth of a field hides anything. MEMORY is the
 * only failure. */
psplat_result psplat_measured_create(const psplat_splats *splats, double tolerance, double reach,
                                     psplat_measured *measured);
void psplat_measured_free(psplat_measured *measured);
/* Whether a splat covers a surface point with this normal; uvh: the point in the splat's region. A
 * splat of the other side of a thin part does not. */
int psplat_measured_covers(const psplat_measured *measured, uint32_t splat, const double normal[3],
                           const double uvh[3]);
/* The normal fields of a splat in its region, and the normal at (u, v), of any length. */
void psplat_field_of(const psplat_splat *splat, const psplat_region *region, psplat_field *field);
void psplat_field_normal(const psplat_field *field, const double uv[2], double normal[3]);

/* ---- nearest.c ----------------------------------------------------------------------------- */

/* Distance of a point to a region; HUGE_VAL where its lines leave nothing. */
double psplat_region_distance(const psplat_region *region, const double point[3]);
/* Distance of a point to the nearest of count regions, which the locator finds; HUGE_VAL: there is
 * none. expected > 0: about how far, to begin with. */
double psplat_nearest_distance(const psplat_region *regions, size_t count,
                               const psplat_locator *locator, double expected,
                               const double point[3]);

/* ---- look.c -------------------------------------------------------------------------------- */

/* What one who faces a surface at a point of it sees of the splats there (spec 5.1 to 5.4). */
typedef struct psplat_look {
    const psplat_measured *measured;
    double point[3], normal[3]; /* unit */
    double reach;               /* fragments farther along the normal do not count, */
    double limit; /* nor those below this height: they are hidden; at first -HUGE_VAL */
    double blended[3], constant[3]; /* sums (6) of normals, with and without gradients; 0 0 0:
                                       nothing is seen */
    double color[3], flat_color[3]; /* the same of colours */
    double weight;                  /* sum of weights */
} psplat_look;

/* Raises the limit to what a splat leaves to be seen, where it shows its front. */
void psplat_look_limit(psplat_look *look, uint32_t splat);
/* Adds a splat's fragment. */
void psplat_look_add(psplat_look *look, uint32_t splat);

/* ---- holes.c ------------------------------------------------------------------------------- */

/* Points of the surface that no splat covers, and the triangles they are on. */
typedef struct psplat_holes {
    double *points; /* count x 3 */
    uint32_t *triangles;
    size_t count, capacity;
} psplat_holes;

/* Finds holes wider than about `fine` between splats, one in each cube of side `coarse` (lengths)
 * that has any, and points of a point set that are not covered. In the order of triangles,
 * whatever the number of threads. MEMORY is the only failure. */
psplat_result psplat_holes_find(const psplat_surface *surface, const psplat_measured *measured,
                                double coarse, double fine, psplat_holes *holes);
void psplat_holes_free(psplat_holes *holes);

/* ---- crossing.c ---------------------------------------------------------------------------- */

/* A crease that lies inside a splat of its own patch. */
typedef struct psplat_crossing {
    uint32_t edge; /* 3 * triangle + k of the crease, on the splat's side */
    uint32_t splat;
    double depth;    /* greatest distance of the crease, in the splat's plane, from its outline */
    double point[3]; /* of the crease, where that is */
} psplat_crossing;

/* Finds the crossings deeper than limit, in the order of their edges and splats, into *crossings
 * (malloc'ed, owned by the caller), and the greatest depth of any. samples tell which patch a splat
 * covers most of: creases of others do not concern it. MEMORY is the only failure. */
psplat_result psplat_crossings_find(const psplat_surface *surface, const psplat_samples *samples,
                                    const psplat_measured *measured, double limit,
                                    psplat_crossing **crossings, size_t *count, double *greatest);

/* ---- verify.c ------------------------------------------------------------------------------ */

typedef struct psplat_verification {
    const psplat_surface *surface;
    const psplat_splats *splats;
    const psplat_distance *distance; /* to the mesh */
    double tolerance_percent;
    double diagonal;                 /* that percentages are of */
    double normal_tolerance_degrees; /* 0: none was promised */
    uint64_t seed;                   /* of the samples, another than that of the fitted ones */
} psplat_verification;

/* Measures the splats against the surface on samples of its own, and fills the errors, promises and
 * places of report. */
psplat_result psplat_verify(const psplat_verification *verification, psplat_report *report,
                            psplat_error *error);

#ifdef __cplusplus
}
#endif
#endif
