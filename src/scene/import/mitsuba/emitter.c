#include <math.h>
#include <string.h>

#include "core/vec.h"
#include "scene/import/mitsuba/mitsuba.h"
#include "scene/scene.h"
#include "scene/texture.h"

static const float identity[12] = {1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f,
                                   0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f};

static air_status read_quantity(const air_mitsuba *mitsuba, const air_xml *at, const char *name,
                                air_light_desc *desc)
{
    desc->color[0] = desc->color[1] = desc->color[2] = 1.0f;
    const air_status status =
        air_mitsuba_color(mitsuba, at, name, AIR_MITSUBA_EMISSION, desc->color);
    for (size_t i = 0; i < 3; ++i)
        desc->color[i] *= mitsuba->light_scale;
    return status;
}

/* Where the emitter's origin and its axis +Z go. */
static air_status read_place(const air_mitsuba *mitsuba, const air_xml *at, air_light_desc *desc)
{
    float m[12];
    memcpy(m, identity, sizeof identity);
    const air_status status = air_mitsuba_transform(mitsuba, at, "to_world", m);
    const air_vec3 axis = vec3(m[2], m[6], m[10]);
    if (status == AIR_OK && !(vec3_length(axis) > 0.0f))
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                "to_world scales the direction to nothing");
    vec3_store(desc->position, vec3(m[3], m[7], m[11]));
    vec3_store(desc->dir, vec3_normalize(axis));
    return status;
}

static air_status read_point(air_mitsuba *mitsuba, const air_xml *at, air_light_desc *desc)
{
    desc->kind = AIR_LIGHT_POINT;
    air_status status = read_place(mitsuba, at, desc);
    if (status == AIR_OK)
        status = air_mitsuba_vector(mitsuba, at, "position", desc->position);
    return status == AIR_OK ? read_quantity(mitsuba, at, "intensity", desc) : status;
}

/* The intensity is whole up to the beam's width and falls off linearly in the angle; both angles
 * are those between the axis and the cone. */
static air_status read_spot(air_mitsuba *mitsuba, const air_xml *at, air_light_desc *desc)
{
    const double radian = AIR_PI / 180.0;
    float cutoff = 20.0f;
    desc->kind = AIR_LIGHT_SPOT;
    desc->falloff = AIR_SPOT_ANGLE;
    air_status status = read_place(mitsuba, at, desc);
    if (status == AIR_OK)
        status = read_quantity(mitsuba, at, "intensity", desc);
    if (status == AIR_OK)
        status = air_mitsuba_float(mitsuba, at, "cutoff_angle", &cutoff);
    float width = 0.75f * cutoff;
    if (status == AIR_OK)
        status = air_mitsuba_float(mitsuba, at, "beam_width", &width);
    if (status == AIR_OK && !(width >= 0.0f && width <= cutoff && cutoff > 0.0f && cutoff <= 90.0f))
        status = air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                  "expected 0 <= beam_width <= cutoff_angle <= 90 degrees, found "
                                  "%g and %g",
                                  (double)width, (double)cutoff);
    desc->outer_cone_rad = fminf((float)((double)cutoff * radian), 1.57079632f);
    /* equal angles mean a hard edge, but the falloff divides by their distance */
    desc->inner_cone_rad = fminf((float)((double)width * radian), 0.9999f * desc->outer_cone_rad);
    if (status == AIR_OK && air_mitsuba_has(at, "texture"))
        status =
            air_mitsuba_replace(mitsuba, air_mitsuba_parameter(at, "texture"),
                                "textures of spots are not supported", "the spot shines without");
    return status;
}

static air_status read_directional(air_mitsuba *mitsuba, const air_xml *at, air_light_desc *desc)
{
    desc->kind = AIR_LIGHT_COLLIMATED;
    air_status status = read_place(mitsuba, at, desc);
    if (status == AIR_OK)
        status = air_mitsuba_vector(mitsuba, at, "direction", desc->dir);
    if (status == AIR_OK && vec3_is_zero(vec3_load(desc->dir)))
        status =
            air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT, "expected a direction that is not 0");
    return status == AIR_OK ? read_quantity(mitsuba, at, "irradiance", desc) : status;
}

/* Mitsuba's images have -Z at their left edge, so +Z in the middle, where airlight's have -Z: half
 * a turn about Y comes first. A rotation is what is left of to_world without its scale. */
