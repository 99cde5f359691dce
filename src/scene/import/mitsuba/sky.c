#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/vec.h"
#include "scene/import/mitsuba/mitsuba.h"
#include "scene/import/sun_sky.h"

enum { NAME = 256 };

/* Mitsuba 3's sky has Z up and X to the north; ours Y up and -Z to the north, as 0.x's. */
static const float old_frame[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
static const float new_frame[12] = {0, 0, -1, 0, -1, 0, 0, 0, 0, 1, 0, 0};

/* Tokyo, on the tenth of July 2010 at three in the afternoon. */
static air_status read_clock(const air_mitsuba *mitsuba, const air_xml *at, float out_dir[3])
{
    long date[3] = {2010, 7, 10};
    float place[3] = {35.6894f, 139.6917f, 9.0f}, clock[3] = {15.0f, 0.0f, 0.0f};
    static const char *const date_names[] = {"year", "month", "day"};
    static const char *const place_names[] = {"latitude", "longitude", "timezone"};
    static const char *const clock_names[] = {"hour", "minute", "second"};
    static const long last[] = {9999, 12, 31};
    air_status status = AIR_OK;
    for (size_t i = 0; i < 3 && status == AIR_OK; ++i) {
        status = air_mitsuba_integer_within(mitsuba, at, date_names[i], 1, last[i], &date[i]);
        if (status == AIR_OK)
            status = air_mitsuba_float(mitsuba, at, place_names[i], &place[i]);
        if (status == AIR_OK)
            status = air_mitsuba_float(mitsuba, at, clock_names[i], &clock[i]);
    }
    if (status == AIR_OK)
        air_sun_direction((int)date[0], (int)date[1], (int)date[2], (double)clock[0],
                          (double)clock[1], (double)clock[2], (double)place[0], (double)place[1],
                          (double)place[2], out_dir);
    return status;
}

/* The sky's frame in the world, and where in the world the sun is. */
static air_status read_directions(const air_mitsuba *mitsuba, const air_xml *at, air_sun_sky *sky)
{
    float map[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, dir[3];
    air_status status = air_mitsuba_transform(mitsuba, at, "to_world", map);
    affine_multiply(map, air_mitsuba_is_old(at) ? old_frame : new_frame, map);
    for (size_t row = 0; row < 3; ++row)
        memcpy(sky->to_world + 3 * row, map + 4 * row, 3 * sizeof *map);
    if (status == AIR_OK && air_mitsuba_has(at, "sun_direction")) {
        status = air_mitsuba_vector(mitsuba, at, "sun_direction", sky->sun_dir);
        if (status == AIR_OK && vec3_is_zero(vec3_load(sky->sun_dir)))
            status = air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                      "expected a sun_direction that is not 0");
        return status;
    }
    if (status == AIR_OK)
        status = read_clock(mitsuba, at, dir);
    if (status == AIR_OK)
        vec3_store(sky->sun_dir, affine_vector(map, vec3_load(dir)));
    return status;
}

static air_status read_sky(const air_mitsuba *mitsuba, const air_xml *at, air_sun_sky *sky)
{
    float scale = 1.0f;
    long width = 512;
    const float albedo = air_mitsuba_is_old(at) ? 0.2f : 0.3f;
    *sky = (air_sun_sky){
        .turbidity = 3.0f, .albedo = {albedo, albedo, albedo}, .sun_radius_scale = 1.0f};
    air_status status = air_mitsuba_float(mitsuba, at, "scale", &scale);
    sky->sky_scale = air_mitsuba_is(at, "sun") ? 0.0f : scale;
    sky->sun_scale = air_mitsuba_is(at, "sky") ? 0.0f : scale;
    if (status == AIR_OK)
        status = air_mitsuba_float(mitsuba, at, "turbidity", &sky->turbidity);
    if (status == AIR_OK)
        status = air_mitsuba_color(mitsuba, at, "albedo", AIR_MITSUBA_REFLECTANCE, sky->albedo);
    if (status == AIR_OK)
        status = air_mitsuba_float(mitsuba, at, "sky_scale", &sky->sky_scale);
    if (status == AIR_OK)
        status = air_mitsuba_float(mitsuba, at, "sun_scale", &sky->sun_scale);
    if (status == AIR_OK)
        status = air_mitsuba_float(mitsuba, at, "sun_radius_scale", &sky->sun_radius_scale);
    if (status == AIR_OK)
        status = air_mitsuba_integer(mitsuba, at, "resolution", &width);
    if (status == AIR_OK && (width < 2 || width > 16384 || width % 2 != 0))
        status = air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                  "expected an even resolution of 2 to 16384, found %ld", width);
    sky->width = (size_t)width;
    return status == AIR_OK ? read_directions(mitsuba, at, sky) : status;
}

