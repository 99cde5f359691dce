/* voxels.c: see voxels.h. */
#include "render/ordinates/voxels.h"

#include <math.h>
#include <string.h>

#include "render/ordinates/corners.h"
#include "scene/media/field.h"
#include "scene/media/grid.h"

/* A look at a point takes about as long as it takes to fill a voxel, and a ray has some dozens. */
enum { PER_PIXEL = 32, MOST_VOXELS = 1 << 24 };

/* Where density is smooth, voxels per cell's edge, and per scale height: linear between them an
 * exponential is off by 1/8^3, 0.2 %. */
#define PER_CELL   2.0f
#define PER_HEIGHT 8.0f

/* Per voxel of a grid that lies across the world's axes, and per feature of the finest detail. */
#define PER_TURNED  2.0f
#define PER_FEATURE 3.0f

/* ---- where ---- */

/* Do a grid's axes lie along the world's, in their order? */
static bool is_straight(const float world_to_grid[12])
{
    bool straight = true;
    for (int row = 0; row < 3; row++) {
        for (int column = 0; column < 3; column++) {
            const float m = world_to_grid[row * 4 + column];
            straight = straight && (row == column ? m > 0.0f : m == 0.0f);
        }
    }
    return straight;
}

/* size voxels of edge edge_m from low on. */
static void set_axis(ord_voxels *v, int axis, float low, float edge_m, float size)
{
    for (int m = 0; m < ORD_MARCHES; m++) {
        v->volume[m].voxel_m[axis] = edge_m;
        v->volume[m].size[axis] = (size_t)float_max(size, 1.0f);
    }
    v->low[axis] = low;
    v->high[axis] = low + edge_m * float_max(size, 1.0f);
    v->step_m = axis == 0 ? edge_m : float_min(v->step_m, edge_m);
}

/* What tells cells and detail apart. */
static float fine_edge(const ord_domain *domain, const air_medium *medium)
{
    const float cell = domain->cell_m / PER_CELL;
    return air_medium_is_detailed(medium)
               ? float_min(cell, air_detail_finest(&medium->detail) / PER_FEATURE)
               : cell;
}

/* How many voxels are made of one of the grid's, which are too long: an odd number, so that what
 * lay at a centre does so still. */
static float parts_of(const ord_domain *domain, const air_medium *medium, float edge_m)
{
    const float parts = ceilf(edge_m / fine_edge(domain, medium) - 1e-3f);
    return float_max(1.0f, 2.0f * floorf(0.5f * parts) + 1.0f);
}

/* Voxels that are a part of the grid's own. */
static void lay_on_grid(const ord_domain *domain, const air_medium *medium, ord_voxels *v)
{
    size_t size[3];
    air_grid_size(medium->density_grid, size);
    for (int axis = 0; axis < 3; axis++) {
        const float scale = medium->world_to_grid[axis * 5],
                    shift = medium->world_to_grid[axis * 4 + 3];
        const float last = (float)(ptrdiff_t)size[axis] - 1.0f;
        const float extent = (float)(ptrdiff_t)domain->size[axis] * domain->cell_m;
        const float begin = floorf(domain->origin[axis] * scale + shift);
        const float end = ceilf((domain->origin[axis] + extent) * scale + shift);
        const float low = float_min(float_max(begin, 0.0f), last);
        const float high = float_min(float_max(end, low), last);
        const float parts = parts_of(domain, medium, 1.0f / scale);
        set_axis(v, axis, (low - 0.5f - shift) / scale, 1.0f / (scale * parts),
                 (high - low + 1.0f) * parts);
    }
}

/* Voxels of about this size over the part of the domain that the medium may be in. */
static void lay_over(const ord_domain *domain, const air_medium *medium, float edge_m,
                     ord_voxels *v)
{
    for (int axis = 0; axis < 3; axis++) {
        const float extent = (float)(ptrdiff_t)domain->size[axis] * domain->cell_m;
        const float low = float_max(domain->origin[axis], medium->bounds_min[axis]);
        const float high = float_min(domain->origin[axis] + extent, medium->bounds_max[axis]);
        const float long_m = float_max(high - low, 1e-3f * domain->cell_m);
        const float count = float_min(ceilf(long_m / edge_m), (float)MOST_VOXELS);
        set_axis(v, axis, low, long_m / count, count);
    }
}

