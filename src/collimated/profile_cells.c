/* profile_cells.c: the optical depth along a ray through a piecewise constant medium.
 *
 * The depth camera - point - light is a sum over convex cells of sigma_t times the length inside.
 * Both lengths are piecewise affine in t. So: gather every t at which some cell's length may bend
 * or jump, sort, and let each cell add its part to the stretches between. Which faces bound a cell
 * is decided at the middle of a stretch and evaluated at its ends: exact at jumps, which happen
 * where the light runs along a face. */
#include "collimated/envelope.h"
#include "collimated/pieces.h"
#include "collimated/planes.h"

/* One cell, seen from a ray and the light: from the point at t the way to the light is inside from
 * the greatest of 0 and the entries to the least of the exits. Entries are kept negative, so that
 * both are minima and the length is the sum of the two. */
typedef struct cell_view {
    air_interval ray;   /* where the ray itself is inside */
    air_interval shade; /* where the way to the light has a part inside */
    size_t exit_count, entry_count;
    air_line exits[AIR_COLLIMATED_MAX_PLANES], entries[AIR_COLLIMATED_MAX_PLANES + 1];
} cell_view;

/* Keeps of a stretch what satisfies nv t <= no. Most planes cut nothing off: no division then. */
static inline void clip(air_interval *stretch, double no, double nv)
{
    if (no - nv * stretch->begin >= 0.0 && no - nv * stretch->end >= 0.0) {
        return;
    }
    if (nv > 0.0) {
        stretch->end = double_min(stretch->end, no / nv);
    } else if (nv < 0.0) {
        stretch->begin = double_max(stretch->begin, no / nv);
    } else if (!(no >= 0.0)) {
        stretch->end = -INFINITY;
    }
}

static bool is_empty(air_interval stretch) { return !(stretch.begin < stretch.end); }

/* nv t + nl d <= no, d along the light. */
typedef struct lit_plane {
    double no, nv, nl;
} lit_plane;

/* The way to the light is inside somewhere iff each exit lies behind 0 and behind each entry:
 * (no_k - nv_k t)/nl_k > (no_j - nv_j t)/nl_j with nl_k > 0 > nl_j. */
static void clip_shade(air_interval *shade, const lit_plane *exits, size_t exit_count,
                       const lit_plane *entries, size_t entry_count)
{
    for (size_t k = 0; k < exit_count; k++) {
        const lit_plane x = exits[k];
        clip(shade, x.no, x.nv);
        for (size_t j = 0; j < entry_count && !is_empty(*shade); j++) {
            const lit_plane e = entries[j];
            clip(shade, e.no * x.nl - x.no * e.nl, e.nv * x.nl - x.nv * e.nl);
        }
    }
}

/* The light matters only on the part of the ray that scatters. */
static void cell_view_make(const air_collimated_cell *cell, const double to_light[3],
                           const double origin[3], const double dir[3], air_interval scattering,
                           cell_view *out)
{
    const air_collimated_medium *medium = &cell->medium;
    lit_plane exits[AIR_COLLIMATED_MAX_PLANES], entries[AIR_COLLIMATED_MAX_PLANES];
    size_t exit_count = 0, entry_count = 0;
    out->ray = (air_interval){0.0, scattering.end};
    out->shade = cell->sigma_t > 0.0 ? scattering : (air_interval){0.0, 0.0};
    for (size_t k = 0; k < medium->plane_count; k++) {
        const double *n = medium->planes[k], nl = air_plane_facing(n, to_light);
        const lit_plane plane = {n[3] - air_dot3(n, origin), air_dot3(n, dir), nl};
        clip(&out->ray, plane.no, plane.nv);
        if (nl > 0.0) {
            exits[exit_count++] = plane;
        } else if (nl < 0.0) {
            entries[entry_count++] = plane;
        } else {
            clip(&out->shade, plane.no, plane.nv);
        }
    }
    clip_shade(&out->shade, exits, exit_count, entries, entry_count);
    out->exit_count = out->entry_count = 0;
    if (is_empty(out->shade)) {
        return;
    }
    for (size_t k = 0; k < exit_count; k++) {
        const double inverse = 1.0 / exits[k].nl;
        out->exits[out->exit_count++] = (air_line){exits[k].no * inverse, -exits[k].nv * inverse};
    }
    for (size_t k = 0; k < entry_count; k++) {
        const double inverse = 1.0 / entries[k].nl;
        out->entries[out->entry_count++] =
            (air_line){-entries[k].no * inverse, entries[k].nv * inverse};
    }
    out->entries[out->entry_count++] = (air_line){0.0, 0.0};
}

