#include <ctype.h>
#include <string.h>

#include "scene/import/json_place.h"
#include "scene/import/mitsuba/mitsuba.h"
#include "scene/import/spectrum.h"

/* Indices of refraction by name, at 589 nm [Hecht2002, table 4.1]. */
static const struct {
    const char *name;
    float ior;
} materials[] = {
    {"vacuum", 1.0f},      {"helium", 1.000036f},        {"hydrogen", 1.000132f},
    {"air", 1.000277f},    {"carbon dioxide", 1.00045f}, {"water", 1.333f},
    {"acetone", 1.36f},    {"ethanol", 1.361f},          {"carbon tetrachloride", 1.461f},
    {"glycerol", 1.4729f}, {"benzene", 1.501f},          {"silicone oil", 1.52045f},
    {"bromine", 1.661f},   {"water ice", 1.31f},         {"fused quartz", 1.458f},
    {"pyrex", 1.47f},      {"acrylic glass", 1.49f},     {"polypropylene", 1.49f},
    {"bk7", 1.5046f},      {"sodium chloride", 1.544f},  {"amber", 1.55f},
    {"pet", 1.575f},       {"diamond", 2.419f}};
enum { MATERIALS = sizeof materials / sizeof *materials };

static const float ior_of_air = 1.000277f;

static air_status find_ior(const air_mitsuba *mitsuba, const air_xml *at, const char *name,
                           float *value)
{
    const char *names[MATERIALS];
    char lower[40] = "";
    for (size_t i = 0; i + 1 < sizeof lower && name[i] != '\0'; ++i)
        lower[i] = (char)tolower((unsigned char)name[i]);
    for (size_t i = 0; i < MATERIALS; ++i) {
        names[i] = materials[i].name;
        if (strcmp(lower, names[i]) == 0) {
            *value = materials[i].ior;
            return AIR_OK;
        }
    }
    const char *nearest = air_nearest_name(lower, names, MATERIALS);
    return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                            "no index of refraction is known for \"%.60s\"%s%s%s", name,
                            nearest != NULL ? "; did you mean \"" : ", expected a number or a name",
                            nearest != NULL ? nearest : "", nearest != NULL ? "\"?" : "");
}

/* A number, or the name of a material. */
static air_status read_ior(const air_mitsuba *mitsuba, const air_xml *at, const char *name,
                           float *value)
{
    const air_xml *found = air_mitsuba_parameter(at, name);
    const char *text = "";
    air_status status = AIR_OK;
    if (found == NULL)
        return AIR_OK;
    if (strcmp(found->tag, "string") != 0)
        status = air_mitsuba_float(mitsuba, at, name, value);
    else
        status = air_mitsuba_string(mitsuba, at, name, &text);
    if (status == AIR_OK && strcmp(found->tag, "string") == 0)
        status = find_ior(mitsuba, found, text, value);
    if (status == AIR_OK && !(*value > 0.0f))
        status =
            air_mitsuba_fail(mitsuba, found, AIR_ERROR_FORMAT,
                             "expected an index of refraction above 0, found %g", (double)*value);
    return status;
}

static air_status read_relative_ior(const air_mitsuba *mitsuba, const air_xml *at, float inside,
                                    air_material_desc *desc)
{
    float outside = ior_of_air;
    air_status status = read_ior(mitsuba, at, "int_ior", &inside);
    if (status == AIR_OK)
        status = read_ior(mitsuba, at, "ext_ior", &outside);
    desc->ior = inside / outside;
    return status;
}

/* Distribution and width of the facets of what is called rough. */
static air_status read_facets(const air_mitsuba *mitsuba, const air_xml *at,
                              air_material_desc *desc)
{
    static const char *const names[] = {"ggx", "beckmann", "phong", "as"};
    static const char *const ignored[] = {"sample_visible"};
    size_t distribution = AIR_MICROFACETS_BECKMANN;
    float alpha = 0.1f;
    if (strncmp(air_mitsuba_type(at), "rough", 5) != 0)
        return AIR_OK;
    air_mitsuba_ignore(at, ignored, 1);
    air_status status = air_mitsuba_choice(mitsuba, at, "distribution", names, 4, &distribution);
    if (status == AIR_OK && distribution > AIR_MICROFACETS_BECKMANN) {
        distribution = AIR_MICROFACETS_BECKMANN;
        status = air_mitsuba_replace(mitsuba, at, "this distribution of facets is not supported",
                                     "beckmann is taken");
    }
    if (status == AIR_OK)
        status = air_mitsuba_float(mitsuba, at, "alpha", &alpha);
    desc->microfacets = (air_microfacets)distribution;
    desc->alpha_u = desc->alpha_v = alpha;
    if (status == AIR_OK)
        status = air_mitsuba_float(mitsuba, at, "alpha_u", &desc->alpha_u);
    if (status == AIR_OK)
        status = air_mitsuba_float(mitsuba, at, "alpha_v", &desc->alpha_v);
    if (status == AIR_OK && !(desc->alpha_u >= 0.0f && desc->alpha_v >= 0.0f))
        status = air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                  "expected an alpha that is not below 0");
    return status;
}

