/* What the materials and textures of a scene file become. */
#include "mitsuba_fixture.h"
#include "scene/texture.h"

#define CUBE(inside) "<shape type='cube'>" inside "</shape>"

static void diffuse_surfaces_are_lambertian(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "0.6.0",
                  CUBE("<bsdf type='diffuse'><srgb name='reflectance' value='#ff8000'/></bsdf>")
                      CUBE("<bsdf type='twosided'><bsdf type='diffuse'>"
                           "<rgb name='diffuseReflectance' value='.25'/></bsdf></bsdf>") CUBE(""));
    const air_material_desc *desc = mitsuba_material(self, 0);
    assert_int_equal(desc->model, AIR_MATERIAL_METALLIC_ROUGHNESS);
    assert_true(desc->specular == 0.0f && desc->metallic == 0.0f);
    /* 128/255 by the sRGB curve: ((0.50196 + 0.055) / 1.055)^2.4 */
    assert_floats(desc->base_color, 3, (const float[]){1.0f, 0.21586f, 0.0f});
    assert_floats(mitsuba_material(self, 1)->base_color, 3, (const float[]){.25f, .25f, .25f});
    assert_floats(mitsuba_material(self, 2)->base_color, 3, (const float[]){.5f, .5f, .5f});
}

/* Mitsuba's opaque surfaces are black from behind, unless they are told to have two sides. */
static void surfaces_have_a_side(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "3.0.0",
                  CUBE("<bsdf type='diffuse'/>") CUBE("<bsdf type='conductor'/>")
                      CUBE("<bsdf type='dielectric'/>")
                          CUBE("<bsdf type='twosided'><bsdf type='plastic' id='p'/></bsdf>")
                              CUBE("<ref id='p'/>")
                                  CUBE("<bsdf type='twosided'><bsdf type='diffuse'/></bsdf>"
                                       "<emitter type='area'/>"));
    const bool one_sided[] = {true, true, false, false, true, false};
    const bool double_sided[] = {false, false, false, true, false, false}; /* no lamp is */
    for (size_t i = 0; i < 6; ++i) {
        assert_true(mitsuba_material(self, i)->one_sided == one_sided[i]);
        assert_true(mitsuba_material(self, i)->double_sided == double_sided[i]);
    }
}

static void interfaces_have_their_indices(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "3.0.0",
                  CUBE("<bsdf type='dielectric'/>")
                      CUBE("<bsdf type='roughdielectric'><string name='int_ior' value='water'/>"
                           "<float name='ext_ior' value='1'/><float name='alpha_u' value='.2'/>"
                           "<float name='alpha_v' value='.3'/>"
                           "<string name='distribution' value='GGX'/></bsdf>")
                          CUBE("<bsdf type='thindielectric'>"
                               "<float name='specular_transmittance' value='.5'/></bsdf>")
                              CUBE("<bsdf type='roughplastic'><boolean name='nonlinear' "
                                   "value='true'/>"
                                   "<rgb name='diffuse_reflectance' value='.1 .2 .3'/></bsdf>"));
    const air_material_desc *glass = mitsuba_material(self, 0), *rough = mitsuba_material(self, 1);
    assert_int_equal(glass->model, AIR_MATERIAL_DIELECTRIC);
    assert_floats(&glass->ior, 1, (const float[]){1.5046f / 1.000277f});
    assert_true(glass->alpha_u == 0.0f);
    assert_floats(glass->reflectance, 3, (const float[]){1, 1, 1});
    assert_floats(&rough->ior, 1, (const float[]){1.333f});
    assert_int_equal(rough->microfacets, AIR_MICROFACETS_GGX);
    assert_true(rough->alpha_u == 0.2f && rough->alpha_v == 0.3f);
    assert_int_equal(mitsuba_material(self, 2)->model, AIR_MATERIAL_THIN_DIELECTRIC);
    assert_floats(mitsuba_material(self, 2)->transmittance, 3, (const float[]){.5f, .5f, .5f});
    const air_material_desc *plastic = mitsuba_material(self, 3);
    assert_int_equal(plastic->model, AIR_MATERIAL_PLASTIC);
    assert_true(plastic->nonlinear && plastic->alpha_u == 0.1f);
    assert_int_equal(plastic->microfacets, AIR_MICROFACETS_BECKMANN);
    assert_floats(plastic->base_color, 3, (const float[]){.1f, .2f, .3f});
    assert_floats(&plastic->ior, 1, (const float[]){1.49f / 1.000277f});
    mitsuba_refuses(self, "3.0.0",
                    CUBE("<bsdf type='dielectric'><string name='int_ior' value='watr'/></bsdf>"),
                    "line 2: <string name=\"int_ior\">: no index of refraction is known for "
                    "\"watr\"; did you mean \"water\"?");
}

