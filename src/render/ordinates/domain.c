#include "render/ordinates/domain.h"

#include <math.h>
#include <string.h>

#include "core/phase.h"
#include "scene/media/field.h"
#include "scene/media/grid.h"

/* Looks per cell along each axis: enough for borders that cut cells. */
enum { LOOKS = 4 };

/* Parts of a grid are left out if light that crosses as much as the whole medium of them has at
 * most this optical depth. */
#define LEAST_DEPTH 1e-4f

/* Their box is rounded outwards to a lattice in the world, at least so many times as fine as the
 * medium is long, so that it rarely moves in a sequence of grids. */
#define LATTICE 32.0f

typedef struct bounds {
    float low[3], high[3];
} bounds;

static bounds medium_bounds(const air_medium *medium)
{
    bounds out = {{0.0f}, {0.0f}};
    memcpy(out.low, medium->bounds_min, sizeof out.low);
    memcpy(out.high, medium->bounds_max, sizeof out.high);
    return out;
}

/* Of a box in the grid's index space. */
static bounds world_bounds(const float index_to_world[12], const float low[3], const float high[3])
{
    bounds out = {{0.0f}, {0.0f}};
    for (int corner = 0; corner < 8; corner++) {
        float at[3];
        const air_vec3 index =
            vec3((corner & 1) != 0 ? high[0] : low[0], (corner & 2) != 0 ? high[1] : low[1],
                 (corner & 4) != 0 ? high[2] : low[2]);
        vec3_store(at, affine_point(index_to_world, index));
        for (int axis = 0; axis < 3; axis++) {
            out.low[axis] = corner > 0 ? float_min(out.low[axis], at[axis]) : at[axis];
            out.high[axis] = corner > 0 ? float_max(out.high[axis], at[axis]) : at[axis];
        }
    }
    return out;
}

/* Cuts a grid medium's bounds to where it has density: many grids are mostly margin. False: it has
 * none. */
static bool cut_to_density(const air_medium *medium, bounds *box)
{
    float low[3], high[3], index_to_world[12], longest = 0.0f, square = 0.0f;
    for (int axis = 0; axis < 3; axis++) {
        const float extent = box->high[axis] - box->low[axis];
        longest = float_max(longest, extent);
        square += extent * extent;
    }
    const float depth = vec3_max(medium->sigma_t) * sqrtf(square);
    if (!isfinite(depth) || !(depth > 0.0f) ||
        !affine_invert(medium->world_to_grid, index_to_world)) {
        return true;
    }
    if (!air_grid_support(medium->density_grid, LEAST_DEPTH / depth, low, high)) {
        return false;
    }
    const bounds dense = world_bounds(index_to_world, low, high);
    const float step = exp2f(floorf(log2f(longest / LATTICE)));
    for (int axis = 0; axis < 3; axis++) {
        const float least = floorf(dense.low[axis] / step) * step;
        const float most = ceilf(dense.high[axis] / step) * step;
        const bool within = medium->boundary != AIR_BOUNDARY_UNBOUNDED;
        box->low[axis] = within ? float_max(box->low[axis], least) : least;
        box->high[axis] = within ? float_min(box->high[axis], most) : most;
        if (!(box->low[axis] < box->high[axis])) {
            return false;
        }
    }
    return true;
}

/* The bounds of what scatters or absorbs, of grids where they have density (`dense`); false if
 * nothing does. */
static bool find_bounds(const air_media *media, bool dense, bounds *out)
{
    bool found = false;
    for (size_t i = 0; i < media->count; i++) {
        const air_medium *medium = &media->media[i];
        bounds box = medium_bounds(medium);
        if (vec3_is_zero(medium->sigma_t) ||
            (dense && medium->kind == AIR_DENSITY_GRID && !cut_to_density(medium, &box))) {
            continue;
        }
        for (int axis = 0; axis < 3; axis++) {
            out->low[axis] = found ? float_min(out->low[axis], box.low[axis]) : box.low[axis];
            out->high[axis] = found ? float_max(out->high[axis], box.high[axis]) : box.high[axis];
        }
        found = true;
    }
    return found;
}

