#include "bake/layout.h"

#include <string.h>

#include "atlas/pack.h"
#include "bake/unwrapped.h"

/* ---- pages ---- */

/* Texels that a rectangle keeps free on each of its first sides: half of the padding, or what a
 * page has left of it. A mesh that fills a page needs no room around it. */
static double margin_of(double size, const air_bake_params *params)
{
    const double margin = (double)air_half_padding(params);
    const double most = floor(0.5 * ((double)params->page_size - ceil(size)));
    return margin < most ? margin : most;
}

/* What each mesh takes of a page, its margins with it. Margins beyond the page are left out. */
static void grow(const air_mesh_rectangle *rectangle, const air_bake_params *params,
                 air_pack_item *out)
{
    const double sides[2] = {rectangle->width, rectangle->height};
    for (int k = 0; k < 2; k++) {
        const double wanted = ceil(sides[k]) + 2.0 * (double)air_half_padding(params);
        out->size[k] = wanted < (double)params->page_size ? wanted : (double)params->page_size;
    }
    out->fixed = true;
}

static void place_mesh(const air_bake_layout *self, const air_bake_params *params,
                       const air_mesh_rectangle *rectangle, const air_pack_place *place,
                       air_lightmap_mesh *mesh)
{
    const double sides[2] = {rectangle->width, rectangle->height};
    const uint32_t at[2] = {place->x, place->y};
    const air_bake_page *page = &self->pages[place->page];
    const double size[2] = {(double)page->width, (double)page->height};
    mesh->page = (int32_t)place->page;
    for (int k = 0; k < 2; k++) {
        mesh->scale[k] = (float)(sides[k] / size[k]);
        mesh->offset[k] = (float)(((double)at[k] + margin_of(sides[k], params)) / size[k]);
    }
}

static air_status make_pages(air_bake_layout *self, const air_pack *pack)
{
    self->pages = air_allocate(self->context, pack->page_count, sizeof *self->pages);
    if (self->pages == NULL) {
        return air_fail_memory(self->context, "pages");
    }
    self->page_count = pack->page_count;
    for (size_t p = 0; p < self->page_count; p++) {
        self->pages[p].width = pack->pages[p].width;
        self->pages[p].height = pack->pages[p].height;
    }
    return AIR_OK;
}

static air_status pack_meshes(air_bake_layout *self, const air_bake_params *params,
                              const air_mesh_rectangle *rectangles)
{
    air_context *context = self->context;
    air_pack_params packing;
    air_pack *pack = NULL;
    air_pack_item *items = air_allocate(context, self->mesh_count, sizeof *items);
    uint32_t *meshes = air_allocate(context, self->mesh_count, sizeof *meshes);
    size_t count = 0;
    air_status status =
        items == NULL || meshes == NULL ? air_fail_memory(context, "pages") : AIR_OK;
    for (size_t i = 0; i < self->mesh_count && status == AIR_OK; i++) {
        if (rectangles[i].width > 0.0) {
            meshes[count] = (uint32_t)i;
            grow(&rectangles[i], params, &items[count++]);
        }
    }
    air_pack_params_default(&packing);
    packing.padding = 0; /* rectangles have theirs */
    packing.max_size = params->page_size;
    packing.power_of_two = false;
    if (status == AIR_OK && count > 0) {
        status = air_pack_create(context, items, count, &packing, &pack);
    }
    if (status == AIR_OK && pack != NULL) {
        status = make_pages(self, pack);
    }
    for (size_t i = 0; i < count && status == AIR_OK; i++) {
        place_mesh(self, params, &rectangles[meshes[i]], &pack->places[i],
                   &self->meshes[meshes[i]]);
    }
    air_pack_destroy(context, pack);
    air_free(context, items);
    air_free(context, meshes);
    return status;
}

static air_atlas_part part_of(const air_bake_layout *self, const air_lightmap_mesh *mesh)
{
    const air_mesh *source = self->snapshot->meshes[mesh->mesh];
    const air_bake_page *page = &self->pages[mesh->page];
    const bool cut = mesh->sources != NULL;
    air_atlas_part part = {.uv = cut ? mesh->uv : source->uv[1],
                           .indices = cut ? mesh->indices : source->indices,
                           .vertex_count = cut ? mesh->vertex_count : source->vertex_count,
                           .triangle_count = source->triangle_count,
                           .positions = cut ? NULL : source->positions};
    const double size[2] = {(double)page->width, (double)page->height};
    for (int k = 0; k < 2; k++) {
        part.size[k] = (double)mesh->scale[k] * size[k];
        part.offset[k] = (double)mesh->offset[k] * size[k];
    }
    return part;
}

