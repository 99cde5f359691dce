/* check.c: is a lightmap what airlight/lightmap.h says? */
#include "lightmap/check.h"

#include <math.h>
#include <stdio.h>

const char *const air_lightmap_colours[3] = {"R", "G", "B"};
const char *const air_lightmap_bands[AIR_DIRECTIONAL_COEFFICIENTS] = {"L0", "L1.y", "L1.z", "L1.x"};

typedef struct check {
    air_context *context;
    const char *file;
    air_status status;
} check;

bool air_lightmap_planes(const air_image *image, const char *prefix, const float *out[3])
{
    for (size_t c = 0; c < 3; c++) {
        char name[64];
        (void)snprintf(name, sizeof name, "%s%s%s", prefix, prefix[0] != '\0' ? "." : "",
                       air_lightmap_colours[c]);
        const ptrdiff_t channel = air_image_find_channel(image, name);
        if (channel < 0) {
            return false;
        }
        out[c] = air_image_plane_const(image, (size_t)channel);
    }
    return true;
}

/* Index of the first number that is not finite, or count. */
static size_t first_not_finite(const float *values, size_t count)
{
    size_t i = 0;
    while (i < count && isfinite(values[i])) {
        i++;
    }
    return i;
}

static air_status check_finite(const check *self, const char *kind, size_t index, const char *what,
                               const float *values, size_t count)
{
    const size_t bad = values != NULL ? first_not_finite(values, count) : 0;
    if (values == NULL) {
        return air_fail(self->context, self->status, "%s: %s %zu has no %s", self->file, kind,
                        index, what);
    }
    return bad == count ? AIR_OK
                        : air_fail(self->context, self->status,
                                   "%s: %s %zu: number %zu of its %s is not finite", self->file,
                                   kind, index, bad, what);
}

/* What a page's channels begin with: all light, the layers, the bands of directional light. */
static const char *page_prefix(size_t i)
{
    if (i > AIR_LAYER_COUNT) {
        return air_lightmap_bands[i - 1 - AIR_LAYER_COUNT];
    }
    return i > 0 ? air_light_layer_name((air_light_layer)(i - 1)) : "";
}

static air_status check_page(const check *self, const air_lightmap *lightmap, size_t index)
{
    const size_t prefix_count =
        1 + AIR_LAYER_COUNT + (lightmap->directional ? AIR_DIRECTIONAL_COEFFICIENTS : 0);
    const air_image *page = lightmap->pages[index];
    if (page == NULL) {
        return air_fail(self->context, self->status, "%s: page %zu is missing", self->file, index);
    }
    for (size_t i = 0; i < prefix_count; i++) {
        const float *planes[3];
        if (!air_lightmap_planes(page, page_prefix(i), planes)) {
            return air_fail(
                self->context, self->status,
                "%s: page %zu lacks a channel of \"%s\", expected R, G, B, those of direct, "
                "indirect and media%s, and coverage.Y",
                self->file, index, page_prefix(i),
                lightmap->directional ? ", L0, L1.y, L1.z and L1.x" : "");
        }
    }
    if (air_image_find_channel(page, "coverage.Y") < 0) {
        return air_fail(self->context, self->status, "%s: page %zu has no channel coverage.Y",
                        self->file, index);
    }
    const size_t count = air_image_width(page) * air_image_height(page);
    air_status status = AIR_OK;
    for (size_t c = 0; c < air_image_channel_count(page) && status == AIR_OK; c++) {
        status = check_finite(self, "page", index, air_image_channel_name(page, c),
                              air_image_plane_const(page, c), count);
    }
    return status;
}

static air_status check_place(const check *self, const char *kind, size_t index, int32_t node,
                              int32_t primitive)
{
    if (node < -1 || primitive < -1 || (node < 0) != (primitive < 0)) {
        return air_fail(
            self->context, self->status,
            "%s: %s %zu has node %ld and primitive %ld, expected both from 0 or both -1",
            self->file, kind, index, (long)node, (long)primitive);
    }
    return AIR_OK;
}

static air_status check_cut(const check *self, const air_lightmap_mesh *mesh, size_t index)
{
    const bool whole = mesh->sources != NULL && mesh->uv != NULL && mesh->indices != NULL;
    const bool none = mesh->sources == NULL && mesh->uv == NULL && mesh->indices == NULL;
    if (none && mesh->vertex_count == 0 && mesh->triangle_count == 0) {
        return AIR_OK;
    }
    if (!whole || mesh->vertex_count == 0 || mesh->vertex_count > UINT32_MAX ||
        mesh->triangle_count == 0 || mesh->triangle_count > SIZE_MAX / 64) {
        return air_fail(self->context, self->status,
                        "%s: mesh %zu is cut to %zu vertices and %zu triangles, expected sources, "
                        "uv and indices for some of both, or nothing at all",
                        self->file, index, mesh->vertex_count, mesh->triangle_count);
    }
    for (size_t i = 0; i < 3 * mesh->triangle_count; i++) {
        if (mesh->indices[i] >= mesh->vertex_count) {
            return air_fail(self->context, self->status,
                            "%s: mesh %zu: index %zu is %lu, but it is cut to %zu vertices",
                            self->file, index, i, (unsigned long)mesh->indices[i],
                            mesh->vertex_count);
        }
    }
    return check_finite(self, "mesh", index, "uv", mesh->uv, 2 * mesh->vertex_count);
}