/* Version 3 has a mirror where 0.x has copper. */
static void metals_have_their_defaults(void **state)
{
    import_fixture *self = *state;
    const char *bare = CUBE("<bsdf type='conductor'/>");
    mitsuba_loads(self, "3.0.0", bare);
    assert_true(mitsuba_material(self, 0)->eta[0] < 1e-3f);
    mitsuba_loads(self, "0.6.0", bare);
    const air_material_desc *copper = mitsuba_material(self, 0);
    assert_int_equal(copper->model, AIR_MATERIAL_CONDUCTOR);
    assert_true(copper->eta[0] > 0.1f && copper->eta[2] > copper->eta[0]); /* it is red */
    mitsuba_loads(self, "0.6.0",
                  CUBE("<bsdf type='roughconductor'><rgb name='eta' value='1 2 3'/>"
                       "<rgb name='k' value='4 5 6'/><float name='extEta' value='2'/></bsdf>"));
    assert_floats(mitsuba_material(self, 0)->eta, 3, (const float[]){.5f, 1, 1.5f});
    assert_floats(mitsuba_material(self, 0)->absorption, 3, (const float[]){2, 2.5f, 3});
}

static void surfaces_around_others_add_to_them(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "3.0.0",
                  CUBE("<bsdf type='mask'><float name='opacity' value='.25'/>"
                       "<bsdf type='plastic'/></bsdf>")
                      CUBE("<bsdf type='bumpmap'><texture type='checkerboard'/>"
                           "<float name='scale' value='3'/><bsdf type='diffuse'/></bsdf>")
                          CUBE("<bsdf type='normalmap'><texture type='checkerboard' "
                               "name='normalmap'/><bsdf type='diffuse'/></bsdf>"));
    assert_int_equal(mitsuba_material(self, 0)->model, AIR_MATERIAL_PLASTIC);
    assert_int_equal(mitsuba_material(self, 0)->alpha_mode, AIR_ALPHA_BLEND);
    assert_true(mitsuba_material(self, 0)->base_color[3] == 0.25f);
    assert_true(mitsuba_material(self, 1)->bump_texture.texture != AIR_NONE);
    assert_true(mitsuba_material(self, 1)->bump_scale == 3.0f);
    assert_true(mitsuba_material(self, 2)->normal_texture.texture != AIR_NONE);
}

static void blends_have_two_parts(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "3.0.0",
                  CUBE("<bsdf type='blendbsdf'><float name='weight' value='.3'/>"
                       "<bsdf type='diffuse' id='a'/><bsdf type='conductor' id='b'/></bsdf>"));
    assert_int_equal(mitsuba_count(self, AIR_OBJECT_MATERIAL), 3);
    const air_material_desc *blend = mitsuba_material(self, 2);
    assert_int_equal(blend->model, AIR_MATERIAL_BLEND);
    assert_true(blend->blend_weight == 0.3f);
    assert_true(blend->blend[0] == self->scene->lists[AIR_OBJECT_MATERIAL].slots[0].handle);
    assert_true(blend->blend[1] == self->scene->lists[AIR_OBJECT_MATERIAL].slots[1].handle);
    mitsuba_refuses(self, "3.0.0", CUBE("<bsdf type='blendbsdf'><bsdf type='null'/></bsdf>"),
                    "line 2: <bsdf type=\"blendbsdf\">: expected two <bsdf> within it");
    mitsuba_refuses(self, "3.0.0",
                    CUBE("<bsdf type='blendbsdf'><bsdf type='diffuse'/><bsdf type='null'/></bsdf>"),
                    "line 2: <bsdf type=\"null\">: a null surface within a blend is not supported, "
                    "expected a mask around the other");
}