static air_status read_rotation(const air_mitsuba *mitsuba, const air_xml *at, float out[9])
{
    static const float half_turn[3] = {-1.0f, 1.0f, -1.0f};
    float m[12];
    memcpy(m, identity, sizeof identity);
    const air_status status = air_mitsuba_transform(mitsuba, at, "to_world", m);
    if (status != AIR_OK)
        return status;
    air_vec3 columns[3];
    for (size_t i = 0; i < 3; ++i)
        columns[i] = vec3_normalize(vec3(m[i], m[4 + i], m[8 + i]));
    const float skew = fabsf(vec3_dot(columns[0], columns[1])) +
                       fabsf(vec3_dot(columns[1], columns[2])) +
                       fabsf(vec3_dot(columns[2], columns[0]));
    if (!(affine_determinant(m) > 0.0) || !(skew < 1e-3f))
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_UNSUPPORTED,
                                "expected to_world to be a rotation: mirrored and skewed "
                                "environments are not supported");
    for (size_t i = 0; i < 3; ++i) {
        out[i] = columns[i].x * half_turn[i];
        out[3 + i] = columns[i].y * half_turn[i];
        out[6 + i] = columns[i].z * half_turn[i];
    }
    return AIR_OK;
}

static air_status read_envmap(air_mitsuba *mitsuba, const air_xml *at, air_light_desc *desc)
{
    static const char *const ignored[] = {"cache", "mis_compensation", "gamma"};
    const char *name = NULL;
    char *path = NULL;
    float scale = 1.0f;
    desc->kind = AIR_LIGHT_ENVIRONMENT;
    air_mitsuba_ignore(at, ignored, sizeof ignored / sizeof *ignored);
    air_status status = air_mitsuba_filename(mitsuba, at, &name);
    if (status == AIR_OK)
        status = air_mitsuba_float(mitsuba, at, "scale", &scale);
    if (status == AIR_OK)
        status = read_rotation(mitsuba, at, desc->to_world);
    if (status == AIR_OK)
        status = air_mitsuba_file(mitsuba, at, name, &path);
    if (status == AIR_OK)
        status = air_xml_place_error(
            &mitsuba->document, at,
            air_import_environment_texture(mitsuba->import, path, &desc->image));
    air_free(mitsuba->context, path);
    for (size_t i = 0; i < 3; ++i)
        desc->color[i] = scale * mitsuba->light_scale;
    return status;
}

/* The same from everywhere; to_world would turn nothing. */
static air_status read_constant(air_mitsuba *mitsuba, const air_xml *at, air_light_desc *desc)
{
    static const char *const ignored[] = {"to_world"};
    desc->kind = AIR_LIGHT_ENVIRONMENT;
    air_mitsuba_ignore(at, ignored, 1);
    return read_quantity(mitsuba, at, "radiance", desc);
}

/* Width over height of a projector's picture, 1 without. */
static double picture_aspect(const air_mitsuba *mitsuba, air_handle image)
{
    const air_slot_list *list = &mitsuba->import->scene->lists[AIR_OBJECT_TEXTURE];
    const size_t index = air_slot_find(list, image);
    if (index == SIZE_MAX)
        return 1.0;
    const air_texture *texture = &((const air_texture_record *)list->slots[index].record)->texture;
    return (double)texture->width / (double)texture->height;
}

/* Irradiance on a screen at distance 1 times pi over the cosine's cube is the intensity; the
 * picture lies as that of a sensor [Mitsuba3, projector]. */
static air_status read_projector(air_mitsuba *mitsuba, const air_xml *at, air_light_desc *desc)
{
    static const float plain[6] = {1, 0, 0, 0, 1, 0};
    float scale = 1.0f;
    double tangent = 0.0;
    air_texture_ref ref;
    desc->kind = AIR_LIGHT_PROJECTOR;
    desc->color[0] = desc->color[1] = desc->color[2] = 1.0f;
    air_status status =
        air_mitsuba_textured(mitsuba, at, "irradiance", AIR_MITSUBA_EMISSION, desc->color, &ref);
    if (status == AIR_OK && memcmp(ref.uv_transform, plain, sizeof plain) != 0)
        status = air_mitsuba_replace(mitsuba, at, "a picture with a to_uv is not supported",
                                     "it is shown as it is");
    if (status == AIR_OK)
        status = air_mitsuba_float(mitsuba, at, "scale", &scale);
    if (status == AIR_OK)
        status = read_place(mitsuba, at, desc);
    if (status == AIR_OK)
        status = read_rotation(mitsuba, at, desc->to_world);
    const double aspect = picture_aspect(mitsuba, ref.texture);
    if (status == AIR_OK)
        status = air_mitsuba_read_fov(mitsuba, at, aspect, &tangent);
    desc->image = ref.texture;
    desc->fov_x_rad = (float)(2.0 * atan(tangent * aspect));
    for (size_t i = 0; i < 3; ++i)
        desc->color[i] *= AIR_PI_F * scale * mitsuba->light_scale;
    return status;
}