/* Borders of media that are within so much of a cell's border are on it. */
#define ON_BORDER 1e-3f

/* Rounding of coordinates: of bounds a thousand voxels from the origin, ten times over. */
#define WHOLE_VOXEL 1e-3f

/* A box of its own: `cells` along the longest side, in the middle of the cells of the others. */
static void place_anew(ord_domain *domain, uint32_t cells, const bounds *box, float longest)
{
    domain->cell_m = longest / (float)cells;
    for (int axis = 0; axis < 3; axis++) {
        const float extent = box->high[axis] - box->low[axis];
        const float count = ceilf(extent / domain->cell_m - ON_BORDER);
        domain->size[axis] = count >= 1.0f ? (size_t)count : 1;
        const float whole = (float)(ptrdiff_t)domain->size[axis] * domain->cell_m;
        domain->origin[axis] = box->low[axis] - 0.5f * (whole - extent);
        domain->lattice.base[axis] = domain->origin[axis];
    }
    domain->lattice.cell_m = domain->cell_m;
    domain->lattice.cells = cells;
}

/* Of the number of cells asked for, before a lattice is given up. */
static const float lattice_least = 0.8f, lattice_most = 1.25f;

static bool lattice_serves(const ord_lattice *lattice, uint32_t cells, float longest)
{
    const float share = lattice != NULL && lattice->cells == cells
                            ? longest / (lattice->cell_m * (float)cells)
                            : 0.0f;
    return share >= lattice_least && share <= lattice_most;
}

/* By whole voxels of a grid? Grids are cut to what they hold: their bounds may move so while what
 * they hold stays. */
static bool cut_elsewhere(const air_media *media, const float moved[3])
{
    bool whole = false;
    for (size_t i = 0; i < media->count && !whole; i++) {
        if (media->media[i].kind == AIR_DENSITY_GRID) {
            const float *const to_voxels = media->media[i].world_to_grid;
            const air_vec3 v = affine_vector(to_voxels, vec3_load(moved));
            whole = fabsf(v.x - roundf(v.x)) <= WHOLE_VOXEL &&
                    fabsf(v.y - roundf(v.y)) <= WHOLE_VOXEL &&
                    fabsf(v.z - roundf(v.z)) <= WHOLE_VOXEL;
        }
    }
    return whole;
}

/* Moves the lattice along with media: with their bounds, if these keep their size. Bounds of what
 * is in grids do not tell, for they are rounded. */
static void follow(ord_lattice *lattice, const air_media *media, const bounds *whole)
{
    bool same = true;
    float moved[3];
    for (int axis = 0; axis < 3; axis++) {
        const float before = lattice->high[axis] - lattice->low[axis];
        const float change = fabsf(whole->high[axis] - whole->low[axis] - before);
        same = same && change <= ON_BORDER * lattice->cell_m;
        moved[axis] = whole->low[axis] - lattice->low[axis];
    }
    same = same && !cut_elsewhere(media, moved);
    for (int axis = 0; axis < 3 && same; axis++) {
        lattice->base[axis] += moved[axis];
    }
}

static void place_on(ord_domain *domain, const ord_lattice *lattice, const bounds *box,
                     const bounds *whole)
{
    domain->lattice = *lattice;
    domain->cell_m = lattice->cell_m;
    domain->goes_on = true;
    follow(&domain->lattice, domain->media, whole);
    for (int axis = 0; axis < 3; axis++) {
        const float base = domain->lattice.base[axis];
        const float begin = floorf((box->low[axis] - base) / domain->cell_m + ON_BORDER);
        const float end = ceilf((box->high[axis] - base) / domain->cell_m - ON_BORDER);
        domain->size[axis] = end > begin ? (size_t)(end - begin) : 1;
        domain->origin[axis] = base + begin * domain->cell_m;
    }
}