static void lamps_are_black_where_nothing_is_said(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "3.0.0",
                  "<emitter type='area' id='lamp'><rgb name='radiance' value='1 2 3'/></emitter>"
                  "<shape type='rectangle'><ref id='lamp'/></shape>"
                  "<shape type='rectangle'><bsdf type='diffuse'/><ref id='lamp'/></shape>");
    assert_floats(mitsuba_material(self, 0)->emission, 3, (const float[]){1, 2, 3});
    assert_floats(mitsuba_material(self, 0)->base_color, 3, (const float[]){0, 0, 0});
    assert_false(mitsuba_material(self, 0)->double_sided);
    assert_floats(mitsuba_material(self, 1)->base_color, 3, (const float[]){.5f, .5f, .5f});
}

/* What nobody can see is not there at all. */
static void null_surfaces_are_no_meshes(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "3.0.0", CUBE("<bsdf type='null'/>"));
    assert_int_equal(mitsuba_count(self, AIR_OBJECT_MESH), 0);
}

static void materials_are_shared(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "3.0.0",
                  "<texture type='checkerboard' id='t'/><bsdf type='diffuse' id='m'>"
                  "<ref name='reflectance' id='t'/></bsdf><bsdf type='diffuse' id='n'>"
                  "<ref name='reflectance' id='t'/></bsdf>" CUBE("<ref id='m'/>")
                      CUBE("<ref id='m'/>") CUBE("<ref id='n'/>"));
    assert_int_equal(mitsuba_count(self, AIR_OBJECT_MATERIAL), 2);
    assert_int_equal(mitsuba_count(self, AIR_OBJECT_TEXTURE), 1);
}

static void unsupported_surfaces_say_so(void **state)
{
    import_fixture *self = *state;
    const char *scene = CUBE("<bsdf type='phong'><rgb name='diffuseReflectance' value='.1'/>"
                             "<float name='exponent' value='9'/></bsdf>");
    mitsuba_refuses(
        self, "0.6.0", scene,
        "line 2: <bsdf type=\"phong\">: the bsdf \"phong\" is not supported (--lenient: "
        "a diffuse surface of its colour is taken)");
    self->params.lenient = true;
    mitsuba_loads(self, "0.6.0", scene);
    assert_floats(mitsuba_material(self, 0)->base_color, 3, (const float[]){.1f, .1f, .1f});
}

/* Numbers and colours that cannot be textures here, given as one or as a reference to one. */
static void textures_where_none_can_be_say_so(void **state)
{
    import_fixture *self = *state;
    const char *scene = "<texture type='checkerboard' id='t'/>" CUBE(
        "<bsdf type='roughconductor'><texture name='alpha' type='checkerboard'>"
        "<float name='color0' value='.1'/></texture>"
        "<ref name='specular_reflectance' id='t'/></bsdf>");
    mitsuba_refuses(self, "3.0.0", scene,
                    "line 2: <ref name=\"specular_reflectance\" id=\"t\">: a texture is not "
                    "supported here (--lenient: the parameter's default is taken)");
    self->params.lenient = true;
    mitsuba_loads(self, "3.0.0", scene);
    const air_material_desc *metal = mitsuba_material(self, 0);
    assert_floats(&metal->alpha_u, 1, (const float[]){0.1f});
    assert_floats(metal->reflectance, 3, (const float[]){1.0f, 1.0f, 1.0f});
}

/* ---- textures ---- */

/* [Mitsuba3], checkerboard: color0 where the halves of u and v are alike. */
static void checkerboards_are_exact(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "3.0.0",
                  CUBE("<bsdf type='diffuse'><texture name='reflectance' type='checkerboard'>"
                       "<rgb name='color0' value='1 0 0'/><rgb name='color1' value='0 1 0'/>"
                       "<transform name='to_uv'><scale x='2' y='3'/><translate x='.25'/>"
                       "</transform></texture></bsdf>"));
    assert_int_equal(air_scene_commit(self->scene, &self->snapshot, NULL), AIR_OK);
    const air_texture_record *record =
        (const air_texture_record *)mitsuba_record(self, AIR_OBJECT_TEXTURE, 0);
    for (int i = 0; i < 400; ++i) {
        const float u = ((float)(i % 20) + 0.5f) / 20.0f, v = ((float)(i / 20) + 0.5f) / 20.0f;
        const air_vec3 color = air_texture_rgb(&record->texture, u, v);
        assert_true(color.x == ((u > 0.5f) == (v > 0.5f) ? 1.0f : 0.0f));
    }
    assert_floats(mitsuba_material(self, 0)->base_color_texture.uv_transform, 6,
                  (const float[]){2, 0, .25f, 0, 3, 0});
}