/* A perfect mirror as a metal: with eta towards 0 and absorption 1 all light is reflected at every
 * angle. */
static void set_mirror(air_material_desc *desc)
{
    for (size_t i = 0; i < 3; ++i) {
        desc->eta[i] = 1e-6f;
        desc->absorption[i] = 1.0f;
    }
}

/* By name, or eta and k; version 3 takes neither for a mirror, 0.x for copper. */
static air_status read_metal(const air_mitsuba *mitsuba, const air_xml *at, air_material_desc *desc)
{
    const char *name = air_mitsuba_is_old(at) ? "Cu" : "none";
    float outside = air_mitsuba_is_old(at) ? ior_of_air : 1.0f;
    air_status status = air_mitsuba_string(mitsuba, at, "material", &name);
    if (status == AIR_OK)
        status = read_ior(mitsuba, at, "ext_eta", &outside);
    if (status != AIR_OK)
        return status;
    const bool given = air_mitsuba_has(at, "eta") || air_mitsuba_has(at, "k");
    if (given || strcmp(name, "none") == 0)
        set_mirror(desc);
    else if (!air_metal_find(name, desc->eta, desc->absorption))
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                "no metal \"%.60s\" is known, expected eta and k", name);
    status = air_mitsuba_color(mitsuba, at, "eta", AIR_MITSUBA_REFLECTANCE, desc->eta);
    if (status == AIR_OK)
        status = air_mitsuba_color(mitsuba, at, "k", AIR_MITSUBA_REFLECTANCE, desc->absorption);
    for (size_t i = 0; i < 3; ++i) {
        desc->eta[i] = desc->eta[i] > 0.0f ? desc->eta[i] / outside : 1e-6f;
        desc->absorption[i] /= outside;
    }
    return status;
}

static air_status read_plastic(air_mitsuba *mitsuba, const air_xml *at, air_material_desc *desc)
{
    desc->base_color[0] = desc->base_color[1] = desc->base_color[2] = 0.5f;
    air_status status =
        air_mitsuba_textured(mitsuba, at, "diffuse_reflectance", AIR_MITSUBA_REFLECTANCE,
                             desc->base_color, &desc->base_color_texture);
    if (status == AIR_OK)
        status = air_mitsuba_boolean(mitsuba, at, "nonlinear", &desc->nonlinear);
    return status;
}

/* Their names, and which index of refraction they have inside by default: that of bk7, or of
 * polypropylene. */
static const struct {
    const char *type;
    air_material_model model;
    float ior;
} interfaces[] = {{"dielectric", AIR_MATERIAL_DIELECTRIC, 1.5046f},
                  {"roughdielectric", AIR_MATERIAL_DIELECTRIC, 1.5046f},
                  {"thindielectric", AIR_MATERIAL_THIN_DIELECTRIC, 1.5046f},
                  {"conductor", AIR_MATERIAL_CONDUCTOR, 0.0f},
                  {"roughconductor", AIR_MATERIAL_CONDUCTOR, 0.0f},
                  {"plastic", AIR_MATERIAL_PLASTIC, 1.49f},
                  {"roughplastic", AIR_MATERIAL_PLASTIC, 1.49f}};
enum { INTERFACES = sizeof interfaces / sizeof *interfaces };

bool air_mitsuba_is_interface(const air_xml *at)
{
    for (size_t i = 0; i < INTERFACES; ++i)
        if (air_mitsuba_is(at, interfaces[i].type))
            return true;
    return false;
}

air_status air_mitsuba_read_interface(air_mitsuba *mitsuba, air_xml *at, air_material_desc *desc)
{
    size_t i = 0;
    while (!air_mitsuba_is(at, interfaces[i].type))
        ++i;
    desc->model = interfaces[i].model;
    desc->one_sided = !mitsuba->both_sides && (desc->model == AIR_MATERIAL_CONDUCTOR ||
                                               desc->model == AIR_MATERIAL_PLASTIC);
    for (size_t c = 0; c < 3; ++c)
        desc->reflectance[c] = desc->transmittance[c] = 1.0f;
    air_status status = air_mitsuba_color(mitsuba, at, "specular_reflectance",
                                          AIR_MITSUBA_REFLECTANCE, desc->reflectance);
    if (status == AIR_OK)
        status = air_mitsuba_color(mitsuba, at, "specular_transmittance", AIR_MITSUBA_REFLECTANCE,
                                   desc->transmittance);
    if (status == AIR_OK)
        status = read_facets(mitsuba, at, desc);
    if (status == AIR_OK && desc->model == AIR_MATERIAL_CONDUCTOR)
        return read_metal(mitsuba, at, desc);
    if (status == AIR_OK)
        status = read_relative_ior(mitsuba, at, interfaces[i].ior, desc);
    if (status == AIR_OK && desc->model == AIR_MATERIAL_PLASTIC)
        status = read_plastic(mitsuba, at, desc);
    return status;
}