/* The least edge of a grid's voxel in the world. */
static float grid_edge(const air_medium *medium)
{
    float index_to_world[12], least = INFINITY;
    if (!affine_invert(medium->world_to_grid, index_to_world)) {
        return 0.0f;
    }
    for (int axis = 0; axis < 3; axis++) {
        const air_vec3 edge =
            vec3(index_to_world[axis], index_to_world[4 + axis], index_to_world[8 + axis]);
        least = float_min(least, vec3_length(edge));
    }
    return least;
}

static float edge_of(const ord_domain *domain, const air_medium *medium)
{
    const float fine = fine_edge(domain, medium);
    switch (medium->kind) {
    case AIR_DENSITY_GRID:
        return float_min(fine, grid_edge(medium) / PER_TURNED);
    case AIR_DENSITY_EXPONENTIAL:
        return float_min(fine, 1.0f / (PER_HEIGHT * medium->inverse_scale_height));
    default:
        return fine;
    }
}

static bool is_grey(air_vec3 v) { return v.x == v.y && v.y == v.z; }

static bool is_coloured(const air_medium *medium)
{
    const bool one_channel =
        medium->kind != AIR_DENSITY_GRID || air_grid_channels(medium->density_grid) == 1;
    return !one_channel || medium->albedo_grid != NULL || !is_grey(medium->sigma_s) ||
           !is_grey(medium->sigma_t);
}

static air_vec3 solved_extinction(air_vec3 sigma_s, air_vec3 sigma_t, float peak)
{
    return vec3_madd(sigma_t, -peak, sigma_s);
}

static void set_power(const air_medium *medium, float peak, ord_voxels *v)
{
    const air_vec3 solved = solved_extinction(medium->sigma_s, medium->sigma_t, peak);
    float t[3], s[3];
    vec3_store(t, medium->sigma_t);
    vec3_store(s, solved);
    for (int c = 0; c < 3; c++) {
        v->power[c] = s[c] > 0.0f ? t[c] / s[c] : 1.0f;
    }
}

static size_t voxel_count(const ord_voxels *v)
{
    const size_t *const size = v->volume[0].size;
    return size[0] * size[1] * size[2];
}

static void lay_out(air_with_ordinates *with, const air_region *region, size_t most, ord_voxels *v)
{
    const air_medium *const medium = &with->snapshot->media.media[region->medium];
    const float edge = edge_of(&with->domain, medium);
    if (vec3_is_zero(medium->sigma_t) || !(edge > 0.0f)) {
        return;
    }
    if (medium->kind == AIR_DENSITY_GRID && is_straight(medium->world_to_grid)) {
        lay_on_grid(&with->domain, medium, v);
    } else {
        lay_over(&with->domain, medium, edge, v);
    }
    double count = 1.0;
    for (int axis = 0; axis < 3; axis++) {
        count *= (double)v->volume[0].size[axis];
    }
    if (count > (double)most) {
        memset(v, 0, sizeof *v);
        return;
    }
    for (int m = 0; m < ORD_MARCHES; m++) {
        v->volume[m].coloured = is_coloured(medium);
    }
}

air_status ord_voxels_lay_out(air_with_ordinates *with, size_t pixels)
{
    const air_media *const media = &with->snapshot->media;
    const size_t most = pixels < MOST_VOXELS / PER_PIXEL ? pixels * PER_PIXEL : MOST_VOXELS;
    with->voxels = air_allocate(with->context, media->region_count, sizeof *with->voxels);
    if (with->voxels == NULL) {
        return air_fail_memory(with->context, "ordinates: voxels");
    }
    for (size_t r = 0; r < media->region_count; r++) {
        lay_out(with, &media->regions[r], most, &with->voxels[r]);
    }
    return AIR_OK;
}

/* ---- what is in them ---- */

/* Is the medium's first light, or its true extinction, to be had from voxels of their own? */
static bool is_wanted(const air_with_ordinates *with, const air_medium *medium, ord_marched march)
{
    switch (march) {
    case ORD_SOLVED:
        return with->all;
    case ORD_FIRST:
        return with->single || medium->albedo_grid != NULL;
    default:
        return with->carries;
    }
}