static void old_textures_have_scale_and_offset(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "0.6.0",
                  CUBE("<bsdf type='diffuse'><texture name='reflectance' type='scale'>"
                       "<float name='scale' value='.5'/><texture type='checkerboard'>"
                       "<float name='uvscale' value='4'/><float name='vscale' value='2'/>"
                       "<float name='uoffset' value='.1'/></texture></texture></bsdf>"));
    const air_material_desc *desc = mitsuba_material(self, 0);
    assert_floats(desc->base_color_texture.uv_transform, 6, (const float[]){4, 0, .1f, 0, 2, 0});
    assert_floats(desc->base_color, 3, (const float[]){.5f, .5f, .5f});
}

/* A PFM of one texel. */
static void bitmaps_are_sampled_as_they_say(void **state)
{
    import_fixture *self = *state;
    static uint8_t pfm[64];
    const char *header = "PF\n1 1\n-1.0\n";
    const float texel[3] = {0.5f, 0.25f, 0.125f};
    memcpy(pfm, header, strlen(header));
    memcpy(pfm + strlen(header), texel, sizeof texel);
    import_serve(self, "scenes/t.pfm", pfm, strlen(header) + sizeof texel);
    mitsuba_loads(self, "3.0.0",
                  CUBE("<bsdf type='diffuse'><texture name='reflectance' type='bitmap'>"
                       "<string name='filename' value='t.pfm'/>"
                       "<string name='filter_type' value='nearest'/>"
                       "<string name='wrap_mode' value='mirror'/></texture></bsdf>")
                      CUBE("<bsdf type='mask'><texture name='opacity' type='bitmap'>"
                           "<string name='filename' value='t.pfm'/>"
                           "<string name='channel' value='b'/></texture><bsdf type='diffuse'/>"
                           "</bsdf>"));
    const air_texture_record *color =
        (const air_texture_record *)mitsuba_record(self, AIR_OBJECT_TEXTURE, 0);
    const air_texture_record *opacity =
        (const air_texture_record *)mitsuba_record(self, AIR_OBJECT_TEXTURE, 1);
    assert_int_equal(color->texture.filter, AIR_TEXTURE_NEAREST);
    assert_int_equal(color->texture.wrap_u, AIR_WRAP_MIRROR);
    assert_true(air_texture_rgb(&color->texture, 0.5f, 0.5f).y == 0.25f);
    assert_true(air_texture_rgb(&opacity->texture, 0.5f, 0.5f).x == 0.125f);
    assert_true(mitsuba_material(self, 1)->opacity_texture.texture != AIR_NONE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(diffuse_surfaces_are_lambertian, set_up, tear_down),
        cmocka_unit_test_setup_teardown(surfaces_have_a_side, set_up, tear_down),
        cmocka_unit_test_setup_teardown(interfaces_have_their_indices, set_up, tear_down),
        cmocka_unit_test_setup_teardown(metals_have_their_defaults, set_up, tear_down),
        cmocka_unit_test_setup_teardown(surfaces_around_others_add_to_them, set_up, tear_down),
        cmocka_unit_test_setup_teardown(blends_have_two_parts, set_up, tear_down),
        cmocka_unit_test_setup_teardown(lamps_are_black_where_nothing_is_said, set_up, tear_down),
        cmocka_unit_test_setup_teardown(null_surfaces_are_no_meshes, set_up, tear_down),
        cmocka_unit_test_setup_teardown(materials_are_shared, set_up, tear_down),
        cmocka_unit_test_setup_teardown(unsupported_surfaces_say_so, set_up, tear_down),
        cmocka_unit_test_setup_teardown(textures_where_none_can_be_say_so, set_up, tear_down),
        cmocka_unit_test_setup_teardown(checkerboards_are_exact, set_up, tear_down),
        cmocka_unit_test_setup_teardown(old_textures_have_scale_and_offset, set_up, tear_down),
        cmocka_unit_test_setup_teardown(bitmaps_are_sampled_as_they_say, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