static air_status place(ord_domain *domain, uint32_t cells, const ord_lattice *lattice)
{
    bounds box = {{0.0f}, {0.0f}}, whole = {{0.0f}, {0.0f}};
    float longest = 0.0f;
    const bool any = find_bounds(domain->media, false, &whole);
    /* Grids that are all empty have their box, too: a sequence may begin so. */
    if (!find_bounds(domain->media, true, &box)) {
        box = whole;
    }
    if (!any) {
        return air_fail(domain->context, AIR_ERROR_ARGUMENT, "ordinates: no medium scatters light");
    }
    for (int axis = 0; axis < 3; axis++) {
        longest = float_max(longest, box.high[axis] - box.low[axis]);
    }
    if (!(longest > 0.0f) || !isfinite(longest)) {
        return air_fail(domain->context, AIR_ERROR_ARGUMENT,
                        "ordinates: the media measure %g m: expected a size above 0",
                        (double)longest);
    }
    if (lattice_serves(lattice, cells, longest)) {
        place_on(domain, lattice, &box, &whole);
    } else {
        place_anew(domain, cells, &box, longest);
    }
    memcpy(domain->lattice.low, whole.low, sizeof whole.low);
    memcpy(domain->lattice.high, whole.high, sizeof whole.high);
    domain->cells = domain->size[0] * domain->size[1] * domain->size[2];
    return AIR_OK;
}

/* Cells are cubes: what is thinner than some of them is spread over all of their thickness. */
static void warn_of_thin_media(const ord_domain *domain)
{
    for (size_t i = 0; i < domain->media->count; i++) {
        const air_medium *const medium = &domain->media->media[i];
        float least = INFINITY;
        for (int axis = 0; axis < 3; axis++) {
            least = float_min(least, medium->bounds_max[axis] - medium->bounds_min[axis]);
        }
        if (!vec3_is_zero(medium->sigma_s) && least < 2.0f * domain->cell_m) {
            air_warn(domain->context,
                     "ordinates: medium \"%s\" is %.3g m thick, less than two cells of %.3g m: "
                     "its light will be wrong, expected more cells or method path",
                     medium->name, (double)least, (double)domain->cell_m);
        }
    }
}

/* ---- coefficients ---- */

typedef struct look {
    air_vec3 sigma_s, sigma_t, weighted; /* weighted: sigma_s times mean cosine */
} look;

static void add_look(ord_domain *domain, size_t cell, const look *seen)
{
    const float s[3] = {seen->sigma_s.x, seen->sigma_s.y, seen->sigma_s.z};
    const float t[3] = {seen->sigma_t.x, seen->sigma_t.y, seen->sigma_t.z};
    const float w[3] = {seen->weighted.x, seen->weighted.y, seen->weighted.z};
    for (size_t c = 0; c < 3; c++) {
        domain->sigma_s[c * domain->cells + cell] += s[c];
        domain->sigma_a[c * domain->cells + cell] += float_max(t[c] - s[c], 0.0f);
        domain->g[c * domain->cells + cell] += w[c];
    }
}

/* Looks side by side along x at the same media, the first being number `first` of its row. */
typedef struct look_run {
    uint64_t regions;
    size_t row, first, count; /* row: index of the row's first cell */
    air_vec3 points[AIR_LOOKS];
} look_run;

static void take_run(ord_domain *domain, look_run *run)
{
    const air_media *const media = domain->media;
    air_coefficients found[AIR_LOOKS];
    look seen[AIR_LOOKS];
    memset(seen, 0, run->count * sizeof *seen);
    for (uint64_t rest = run->regions; rest != 0 && run->count > 0; rest &= rest - 1) {
        const air_region *region = &media->regions[__builtin_ctzll(rest)];
        const air_medium *medium = &media->media[region->medium];
        const float cosine = (float)phase_legendre(medium->phase, 1);
        air_medium_coefficients_run(medium, region, run->points, run->count, domain->cell_m / LOOKS,
                                    found);
        for (size_t i = 0; i < run->count; i++) {
            seen[i].sigma_s = vec3_add(seen[i].sigma_s, found[i].sigma_s);
            seen[i].sigma_t = vec3_add(seen[i].sigma_t, found[i].sigma_t);
            seen[i].weighted = vec3_madd(seen[i].weighted, cosine, found[i].sigma_s);
        }
    }
    for (size_t i = 0; i < run->count; i++) {
        add_look(domain, run->row + (run->first + i) / LOOKS, &seen[i]);
    }
    run->count = 0;
}