/* The positions of a cut mesh's vertices, so that seams and triangles without area are known. */
static float *cut_positions(air_context *context, const air_mesh *source,
                            const air_lightmap_mesh *mesh)
{
    float *positions = air_allocate(context, mesh->vertex_count, 3 * sizeof *positions);
    for (size_t i = 0; positions != NULL && i < mesh->vertex_count; i++) {
        memcpy(positions + 3 * i, source->positions + 3 * (size_t)mesh->sources[i],
               3 * sizeof *positions);
    }
    return positions;
}

static air_status cover(air_bake_layout *self, air_bake_page *page, size_t number)
{
    air_context *context = self->context;
    for (size_t i = 0; i < self->mesh_count; i++) {
        page->part_count += self->meshes[i].page == (int32_t)number;
    }
    page->parts = air_allocate(context, page->part_count, sizeof *page->parts);
    page->part_meshes = air_allocate(context, page->part_count, sizeof *page->part_meshes);
    page->positions = air_allocate(context, page->part_count, sizeof *page->positions);
    if (page->parts == NULL || page->part_meshes == NULL || page->positions == NULL) {
        return air_fail_memory(context, "pages");
    }
    size_t count = 0;
    for (size_t i = 0; i < self->mesh_count; i++) {
        const air_lightmap_mesh *mesh = &self->meshes[i];
        if (mesh->page != (int32_t)number) {
            continue;
        }
        page->parts[count] = part_of(self, mesh);
        page->part_meshes[count] = (uint32_t)i;
        if (mesh->sources != NULL) {
            page->positions[count] = cut_positions(context, self->snapshot->meshes[i], mesh);
            page->parts[count].positions = page->positions[count];
            if (page->positions[count] == NULL) {
                return air_fail_memory(context, "pages");
            }
        }
        count++;
    }
    air_coverage_report report;
    const air_status status = air_coverage_create(context, page->width, page->height, page->parts,
                                                  page->part_count, &page->coverage, &report);
    if (status == AIR_OK && report.degenerate_count > 0) {
        air_inform(context,
                   "bake: page %zu: %zu triangles have no area in space or in texture "
                   "coordinates and get no light of their own",
                   number, report.degenerate_count);
    }
    return status;
}

air_status air_bake_layout_create(air_context *context, const air_snapshot *snapshot,
                                  const air_bake_params *params, air_bake_layout **out_layout)
{
    air_bake_layout *self = air_allocate(context, 1, sizeof *self);
    *out_layout = NULL;
    if (self == NULL) {
        return air_fail_memory(context, "pages");
    }
    self->context = context;
    self->snapshot = snapshot;
    self->mesh_count = snapshot->mesh_count;
    self->meshes = air_allocate(context, self->mesh_count, sizeof *self->meshes);
    air_mesh_rectangle *rectangles = air_allocate(context, self->mesh_count, sizeof *rectangles);
    air_status status =
        self->meshes == NULL || rectangles == NULL ? air_fail_memory(context, "pages") : AIR_OK;
    for (size_t i = 0; i < self->mesh_count && status == AIR_OK; i++) {
        status =
            air_mesh_coordinates(context, snapshot, i, params, &self->meshes[i], &rectangles[i]);
    }
    if (status == AIR_OK) {
        status = pack_meshes(self, params, rectangles);
    }
    for (size_t p = 0; p < self->page_count && status == AIR_OK; p++) {
        status = cover(self, &self->pages[p], p);
    }
    air_free(context, rectangles);
    if (status != AIR_OK) {
        air_bake_layout_destroy(self);
        return status;
    }
    *out_layout = self;
    return AIR_OK;
}

static void destroy_page(const air_bake_layout *self, air_bake_page *page)
{
    air_context *context = self->context;
    air_coverage_destroy(context, page->coverage);
    for (size_t i = 0; page->positions != NULL && i < page->part_count; i++) {
        air_free(context, page->positions[i]);
    }
    air_free(context, page->positions);
    air_free(context, page->parts);
    air_free(context, page->part_meshes);
}

void air_bake_layout_destroy(air_bake_layout *self)
{
    if (self == NULL) {
        return;
    }
    air_context *context = self->context;
    for (size_t p = 0; self->pages != NULL && p < self->page_count; p++) {
        destroy_page(self, &self->pages[p]);
    }
    for (size_t i = 0; self->meshes != NULL && i < self->mesh_count; i++) {
        air_free(context, self->meshes[i].name);
        air_free(context, self->meshes[i].sources);
        air_free(context, self->meshes[i].uv);
        air_free(context, self->meshes[i].indices);
    }
    air_free(context, self->meshes);
    air_free(context, self->pages);
    air_free(context, self);
}
