/* fuzz_lightmap_gltf.c: any bytes as the scene that a lightmap is for: no crash, no leak, a changed
 * copy in memory or an error. */
#include "fuzz_host.h"
#include "lightmap/gltf_mesh.h"
#include "lightmap/godot.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* A page of one texel, without layers: what is checked when files are written does not matter here.
 */
static air_image *make_page(air_context *context)
{
    static const char *const names[6] = {"R", "G", "B", "albedo.R", "albedo.G", "albedo.B"};
    air_image *page = NULL;
    if (air_image_create(context, 1, 1, 6, names, &page) == AIR_OK)
        air_image_plane(page, 1)[0] = 2.0f;
    return page;
}

static void change(air_context *context, const air_lightmap *lightmap, air_lightmap_show mode)
{
    air_gltf_copy copy;
    air_gltf_show show = {.copy = &copy, .lightmap = lightmap};
    air_lightmap_gltf_params_default(&show.params);
    show.params.show = mode;
    air_status status = air_gltf_copy_read(context, "room.gltf", &copy);
    if (status == AIR_OK)
        status = air_gltf_show_begin(&show, mode == AIR_SHOW_EMISSIVE ? NULL : "room");
    if (status == AIR_OK)
        status = air_gltf_mesh_light_all(&show);
    if (status != AIR_OK && air_context_last_error(context)[0] == '\0')
        abort();
    air_gltf_show_finish(&show);
    air_gltf_copy_finish(&copy);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static uint32_t sources[4] = {0, 2, 1, 1}, indices[6] = {0, 1, 2, 2, 1, 3};
    static float uv[8];
    fuzz_files files = {.files = {{"", data, size}}, .count = 1};
    air_context *context = fuzz_context(&files, NULL);
    air_image *page = context != NULL ? make_page(context) : NULL;
    if (page == NULL) {
        air_context_destroy(context);
        return 0;
    }
    air_lightmap_mesh meshes[4];
    for (int32_t i = 0; i < 4; ++i)
        meshes[i] = (air_lightmap_mesh){.node = i / 2, .primitive = i % 2, .scale = {0.5f, 1.0f}};
    for (size_t i = 2; i < 4; ++i) {
        meshes[i].vertex_count = 4;
        meshes[i].triangle_count = 2;
        meshes[i].sources = sources;
        meshes[i].indices = indices;
        meshes[i].uv = uv;
    }
    air_lightmap lightmap = {.page_count = 1, .pages = &page, .context = context, .meshes = meshes};
    for (lightmap.mesh_count = 1; lightmap.mesh_count <= 4; ++lightmap.mesh_count)
        change(context, &lightmap, (air_lightmap_show)(lightmap.mesh_count % 3));
    lightmap.mesh_count = 4;
    air_sink sink = {.context = context};
    (void)air_godot_print_users(context, &lightmap, "room.gltf", 1, 1, &sink);
    air_free(context, sink.data);
    air_image_destroy(page);
    air_context_destroy(context);
    return 0;
}