/* Does an earlier mesh name the same primitive of the same node? */
static bool named_before(const air_lightmap *lightmap, size_t index)
{
    const air_lightmap_mesh *mesh = &lightmap->meshes[index];
    for (size_t i = 0; i < index && mesh->node >= 0; i++) {
        if (lightmap->meshes[i].node == mesh->node &&
            lightmap->meshes[i].primitive == mesh->primitive) {
            return true;
        }
    }
    return false;
}

static air_status check_mesh(const check *self, const air_lightmap *lightmap, size_t index)
{
    const air_lightmap_mesh *mesh = &lightmap->meshes[index];
    if (mesh->page < -1 || (mesh->page >= 0 && (size_t)mesh->page >= lightmap->page_count)) {
        return air_fail(self->context, self->status,
                        "%s: mesh %zu lies on page %ld, there are %zu pages", self->file, index,
                        (long)mesh->page, lightmap->page_count);
    }
    air_status status = check_place(self, "mesh", index, mesh->node, mesh->primitive);
    if (status == AIR_OK && named_before(lightmap, index)) {
        status = air_fail(self->context, self->status,
                          "%s: mesh %zu is primitive %ld of node %ld, as one before it", self->file,
                          index, (long)mesh->primitive, (long)mesh->node);
    }
    if (status == AIR_OK) {
        status = check_finite(self, "mesh", index, "scale", mesh->scale, 2);
    }
    if (status == AIR_OK) {
        status = check_finite(self, "mesh", index, "offset", mesh->offset, 2);
    }
    return status == AIR_OK ? check_cut(self, mesh, index) : status;
}

static air_status check_vertex_light(const check *self, const air_vertex_light *light, size_t index)
{
    air_status status = check_place(self, "vertex light", index, light->node, light->primitive);
    if (status == AIR_OK && (light->vertex_count < 1 || light->vertex_count > UINT32_MAX)) {
        status = air_fail(self->context, self->status, "%s: vertex light %zu has %zu vertices",
                          self->file, index, light->vertex_count);
    }
    for (size_t k = 0; k < AIR_LAYER_COUNT && status == AIR_OK; k++) {
        status = check_finite(self, "vertex light", index, air_light_layer_name((air_light_layer)k),
                              light->layers[k], 3 * light->vertex_count);
    }
    return status;
}

static bool grid_fits(const air_probe_set *set)
{
    size_t left = set->count;
    for (size_t k = 0; k < 3; k++) {
        if (set->size[k] == 0 || left % set->size[k] != 0) {
            return false;
        }
        left /= set->size[k];
    }
    return left == 1;
}

static air_status check_probes(const check *self, const air_probe_set *set, size_t index)
{
    static const char *const kind = "probe set";
    if (set->count < 1 || set->count > SIZE_MAX / 1024 || (set->grid && !grid_fits(set))) {
        return air_fail(self->context, self->status, "%s: probe set %zu has %zu probes%s",
                        self->file, index, set->count,
                        set->grid ? ", which its grid's size does not give" : "");
    }
    air_status status =
        check_finite(self, kind, index, "positions", set->positions, 3 * set->count);
    for (size_t k = 0; k < AIR_LAYER_COUNT && status == AIR_OK; k++) {
        status = check_finite(self, kind, index, air_light_layer_name((air_light_layer)k),
                              set->layers[k], 3 * AIR_PROBE_COEFFICIENTS * set->count);
    }
    if (status == AIR_OK) {
        status = check_finite(self, kind, index, "validity", set->validity, set->count);
    }
    for (size_t i = 0; i < set->count && status == AIR_OK; i++) {
        if (!(set->validity[i] >= 0.0f && set->validity[i] <= 1.0f)) {
            status = air_fail(self->context, self->status,
                              "%s: probe set %zu: the validity of probe %zu is %g, expected [0, 1]",
                              self->file, index, i, (double)set->validity[i]);
        }
    }
    if (status == AIR_OK && set->grid) {
        status = check_finite(self, kind, index, "origin", set->origin, 3);
    }
    if (status == AIR_OK && set->grid) {
        status = check_finite(self, kind, index, "step", set->step[0], 9);
    }
    return status;
}

air_status air_lightmap_check(air_context *context, const air_lightmap *lightmap, const char *file,
                              air_status status)
{
    const check self = {context, file, status};
    air_status result = AIR_OK;
    for (size_t i = 0; i < lightmap->page_count && result == AIR_OK; i++) {
        result = check_page(&self, lightmap, i);
    }
    for (size_t i = 0; i < lightmap->mesh_count && result == AIR_OK; i++) {
        result = check_mesh(&self, lightmap, i);
    }
    for (size_t i = 0; i < lightmap->vertex_light_count && result == AIR_OK; i++) {
        result = check_vertex_light(&self, &lightmap->vertex_lights[i], i);
    }
    for (size_t i = 0; i < lightmap->probe_set_count && result == AIR_OK; i++) {
        result = check_probes(&self, &lightmap->probe_sets[i], i);
    }
    return result;
}