/* Views of this many cells are made once per ray, those of further ones twice; 12 KB of stack. */
enum { KEPT_VIEWS = 8 };

/* Candidates wait in the t0 of the pieces. */
static void add_candidate(air_collimated_profile *profile, double t)
{
    profile->pieces[profile->count++].t0 = t;
}

/* Where the lowest line changes within a stretch. */
static void add_bends(air_collimated_profile *profile, const air_line *lines, size_t count,
                      air_interval stretch)
{
    double t = stretch.begin;
    for (size_t line = air_envelope_lowest(lines, count, t);;) {
        line = air_envelope_next(lines, count, line, t, &t);
        if (line == count || !(t < stretch.end)) {
            return;
        }
        add_candidate(profile, t);
    }
}

/* At most plane_count + 4: two for the ray, two for the shade; n lines bend at most n - 1 times,
 * and there are as many as planes, and the entry at 0. The ends of the scattering part are there
 * already, in place of those of the cells that give them. */
static void add_candidates(air_collimated_profile *profile, const cell_view *view,
                           air_interval scattering)
{
    const double ends[4] = {view->ray.begin, view->ray.end, view->shade.begin, view->shade.end};
    for (int i = 0; i < 4; i += 2) {
        if (ends[i] < ends[i + 1]) {
            if (ends[i] > scattering.begin && ends[i] < scattering.end) {
                add_candidate(profile, ends[i]);
            }
            if (ends[i + 1] > scattering.begin && ends[i + 1] < scattering.end) {
                add_candidate(profile, ends[i + 1]);
            }
        }
    }
    if (!is_empty(view->shade)) {
        if (view->exit_count > 0) {
            add_bends(profile, view->exits, view->exit_count, view->shade);
        }
        add_bends(profile, view->entries, view->entry_count, view->shade);
    }
}

/* Shell's sort of the candidates. */
static void sort_candidates(air_collimated_piece *pieces, size_t count)
{
    size_t gap = 1;
    while (gap < count / 9) {
        gap = 3 * gap + 1;
    }
    for (; gap > 0; gap /= 3) {
        for (size_t i = gap; i < count; i++) {
            const double t = pieces[i].t0;
            size_t k = i;
            for (; k >= gap && pieces[k - gap].t0 > t; k -= gap) {
                pieces[k].t0 = pieces[k - gap].t0;
            }
            pieces[k].t0 = t;
        }
    }
}

/* Turns the sorted candidates into empty pieces. A last one without end, in which cells of
 * extinction sigma_t_endless go on for ever, ends where nothing comes through any more. */
static void make_stretches(air_collimated_profile *profile, double sigma_t_endless)
{
    air_collimated_piece *pieces = profile->pieces;
    size_t count = 0;
    for (size_t i = 0; i + 1 < profile->count; i++) {
        const double t0 = pieces[i].t0;
        double t1 = pieces[i + 1].t0;
        if (t1 == INFINITY) {
            t1 = sigma_t_endless > 0.0 ? t0 + AIR_COLLIMATED_OPAQUE / sigma_t_endless : t0;
        }
        if (t0 < t1) {
            pieces[count++] = (air_collimated_piece){.t0 = t0, .t1 = t1};
        }
    }
    profile->count = count;
}