static size_t stride_of(const air_volume *volume) { return volume->coloured ? 8 : 4; }

double ord_voxels_bytes(const air_with_ordinates *with)
{
    const air_media *const media = &with->snapshot->media;
    double sum = 0.0;
    for (size_t r = 0; r < media->region_count; r++) {
        const ord_voxels *const v = &with->voxels[r];
        double bytes = sizeof *v->empty;
        for (int m = 0; m < ORD_MARCHES; m++) {
            const air_medium *const medium = &media->media[media->regions[r].medium];
            const bool wanted = is_wanted(with, medium, (ord_marched)m);
            bytes += wanted ? (double)(stride_of(&v->volume[m]) * sizeof(float)) : 0.0;
        }
        sum += bytes * (double)voxel_count(v);
    }
    return sum;
}

/* A region being filled. */
typedef struct filling {
    const air_with_ordinates *with;
    const air_region *region;
    const air_medium *medium;
    const ord_medium *light;
    ord_voxels *voxels;
} filling;

static air_vec3 centre_of(const ord_voxels *v, size_t i, size_t j, size_t k)
{
    const float *const edge = v->volume[0].voxel_m;
    return vec3(v->low[0] + ((float)(ptrdiff_t)i + 0.5f) * edge[0],
                v->low[1] + ((float)(ptrdiff_t)j + 0.5f) * edge[1],
                v->low[2] + ((float)(ptrdiff_t)k + 0.5f) * edge[2]);
}

static void put_extinction(const air_volume *volume, size_t voxel, air_vec3 sigma_t)
{
    float *const at = volume->voxels + voxel * stride_of(volume);
    if (volume->coloured) {
        vec3_store(at + 4, sigma_t);
        at[7] = vec3_min(sigma_t);
    } else {
        at[3] = sigma_t.x;
    }
}

/* Of voxels of a row, from number `first` of it on. */
static void fill_run(const filling *f, size_t first, size_t count, size_t j, size_t k)
{
    const size_t *const size = f->voxels->volume[0].size;
    air_vec3 points[AIR_LOOKS];
    air_coefficients found[AIR_LOOKS];
    for (size_t i = 0; i < count; i++) {
        points[i] = centre_of(f->voxels, first + i, j, k);
    }
    air_medium_coefficients_run(f->medium, f->region, points, count, f->voxels->step_m, found);
    for (size_t i = 0; i < count; i++) {
        const air_coefficients *const c = &found[i];
        const air_vec3 solved = solved_extinction(c->sigma_s, c->sigma_t, f->light->peak);
        for (int m = 0; m < ORD_MARCHES; m++) {
            if (f->voxels->volume[m].voxels != NULL) {
                put_extinction(&f->voxels->volume[m], (k * size[1] + j) * size[0] + first + i,
                               m == ORD_SOLVED ? solved : c->sigma_t);
            }
        }
    }
}

static void fill_extinction(void *user, size_t k, size_t worker)
{
    const filling *const f = user;
    const size_t *const size = f->voxels->volume[0].size;
    (void)worker;
    for (size_t j = 0; j < size[1]; j++) {
        for (size_t first = 0; first < size[0]; first += AIR_LOOKS) {
            const size_t rest = size[0] - first;
            fill_run(f, first, rest < AIR_LOOKS ? rest : AIR_LOOKS, j, k);
        }
    }
}

/* What is sent over extinction, as albedo times light; 0 where nothing scatters. */
static void put_light(const air_volume *volume, size_t voxel, air_vec3 sigma_s, air_vec3 sigma_t,
                      const ord_corners *corners, const float *light)
{
    if (volume->voxels == NULL || light == NULL) {
        return;
    }
    float s[3], t[3], l[3];
    vec3_store(s, sigma_s);
    vec3_store(t, sigma_t);
    vec3_store(l, ord_corners_gather(corners, light));
    for (size_t c = 0; c < 3; c++) {
        volume->voxels[voxel * stride_of(volume) + c] = t[c] > 0.0f ? s[c] / t[c] * l[c] : 0.0f;
    }
}

/* The albedo is that at density 1: next to voxels that hold something it is needed where there is
 * nothing, too. */