/* A line along x through a row of cells: the media on it are laid out once. */
static void look_along(ord_domain *domain, size_t j, size_t k, float y, float z)
{
    const float step = domain->cell_m / LOOKS;
    const air_vec3 origin =
        ord_domain_world(domain, vec3(-domain->cell_m, y * domain->cell_m, z * domain->cell_m));
    const float length = (float)(ptrdiff_t)(domain->size[0] + 2) * domain->cell_m;
    air_segment segments[AIR_MAX_SEGMENTS];
    look_run run = {.row = (k * domain->size[1] + j) * domain->size[0]};
    const size_t count =
        air_media_segments(domain->media, origin, vec3(1.0f, 0.0f, 0.0f), length, segments);
    for (size_t s = 0, n = 0; n < domain->size[0] * LOOKS; n++) {
        const float t = domain->cell_m + ((float)(ptrdiff_t)n + 0.5f) * step;
        while (s < count && segments[s].t1 <= t) {
            s++;
        }
        const uint64_t regions = s < count && segments[s].t0 <= t ? segments[s].regions : 0;
        if (regions != run.regions || run.count == AIR_LOOKS) {
            take_run(domain, &run);
        }
        if (regions != 0) {
            run.first = run.count == 0 ? n : run.first;
            run.points[run.count++] = vec3(origin.x + t, origin.y, origin.z);
        }
        run.regions = regions;
    }
    take_run(domain, &run);
}

static void look_into_slab(void *user, size_t k, size_t worker)
{
    ord_domain *const domain = user;
    const float scale = 1.0f / (LOOKS * LOOKS * LOOKS);
    (void)worker;
    for (size_t j = 0; j < domain->size[1]; j++) {
        for (int n = 0; n < LOOKS * LOOKS; n++) {
            look_along(domain, j, k,
                       (float)(ptrdiff_t)j + ((float)(n % LOOKS) + 0.5f) / (float)LOOKS,
                       (float)(ptrdiff_t)k + ((float)(n / LOOKS) + 0.5f) / (float)LOOKS);
        }
    }
    for (size_t c = 0; c < 3; c++) {
        const size_t slab = domain->size[0] * domain->size[1];
        for (size_t i = 0; i < slab; i++) {
            const size_t at = c * domain->cells + k * slab + i;
            const float s = domain->sigma_s[at];
            domain->g[at] = s > 0.0f ? domain->g[at] / s : 0.0f;
            domain->sigma_s[at] = s * scale;
            domain->sigma_a[at] *= scale;
        }
    }
}

air_status ord_domain_place(const air_snapshot *snapshot, uint32_t cells,
                            const ord_lattice *lattice, ord_domain *out)
{
    memset(out, 0, sizeof *out);
    out->context = snapshot->context;
    out->media = &snapshot->media;
    return place(out, cells, lattice);
}

air_status ord_domain_fill(ord_domain *out)
{
    air_context *const context = out->context;
    out->sigma_s = air_allocate(out->context, 3 * out->cells, sizeof(float));
    out->sigma_a = air_allocate(out->context, 3 * out->cells, sizeof(float));
    out->g = air_allocate(out->context, 3 * out->cells, sizeof(float));
    if (out->sigma_s == NULL || out->sigma_a == NULL || out->g == NULL) {
        ord_domain_finish(out);
        return air_fail_memory(context, "ordinates: cells");
    }
    warn_of_thin_media(out);
    air_parallel_for(context, out->size[2], look_into_slab, out);
    return AIR_OK;
}

void ord_domain_finish(ord_domain *domain)
{
    air_free(domain->context, domain->sigma_s);
    air_free(domain->context, domain->sigma_a);
    air_free(domain->context, domain->g);
    memset(domain, 0, sizeof *domain);
}
