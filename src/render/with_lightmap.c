#include "render/with_lightmap.h"

#include "core/harmonics.h"
#include "lightmap/check.h"
#include "render/lightmap_fit.h"
#include "scene/fingerprint.h"

/* The planes of one page that are looked at; borrowed. */
typedef struct page_planes {
    size_t width, height;
    const float *layers[AIR_LAYER_COUNT][3];
    const float *harmonics[AIR_DIRECTIONAL_COEFFICIENTS][3]; /* in the order of y_lm */
} page_planes;

struct air_with_lightmap {
    air_context *context;
    const air_path *path;
    const air_snapshot *snapshot;
    const air_lightmap *lightmap;
    uint32_t terms;
    page_planes *pages;
};

/* ---- getting ready ---- */

/* All are there: air_lightmap_check has seen to it. */
static void find_planes(const air_lightmap *lightmap, const air_image *page, page_planes *out)
{
    out->width = air_image_width(page);
    out->height = air_image_height(page);
    for (size_t k = 0; k < AIR_LAYER_COUNT; k++) {
        (void)air_lightmap_planes(page, air_light_layer_name((air_light_layer)k), out->layers[k]);
    }
    for (size_t k = 0; lightmap->directional && k < AIR_DIRECTIONAL_COEFFICIENTS; k++) {
        (void)air_lightmap_planes(page, air_lightmap_bands[k], out->harmonics[k]);
    }
}

/* Unlit meshes show themselves without light. */
static void warn_of_dark_meshes(const air_with_lightmap *with)
{
    const air_lightmap_mesh *first = NULL;
    size_t count = 0;
    for (size_t i = 0; i < with->lightmap->mesh_count; i++) {
        const air_mesh *mesh = with->snapshot->meshes[i];
        const bool dark =
            with->lightmap->meshes[i].page < 0 && !with->snapshot->materials[mesh->material].unlit;
        first = dark && first == NULL ? &with->lightmap->meshes[i] : first;
        count += dark;
    }
    if (count > 0) {
        air_warn(with->context,
                 "lightmap: %zu meshes are on none of its pages and get no light, the first of "
                 "them \"%s\"",
                 count, first->name != NULL ? first->name : "");
    }
}

air_status air_with_lightmap_create(const air_path *path, const air_lightmap *lightmap,
                                    uint32_t terms, air_with_lightmap **out)
{
    air_context *context = path->snapshot->context;
    *out = NULL;
    if ((terms & air_lightmap_terms(lightmap)) == 0) {
        return AIR_OK;
    }
    const air_status status = air_lightmap_fit(lightmap, path->snapshot);
    if (status != AIR_OK) {
        return status;
    }
    air_with_lightmap *with = air_allocate(context, 1, sizeof *with);
    if (with == NULL) {
        return air_fail_memory(context, "lightmap");
    }
    with->context = context;
    with->path = path;
    with->snapshot = path->snapshot;
    with->lightmap = lightmap;
    with->terms = terms;
    with->pages = air_allocate(context, lightmap->page_count, sizeof *with->pages);
    if (with->pages == NULL) {
        air_with_lightmap_destroy(with);
        return air_fail_memory(context, "lightmap");
    }
    for (size_t i = 0; i < lightmap->page_count; i++) {
        find_planes(lightmap, lightmap->pages[i], &with->pages[i]);
    }
    warn_of_dark_meshes(with);
    *out = with;
    return AIR_OK;
}

void air_with_lightmap_destroy(air_with_lightmap *with)
{
    if (with != NULL) {
        air_free(with->context, with->pages);
        air_free(with->context, with);
    }
}

/* ---- what pictures depend on ---- */

static uint64_t add_planes(uint64_t hash, const page_planes *page)
{
    const size_t size = page->width * page->height * sizeof(float);
    hash = air_fingerprint_add(hash, &page->width, sizeof page->width);
    for (size_t c = 0; c < 3; c++) {
        for (size_t k = 0; k < AIR_LAYER_COUNT; k++) {
            hash = air_fingerprint_add(hash, page->layers[k][c], size);
        }
        for (size_t k = 0; page->harmonics[0][0] != NULL && k < AIR_DIRECTIONAL_COEFFICIENTS; k++) {
            hash = air_fingerprint_add(hash, page->harmonics[k][c], size);
        }
    }
    return hash;
}