static void fill_voxel_light(const filling *f, size_t i, size_t j, size_t k)
{
    const air_with_ordinates *const with = f->with;
    const size_t *const size = f->voxels->volume[0].size;
    const size_t voxel = (k * size[1] + j) * size[0] + i;
    const air_vec3 point = centre_of(f->voxels, i, j, k);
    const air_coefficients full = air_medium_full_coefficients(f->medium, point);
    const air_coefficients here = air_medium_coefficients(f->medium, f->region, point);
    const ord_corners corners = ord_corners_find(with, point, vec3_mean(here.sigma_t));
    const air_volume *const volume = f->voxels->volume;
    const air_vec3 solved = solved_extinction(full.sigma_s, full.sigma_t, f->light->peak);
    put_light(&volume[ORD_SOLVED], voxel, full.sigma_s, solved, &corners, f->light->light);
    put_light(&volume[ORD_FIRST], voxel, full.sigma_s, full.sigma_t, &corners, f->light->first);
    put_light(&volume[ORD_CARRIED], voxel, full.sigma_s, full.sigma_t, &corners, with->carried);
}

/* Is a voxel in the middle of a cube of nothing? Marches never look there. */
static bool is_unseen(const ord_voxels *v, size_t i, size_t j, size_t k)
{
    const size_t *const size = v->volume[0].size;
    const size_t x = i > 0 ? i - 1 : 0, y = j > 0 ? j - 1 : 0, z = k > 0 ? k - 1 : 0;
    return v->empty[(z * size[1] + y) * size[0] + x] >= 3;
}

static void fill_light(void *user, size_t k, size_t worker)
{
    const filling *const f = user;
    const size_t *const size = f->voxels->volume[0].size;
    (void)worker;
    for (size_t j = 0; j < size[1]; j++) {
        for (size_t i = 0; i < size[0]; i++) {
            if (!is_unseen(f->voxels, i, j, k)) {
                fill_voxel_light(f, i, j, k);
            }
        }
    }
}

static bool make_arrays(const filling *f)
{
    air_context *const context = f->with->context;
    ord_voxels *const v = f->voxels;
    bool made = true;
    v->empty = air_allocate(context, voxel_count(v), sizeof *v->empty);
    for (int m = 0; m < ORD_MARCHES; m++) {
        air_volume *const volume = &v->volume[m];
        volume->empty = v->empty;
        if (is_wanted(f->with, f->medium, (ord_marched)m)) {
            volume->voxels =
                air_allocate(context, voxel_count(v) * stride_of(volume), sizeof(float));
            made = made && volume->voxels != NULL;
        }
    }
    return made && v->empty != NULL;
}

/* Extinctions of all marches are 0 in the same places. */
static void find_empty(ord_voxels *v)
{
    for (int m = 0; m < ORD_MARCHES; m++) {
        if (v->volume[m].voxels != NULL) {
            air_volume_find_empty(&v->volume[m], v->empty);
            return;
        }
    }
}

air_status ord_voxels_fill(air_with_ordinates *with)
{
    const air_media *const media = &with->snapshot->media;
    for (size_t r = 0; r < media->region_count; r++) {
        ord_voxels *const v = &with->voxels[r];
        const air_region *const region = &media->regions[r];
        filling f = {with, region, &media->media[region->medium], &with->media[region->medium], v};
        if (voxel_count(v) == 0) {
            continue;
        }
        if (!make_arrays(&f)) {
            return air_fail_memory(with->context, "ordinates: voxels");
        }
        set_power(f.medium, f.light->peak, v);
        air_parallel_for(with->context, v->volume[0].size[2], fill_extinction, &f);
        find_empty(v);
        air_parallel_for(with->context, v->volume[0].size[2], fill_light, &f);
        if (!air_progress(with->context, 0.0, "light in voxels")) {
            return AIR_ERROR_INTERRUPTED;
        }
    }
    return AIR_OK;
}

void ord_voxels_finish(air_with_ordinates *with)
{
    for (size_t r = 0; with->voxels != NULL && r < with->snapshot->media.region_count; r++) {
        for (int m = 0; m < ORD_MARCHES; m++) {
            air_free(with->context, with->voxels[r].volume[m].voxels);
        }
        air_free(with->context, with->voxels[r].empty);
    }
    air_free(with->context, with->voxels);
    with->voxels = NULL;
}