typedef air_status (*air_mitsuba_light_reader)(air_mitsuba *mitsuba, const air_xml *at,
                                               air_light_desc *desc);

static const struct {
    const char *type;
    air_mitsuba_light_reader read;
} readers[] = {{"point", read_point},
               {"spot", read_spot},
               {"envmap", read_envmap},
               {"directional", read_directional},
               {"constant", read_constant},
               {"projector", read_projector},
               {"sunsky", NULL},
               {"sky", NULL},
               {"sun", NULL}};
enum { READERS = sizeof readers / sizeof *readers };

static air_status add_light(const air_mitsuba *mitsuba, const air_xml *at,
                            const air_light_desc *desc)
{
    air_handle handle = AIR_NONE;
    const air_status status = air_scene_add_light(mitsuba->import->scene, desc, &handle);
    return status == AIR_OK ? status : air_xml_place_error(&mitsuba->document, at, status);
}

air_status air_mitsuba_add_emitter(air_mitsuba *mitsuba, air_xml *at, const char *name,
                                   bool casts_shadow)
{
    static const char *const ignored[] = {"sampling_weight"};
    const char *types[READERS];
    air_light_desc desc;
    air_xml *medium = NULL;
    at->asked = true;
    air_mitsuba_ignore(at, ignored, 1);
    /* the medium around it is where it is without being told */
    air_status status = air_mitsuba_child(mitsuba, at, "medium", NULL, &medium);
    air_light_desc_default(&desc);
    desc.name = name;
    desc.casts_shadow = casts_shadow;
    for (size_t i = 0; i < READERS && status == AIR_OK; ++i) {
        types[i] = readers[i].type;
        if (!air_mitsuba_is(at, types[i]))
            continue;
        if (readers[i].read == NULL)
            return air_mitsuba_add_sky(mitsuba, at, name);
        status = readers[i].read(mitsuba, at, &desc);
        return status == AIR_OK ? add_light(mitsuba, at, &desc) : status;
    }
    return status == AIR_OK
               ? air_mitsuba_unknown_type(mitsuba, at, types, READERS, "it is left out")
               : status;
}

/* A sun seen through a window of the rectangle's shape, along its normal. The radiance that
 * Mitsuba calls so is power per area: directions have no extent. */
air_status air_mitsuba_add_collimated(air_mitsuba *mitsuba, air_xml *emitter, const air_xml *shape,
                                      const air_mitsuba_geometry *geometry, const char *name)
{
    const air_mesh_file *mesh = &geometry->mesh;
    float corners[12], inverse[12];
    air_light_desc desc;
    air_light_desc_default(&desc);
    emitter->asked = true;
    if (!air_mitsuba_is(shape, "rectangle"))
        return air_mitsuba_replace(mitsuba, emitter,
                                   "directionalarea is supported for rectangles only",
                                   "the shape does not shine");
    const air_status status = read_quantity(mitsuba, emitter, "radiance", &desc);
    if (status != AIR_OK || !affine_invert(geometry->to_world, inverse))
        return status;
    for (size_t i = 0; i < 4; ++i)
        vec3_store(corners + 3 * i,
                   affine_point(geometry->to_world, vec3_load(mesh->positions + 3 * i)));
    const air_gobo_window window = {corners, 4};
    desc.kind = AIR_LIGHT_COLLIMATED;
    desc.name = name[0] != '\0' ? name : "directionalarea";
    desc.windows = &window;
    desc.window_count = 1;
    vec3_store(desc.dir, vec3_normalize(affine_normal(inverse, vec3_load(mesh->normals))));
    return add_light(mitsuba, emitter, &desc);
}