uint64_t air_with_lightmap_fingerprint(const air_with_lightmap *with, uint64_t hash)
{
    for (size_t i = 0; i < with->lightmap->mesh_count; i++) {
        const air_lightmap_mesh *mesh = &with->lightmap->meshes[i];
        hash = air_fingerprint_add(hash, &mesh->page, sizeof mesh->page);
        hash = air_fingerprint_add(hash, mesh->scale, sizeof mesh->scale);
        hash = air_fingerprint_add(hash, mesh->offset, sizeof mesh->offset);
        if (mesh->sources != NULL) {
            hash = air_fingerprint_add(hash, mesh->uv, 2 * mesh->vertex_count * sizeof *mesh->uv);
            hash = air_fingerprint_add(hash, mesh->indices,
                                       3 * mesh->triangle_count * sizeof *mesh->indices);
        }
    }
    for (size_t i = 0; i < with->lightmap->page_count; i++) {
        hash = add_planes(hash, &with->pages[i]);
    }
    return hash;
}

/* ---- looking up ---- */

/* The four texels around a point of a page, and how much each counts. */
typedef struct texel_mix {
    size_t at[4];
    float weights[4];
} texel_mix;

/* Texel centres lie at halves; beyond the outermost the page goes on as it ends, as textures do
 * that are clamped to their edge. */
static void split_axis(float coordinate, size_t size, size_t out_at[2], float *out_share)
{
    const float most = (float)(size - 1);
    const float x = float_min(float_max(coordinate * (float)size - 0.5f, 0.0f), most);
    out_at[0] = (size_t)x;
    out_at[1] = out_at[0] + 1 < size ? out_at[0] + 1 : out_at[0];
    *out_share = x - (float)out_at[0];
}

static texel_mix mix_at(const page_planes *page, const float uv[2])
{
    size_t x[2], y[2];
    float u, v;
    split_axis(uv[0], page->width, x, &u);
    split_axis(uv[1], page->height, y, &v);
    return (texel_mix){{y[0] * page->width + x[0], y[0] * page->width + x[1],
                        y[1] * page->width + x[0], y[1] * page->width + x[1]},
                       {(1.0f - u) * (1.0f - v), u * (1.0f - v), (1.0f - u) * v, u * v}};
}

static float look(const float *plane, const texel_mix *mix)
{
    return mix->weights[0] * plane[mix->at[0]] + mix->weights[1] * plane[mix->at[1]] +
           mix->weights[2] * plane[mix->at[2]] + mix->weights[3] * plane[mix->at[3]];
}

static air_vec3 look3(const float *const planes[3], const texel_mix *mix)
{
    return vec3(look(planes[0], mix), look(planes[1], mix), look(planes[2], mix));
}

/* Where on its page a hit lies. */
static void page_coordinates(const air_with_lightmap *with, const air_hit *hit, float out[2])
{
    const air_lightmap_mesh *place = &with->lightmap->meshes[hit->mesh];
    const air_mesh *mesh = with->snapshot->meshes[hit->mesh];
    const bool cut = place->sources != NULL;
    const float *uv = cut ? place->uv : mesh->uv[1];
    const uint32_t *at = (cut ? place->indices : mesh->indices) + 3 * (size_t)hit->triangle;
    const float weights[3] = {1.0f - hit->u - hit->v, hit->u, hit->v};
    for (size_t k = 0; k < 2; k++) {
        float sum = 0.0f;
        for (size_t i = 0; i < 3; i++) {
            sum += weights[i] * uv[2 * (size_t)at[i] + k];
        }
        out[k] = sum * place->scale[k] + place->offset[k];
    }
}

/* ---- light that follows normal maps ---- */

/* Irradiance from the bands 0 and 1 of the incident radiance: the sum of A_l c_lm y_lm(n), where
 * A_0 = pi and A_1 = 2 pi / 3 are the zonal coefficients of the clamped cosine times
 * sqrt(4 pi/(2l+1)) (core/harmonics.h). */
static air_vec3 smooth_irradiance(const air_vec3 coefficients[AIR_DIRECTIONAL_COEFFICIENTS],
                                  air_vec3 normal)
{
    const float dir[3] = {normal.x, normal.y, normal.z};
    float y[9];
    air_sh_evaluate_3(dir, y);
    air_vec3 sum = vec3_scale(coefficients[0], AIR_PI_F * y[0]);
    for (int k = 1; k < AIR_DIRECTIONAL_COEFFICIENTS; k++) {
        sum = vec3_madd(sum, AIR_PI_F * (2.0f / 3.0f) * y[k], coefficients[k]);
    }
    return sum;
}

