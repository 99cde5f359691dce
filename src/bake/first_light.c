#include "bake/first_light.h"

#include "atlas/triangle.h"
#include "core/host.h"
#include "scene/surface.h"

/* Within so many sides of its texels of a receiver, a surface is too coarsely known: in corners, on
 * small things. */
#define NEAR_TEXELS 2.0f

/* Irradiance of a texel: never scattered by media, and scattered. */
typedef struct texel_light {
    float plain[3], scattered[3];
} texel_light;

/* Of one side of a page's surfaces. */
typedef struct side_light {
    uint32_t *index;     /* per texel of the page: in lights, from 1 on; 0: not known */
    texel_light *lights; /* of those that are known */
} side_light;

typedef struct page_light {
    side_light sides[2]; /* fronts, backs */
} page_light;

/* Where a mesh is; part NULL: nowhere. */
typedef struct mesh_place {
    const air_atlas_part *part;
    size_t page;
    float near; /* metres: what is nearer to a receiver is more than its texels know */
} mesh_place;

struct air_first_light {
    const air_bake_layout *layout;
    page_light *pages;
    mesh_place *places; /* one for each mesh */
};

/* The side of the mean texel of a mesh. */
static double texel_side(const air_mesh *mesh, const air_atlas_part *part)
{
    double area = 0.0, texels = 0.0;
    for (size_t t = 0; t < part->triangle_count; t++) {
        const uint32_t *at = part->indices + 3 * t;
        double p[3][2];
        for (int k = 0; k < 3; k++) {
            p[k][0] = (double)part->uv[2 * (size_t)at[k]] * part->size[0];
            p[k][1] = (double)part->uv[2 * (size_t)at[k] + 1] * part->size[1];
        }
        area += air_mesh_triangle_area(mesh, t);
        texels += 0.5 * fabs(air_doubled_area(p[0], p[1], p[2]));
    }
    return texels > 0.0 ? sqrt(area / texels) : 0.0;
}

air_status air_first_light_create(air_context *context, const air_bake_layout *layout,
                                  air_first_light **out_light)
{
    air_first_light *self = air_allocate(context, 1, sizeof *self);
    *out_light = NULL;
    if (self == NULL) {
        return air_fail_memory(context, "first pass");
    }
    self->layout = layout;
    self->pages = air_allocate(context, layout->page_count, sizeof *self->pages);
    self->places = air_allocate(context, layout->mesh_count, sizeof *self->places);
    if (self->pages == NULL || self->places == NULL) {
        air_first_light_destroy(self);
        return air_fail_memory(context, "first pass");
    }
    for (size_t p = 0; p < layout->page_count; p++) {
        const air_bake_page *page = &layout->pages[p];
        for (size_t i = 0; i < page->part_count; i++) {
            const air_mesh *mesh = layout->snapshot->meshes[page->part_meshes[i]];
            const double side = texel_side(mesh, &page->parts[i]);
            self->places[page->part_meshes[i]] =
                (mesh_place){&page->parts[i], p, NEAR_TEXELS * (float)side};
        }
    }
    *out_light = self;
    return AIR_OK;
}

void air_first_light_destroy(air_first_light *self)
{
    if (self == NULL) {
        return;
    }
    air_context *context = self->layout->context;
    for (size_t p = 0; self->pages != NULL && p < self->layout->page_count; p++) {
        for (int side = 0; side < 2; side++) {
            air_free(context, self->pages[p].sides[side].index);
            air_free(context, self->pages[p].sides[side].lights);
        }
    }
    air_free(context, self->pages);
    air_free(context, self->places);
    air_free(context, self);
}

/* ---- taking ---- */

bool air_first_light_has_backs(const air_first_light *self, size_t page)
{
    const air_bake_page *p = &self->layout->pages[page];
    const air_snapshot *snapshot = self->layout->snapshot;
    for (size_t i = 0; i < p->part_count; i++) {
        if (snapshot->materials[snapshot->meshes[p->part_meshes[i]]->material].double_sided) {
            return true;
        }
    }
    return false;
}

