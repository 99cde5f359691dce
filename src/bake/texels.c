#include "bake/texels.h"

#include "scene/surface.h"

air_status air_texel_sites_init(air_context *context, const air_snapshot *snapshot,
                                const air_bake_page *page, air_texel_sites *out)
{
    size_t count = 0;
    for (int pass = 0; pass < 2; pass++) {
        count = 0;
        for (uint32_t y = 0; y < page->height; y++) {
            for (uint32_t x = 0; x < page->width; x++) {
                size_t fragments;
                (void)air_coverage_texel(page->coverage, x, y, &fragments);
                if (fragments > 0 && pass == 1) {
                    out->texels[count] = y * page->width + x;
                }
                count += fragments > 0;
            }
        }
        if (pass == 0) {
            *out = (air_texel_sites){.snapshot = snapshot, .page = page, .count = count};
            out->texels = air_allocate(context, count, sizeof *out->texels);
            if (out->texels == NULL) {
                return air_fail_memory(context, "texels");
            }
        }
    }
    return AIR_OK;
}

void air_texel_sites_finish(air_context *context, air_texel_sites *sites)
{
    air_free(context, sites->texels);
    sites->texels = NULL;
}

air_hit air_texel_hit(const air_bake_page *page, const air_coverage_point *point)
{
    size_t triangle;
    const size_t part = air_coverage_part(page->coverage, point->triangle, &triangle);
    return (air_hit){.u = (float)point->weights[1],
                     .v = (float)point->weights[2],
                     .mesh = page->part_meshes[part],
                     .triangle = (uint32_t)triangle};
}

bool air_texel_draw(const void *user, size_t site, const float u[2], air_path_receiver *out)
{
    const air_texel_sites *self = user;
    const air_bake_page *page = self->page;
    const uint32_t texel = self->texels[site];
    const double at[2] = {(double)u[0], (double)u[1]};
    air_coverage_point point;
    air_surface_place place;
    if (!air_coverage_draw(page->coverage, texel % page->width, texel / page->width, at, &point)) {
        return false;
    }
    const air_hit hit = air_texel_hit(page, &point);
    if (!air_surface_place_make(self->snapshot->meshes[hit.mesh], hit.triangle, hit.u, hit.v,
                                &place)) {
        return false;
    }
    if (self->back) {
        if (!self->snapshot->materials[self->snapshot->meshes[hit.mesh]->material].double_sided) {
            return false;
        }
        place.normal = vec3_neg(place.normal);
        place.geometric = vec3_neg(place.geometric);
    }
    *out = (air_path_receiver){.position = place.position,
                               .normal = place.normal,
                               .geometric = place.geometric,
                               .offset = place.offset,
                               .uniform = self->uniform};
    return true;
}