/* Of light from one direction d the two bands make 1/4 + n.d / 2. Light comes from the front of the
 * normal n0 that was baked, n0.d >= 0, so another normal gets at most (1/4 + 1/2) / (1/4) times as
 * much; less than nothing is nothing. Noise, and texels between different charts, keep to that too.
 */
static float ratio_of(float turned, float baked)
{
    const float most = 3.0f;
    return baked > 0.0f ? float_min(float_max(turned / baked, 0.0f), most) : 1.0f;
}

/* What the normal makes of the irradiance that was baked for the interpolated one; 1 where they
 * agree. normal: on the surface's front side. */
static air_vec3 normal_factor(const air_with_lightmap *with, const air_hit *hit,
                              const page_planes *page, const texel_mix *mix, air_vec3 normal)
{
    air_surface_place place;
    if (!with->lightmap->directional ||
        !air_surface_place_make(with->snapshot->meshes[hit->mesh], hit->triangle, hit->u, hit->v,
                                &place)) {
        return vec3_set1(1.0f);
    }
    air_vec3 coefficients[AIR_DIRECTIONAL_COEFFICIENTS];
    for (int k = 0; k < AIR_DIRECTIONAL_COEFFICIENTS; k++) {
        coefficients[k] = look3(page->harmonics[k], mix);
    }
    const air_vec3 turned = smooth_irradiance(coefficients, normal);
    const air_vec3 baked = smooth_irradiance(coefficients, place.normal);
    return vec3(ratio_of(turned.x, baked.x), ratio_of(turned.y, baked.y),
                ratio_of(turned.z, baked.z));
}

/* ---- one lane ---- */

static void add_lane(const air_with_lightmap *with, air_path_scratch *scratch, air_path_lane *lane)
{
    const air_hit *hit = &lane->hit;
    air_surface surface;
    float uv[2];
    if (hit->mesh == (uint32_t)AIR_NO_HIT || with->lightmap->meshes[hit->mesh].page < 0) {
        return;
    }
    const air_mesh *mesh = with->snapshot->meshes[hit->mesh];
    air_surface_make(with->snapshot, hit, lane->dir, &surface);
    const bool front = vec3_dot(surface.normal, lane->dir) < 0.0f;
    if (!front && !with->snapshot->materials[mesh->material].double_sided) {
        return;
    }
    const air_vec3 albedo = air_bsdf_albedo(&surface.bsdf, vec3_neg(lane->dir));
    if (vec3_is_zero(albedo)) {
        return;
    }
    const page_planes *page = &with->pages[with->lightmap->meshes[hit->mesh].page];
    page_coordinates(with, hit, uv);
    const texel_mix mix = mix_at(page, uv);
    const air_vec3 normal = vec3_scale(surface.bsdf.frame.n, front ? 1.0f : -1.0f);
    air_vec3 factor = vec3_mul(albedo, normal_factor(with, hit, page, &mix, normal));
    factor = vec3_mul(factor, air_path_view_transmittance(with->path, scratch, lane));
    factor = vec3_scale(factor, 1.0f / AIR_PI_F);
    const air_vec3 direct = look3(page->layers[AIR_LAYER_DIRECT], &mix);
    const air_vec3 further = vec3_add(look3(page->layers[AIR_LAYER_INDIRECT], &mix),
                                      look3(page->layers[AIR_LAYER_MEDIA], &mix));
    if ((with->terms >> AIR_TERM_S0 & 1u) != 0) {
        lane->terms[AIR_TERM_S0] = vec3_add(lane->terms[AIR_TERM_S0], vec3_mul(factor, direct));
    }
    if ((with->terms >> AIR_TERM_S_PLUS & 1u) != 0) {
        lane->terms[AIR_TERM_S_PLUS] =
            vec3_add(lane->terms[AIR_TERM_S_PLUS], vec3_mul(factor, further));
    }
}

void air_with_lightmap_add(const air_with_lightmap *with, air_path_scratch *scratch,
                           air_path_lane *lanes, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        add_lane(with, scratch, &lanes[i]);
    }
}