/* What a cell adds to one stretch. */
static inline void add_cell(air_collimated_piece *p, const cell_view *view, double sigma_t,
                            double weight)
{
    const double middle = 0.5 * (p->t0 + p->t1);
    if (middle > view->ray.begin && !is_empty(view->ray)) {
        const bool inside = middle < view->ray.end;
        p->camera0 += sigma_t * ((inside ? p->t0 : view->ray.end) - view->ray.begin);
        p->camera1 += sigma_t * ((inside ? p->t1 : view->ray.end) - view->ray.begin);
        p->weight += inside ? weight : 0.0;
    }
    if (middle > view->shade.begin && middle < view->shade.end) {
        if (view->exit_count == 0) {
            p->depth0 = p->depth1 = INFINITY;
            return;
        }
        const air_line exit =
            view->exits[air_envelope_lowest(view->exits, view->exit_count, middle)];
        const air_line entry =
            view->entries[air_envelope_lowest(view->entries, view->entry_count, middle)];
        p->depth0 +=
            sigma_t * double_max(0.0, air_line_at(exit, p->t0) + air_line_at(entry, p->t0));
        p->depth1 +=
            sigma_t * double_max(0.0, air_line_at(exit, p->t1) + air_line_at(entry, p->t1));
    }
}

/* Keeps the stretches that have weight and see the light; until here depth0 and depth1 are the way
 * to the light only. */
static void keep_pieces(air_collimated_profile *profile)
{
    size_t count = 0;
    for (size_t i = 0; i < profile->count; i++) {
        air_collimated_piece p = profile->pieces[i];
        p.depth0 += p.camera0;
        p.depth1 += p.camera1;
        if (p.weight > 0.0 && p.depth0 < INFINITY && p.depth1 < INFINITY) {
            profile->pieces[count++] = p;
        }
    }
    profile->count = count;
}

static bool cells_valid(const air_collimated_cell *cells, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (!(cells[i].sigma_t >= 0.0 && cells[i].sigma_t < INFINITY && cells[i].weight >= 0.0 &&
              cells[i].weight < INFINITY)) {
            return false;
        }
    }
    return true;
}

size_t air_collimated_cells_piece_limit(const air_collimated_cell *cells, size_t count)
{
    size_t limit = 0;
    for (size_t i = 0; i < count; i++) {
        limit += cells[i].medium.plane_count + 4;
    }
    return limit;
}

/* From the first to the last point on the ray that has weight. */
static air_interval scattering_part(const air_collimated_cell *cells, size_t count,
                                    const double origin[3], const double dir[3], double t_max)
{
    air_interval part = {INFINITY, 0.0}, inside;
    for (size_t i = 0; i < count; i++) {
        if (cells[i].weight > 0.0 &&
            air_collimated_interval(&cells[i].medium, origin, dir, t_max, &inside)) {
            part.begin = double_min(part.begin, inside.begin);
            part.end = double_max(part.end, inside.end);
        }
    }
    return part;
}

void air_collimated_profile_make_cells(const air_collimated_cell *cells, size_t count,
                                       const double to_light[3], const double origin[3],
                                       const double dir[3], double t_max,
                                       air_collimated_profile *profile)
{
    cell_view views[KEPT_VIEWS + 1]; /* the last serves all further cells in turn */
    double sigma_t_endless = 0.0;
    air_profile_clear(profile);
    if (!air_finite3(to_light) || !cells_valid(cells, count)) {
        return;
    }
    const air_interval scattering = scattering_part(cells, count, origin, dir, t_max);
    if (is_empty(scattering)) {
        return;
    }
    add_candidate(profile, scattering.begin);
    add_candidate(profile, scattering.end);
    for (size_t i = 0; i < count; i++) {
        cell_view *view = &views[i < KEPT_VIEWS ? i : KEPT_VIEWS];
        cell_view_make(&cells[i], to_light, origin, dir, scattering, view);
        add_candidates(profile, view, scattering);
        sigma_t_endless +=
            !is_empty(view->ray) && view->ray.end == INFINITY ? cells[i].sigma_t : 0.0;
    }
    sort_candidates(profile->pieces, profile->count);
    make_stretches(profile, sigma_t_endless);
    for (size_t i = 0; i < count; i++) {
        cell_view *view = &views[i < KEPT_VIEWS ? i : KEPT_VIEWS];
        if (i >= KEPT_VIEWS) {
            cell_view_make(&cells[i], to_light, origin, dir, scattering, view);
        }
        if (!is_empty(view->ray) || !is_empty(view->shade)) {
            for (size_t k = 0; k < profile->count; k++) {
                add_cell(&profile->pieces[k], view, cells[i].sigma_t, cells[i].weight);
            }
        }
    }
    keep_pieces(profile);
    air_profile_sum(profile);
}