/* Do all triangles in a texel look the same way, within 60 degrees? */
static bool is_even(const air_texel_sites *sites, uint32_t texel)
{
    const air_bake_page *page = sites->page;
    size_t count;
    const air_fragment *fragments =
        air_coverage_texel(page->coverage, texel % page->width, texel / page->width, &count);
    air_vec3 first = vec3_set1(0.0f);
    for (size_t i = 0; i < count; i++) {
        const air_coverage_point middle = {air_fragment_triangle(fragments[i]),
                                           {1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0}};
        const air_hit hit = air_texel_hit(page, &middle);
        air_surface_place place;
        if (!air_surface_place_make(sites->snapshot->meshes[hit.mesh], hit.triangle, hit.u, hit.v,
                                    &place)) {
            continue;
        }
        if (vec3_is_zero(first)) {
            first = place.geometric;
        } else if (vec3_dot(first, place.geometric) < 0.5f) {
            return false;
        }
    }
    return true;
}

static void take_record(const float *record, texel_light *out)
{
    const float *light = record + AIR_SITE_LIGHT;
    for (size_t c = 0; c < 3; c++) {
        out->plain[c] = light[3 * AIR_LAYER_DIRECT + c] + light[3 * AIR_LAYER_INDIRECT + c];
        out->scattered[c] = light[3 * AIR_LAYER_MEDIA + c];
    }
}

air_status air_first_light_take(air_first_light *self, size_t page, const air_texel_sites *sites,
                                const air_site_list *list)
{
    air_context *context = self->layout->context;
    side_light *out = &self->pages[page].sides[sites->back];
    const size_t texels = (size_t)sites->page->width * sites->page->height;
    const size_t stride = air_site_stride(list);
    uint32_t count = 0;
    out->index = air_allocate(context, texels, sizeof *out->index);
    out->lights = air_allocate(context, sites->count, sizeof *out->lights);
    if (out->index == NULL || out->lights == NULL) {
        return air_fail_memory(context, "first pass");
    }
    for (size_t i = 0; i < sites->count; i++) {
        const float *record = list->records + i * stride;
        if (record[AIR_SITE_VALIDITY] >= AIR_SITE_VALID_SHARE && is_even(sites, sites->texels[i])) {
            take_record(record, &out->lights[count]);
            out->index[sites->texels[i]] = ++count;
        }
    }
    return AIR_OK;
}

/* ---- looking up ---- */

/* The texel along one axis: inside of the page. */
static uint32_t texel_at(double coordinate, uint32_t size)
{
    const double most = (double)size - 1.0;
    return (uint32_t)(coordinate < 0.0 ? 0.0 : coordinate > most ? most : coordinate);
}

bool air_first_light_irradiance(const void *light, const air_hit *hit, bool front, air_vec3 out[2])
{
    const air_first_light *self = light;
    const mesh_place *place = &self->places[hit->mesh];
    const air_atlas_part *part = place->part;
    if (part == NULL || hit->t < place->near) {
        return false;
    }
    const air_bake_page *page = &self->layout->pages[place->page];
    const side_light *lights = &self->pages[place->page].sides[front ? 0 : 1];
    const uint32_t *at = part->indices + 3 * (size_t)hit->triangle;
    const double weights[3] = {1.0 - (double)hit->u - (double)hit->v, (double)hit->u,
                               (double)hit->v};
    double texel[2];
    for (int k = 0; k < 2; k++) {
        const double uv = weights[0] * (double)part->uv[2 * (size_t)at[0] + (size_t)k] +
                          weights[1] * (double)part->uv[2 * (size_t)at[1] + (size_t)k] +
                          weights[2] * (double)part->uv[2 * (size_t)at[2] + (size_t)k];
        texel[k] = uv * part->size[k] + part->offset[k];
    }
    const size_t x = texel_at(texel[0], page->width), y = texel_at(texel[1], page->height);
    const uint32_t index = lights->index == NULL ? 0 : lights->index[y * page->width + x];
    if (index == 0) {
        return false;
    }
    out[0] = vec3_load(lights->lights[index - 1].plain);
    out[1] = vec3_load(lights->lights[index - 1].scattered);
    return true;
}