static air_status add_image(air_mitsuba *mitsuba, const air_sun_sky *sky, const float *rgb,
                            const char *name)
{
    const air_texture_desc texture = {.name = name,
                                      .width = sky->width,
                                      .height = sky->width / 2,
                                      .channels = 3,
                                      .floats = rgb,
                                      .wrap_u = AIR_WRAP_REPEAT,
                                      .wrap_v = AIR_WRAP_CLAMP};
    air_light_desc desc;
    air_handle handle = AIR_NONE;
    air_light_desc_default(&desc);
    desc.name = name;
    desc.kind = AIR_LIGHT_ENVIRONMENT;
    desc.color[0] = desc.color[1] = desc.color[2] = mitsuba->light_scale;
    memcpy(desc.to_world, sky->to_world, sizeof desc.to_world);
    const air_status status = air_scene_add_texture(mitsuba->import->scene, &texture, &desc.image);
    return status == AIR_OK ? air_scene_add_light(mitsuba->import->scene, &desc, &handle) : status;
}

static air_status add_sun(air_mitsuba *mitsuba, const air_sun_sky *sky, const float irradiance[3],
                          const char *name)
{
    air_light_desc desc;
    air_handle handle = AIR_NONE;
    air_light_desc_default(&desc);
    desc.name = name;
    desc.kind = AIR_LIGHT_COLLIMATED;
    vec3_store(desc.color, vec3_scale(vec3_load(irradiance), mitsuba->light_scale));
    vec3_store(desc.dir, vec3_neg(vec3_load(sky->sun_dir)));
    return air_scene_add_light(mitsuba->import->scene, &desc, &handle);
}

/* Where one element is a sky and its sun, each has a name of its own, by which --method knows it.
 */
static void name_part(const air_xml *at, const char *name, const char *part, char out[NAME])
{
    if (!air_mitsuba_is(at, "sunsky"))
        snprintf(out, NAME, "%s", name);
    else if (strcmp(name, "sunsky") == 0)
        snprintf(out, NAME, "%s", part);
    else
        snprintf(out, NAME, "%s.%s", name, part);
}

air_status air_mitsuba_add_sky(air_mitsuba *mitsuba, air_xml *at, const char *name)
{
    air_sun_sky sky;
    char sky_name[NAME], sun_name[NAME];
    float irradiance[3] = {0.0f, 0.0f, 0.0f};
    air_status status = read_sky(mitsuba, at, &sky);
    /* the real one has half an angle of 0.27 degrees, whose shadows are as good as sharp */
    if (status == AIR_OK && sky.sun_scale > 0.0f && sky.sun_radius_scale > 1.0f)
        status = air_mitsuba_warn(mitsuba, at,
                                  "the sun is taken without extent: sun_radius_scale %g would make "
                                  "its shadows soft",
                                  (double)sky.sun_radius_scale);
    if (status != AIR_OK)
        return status;
    name_part(at, name, "sky", sky_name);
    name_part(at, name, "sun", sun_name);
    float *rgb = air_allocate(mitsuba->context, sky.width * (sky.width / 2), 3 * sizeof *rgb);
    if (rgb == NULL)
        return air_fail_memory(mitsuba->context, mitsuba->path);
    status = air_sun_sky_image(mitsuba->context, &sky, rgb, irradiance);
    if (status == AIR_OK && sky.sky_scale > 0.0f)
        status = add_image(mitsuba, &sky, rgb, sky_name);
    if (status == AIR_OK && sky.sun_scale > 0.0f)
        status = add_sun(mitsuba, &sky, irradiance, sun_name);
    air_free(mitsuba->context, rgb);
    return status == AIR_OK ? status : air_xml_place_error(&mitsuba->document, at, status);
}
