/* Materials and textures: defaults, extensions, units, sharing. */
#include <math.h>

#include "import_fixture.h"

#define PNG                                                                                        \
    "data:image/png;base64,"                                                                       \
    "iVBORw0KGgoAAAANSUhEUgAAAAIAAAABCAIAAAB7QOjdAAAAD0lEQVR42mP4z8DA0PAfAAgAAn8lPvwJAAAAAElFTkSu" \
    "QmCC"

#define PAINTED(material)                                                                          \
    "{" GLTF_SCENE ",'nodes':[{'mesh':0}],'materials':[{" material "}]," GLTF_PAINTED_TRIANGLE "}"
#define TEXTURED(material, rest)                                                                   \
    "{" GLTF_SCENE ",'nodes':[{'mesh':0}],'materials':[{" material "}],'images':[{'uri':'" PNG     \
    "'}]," rest "," GLTF_PAINTED_TRIANGLE "}"

/* The one material of the file; the snapshot's first is the default one. */
static const air_material *material_of(const import_fixture *f)
{
    assert_int_equal(f->snapshot->mesh_count, 1);
    return &f->snapshot->materials[f->snapshot->meshes[0]->material];
}

/* Relative, two roundings of single precision. */
static void expect_near(float value, double expected)
{
    if (fabs((double)value - expected) > 2.5e-7 * fabs(expected) + 1e-12)
        fail_msg("%.9g is not %.9g", (double)value, expected);
}

static void the_defaults_are_those_of_gltf(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    import_loads(&f, PAINTED(""));
    const air_material *m = material_of(&f);
    assert_true(m->base_color.x == 1.0f && m->base_color.y == 1.0f && m->base_color.z == 1.0f &&
                m->alpha == 1.0f);
    assert_true(m->metallic == 1.0f && m->roughness == 1.0f);
    assert_true(vec3_is_zero(m->emission));
    assert_int_equal(m->alpha_mode, AIR_ALPHA_OPAQUE);
    assert_true(m->alpha_cutoff == 0.5f && m->ior == 1.5f && m->specular == 1.0f);
    assert_false(m->double_sided || m->unlit || m->textured);
    import_finish(&f);
}

static void factors_are_taken_as_they_are(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    import_loads(
        &f,
        PAINTED("'name':'glass','pbrMetallicRoughness':{'baseColorFactor':[0.25,0.5,0.75,0.125],"
                "'metallicFactor':0.5,'roughnessFactor':0.25},'alphaMode':'MASK','alphaCutoff':0."
                "75,'doubleSided':true,"
                "'extensions':{'KHR_materials_ior':{'ior':2.0},'KHR_materials_specular':{'"
                "specularFactor':0.5},"
                "'KHR_materials_unlit':{}}"));
    const air_material *m = material_of(&f);
    assert_string_equal(m->name, "glass");
    assert_true(m->base_color.x == 0.25f && m->base_color.y == 0.5f && m->base_color.z == 0.75f &&
                m->alpha == 0.125f);
    assert_true(m->metallic == 0.5f && m->roughness == 0.25f && m->ior == 2.0f &&
                m->specular == 0.5f);
    assert_int_equal(m->alpha_mode, AIR_ALPHA_MASK);
    assert_true(m->alpha_cutoff == 0.75f && m->double_sided && m->unlit);
    import_expect_silence(&f, AIR_MESSAGE_WARNING);
    import_finish(&f);
}

static void numbers_out_of_range_are_refused_with_their_place(void **state)
{
    (void)state;
    static const struct {
        const char *material, *message;
    } cases[] = {
        {"'alphaCutoff':'abc'", "alphaCutoff: expected a number >= 0, found \"abc\""},
        {"'alphaMode':'CUT'", "alphaMode: expected one of OPAQUE, MASK, BLEND, found \"CUT\""},
        {"'doubleSided':1", "doubleSided: expected true or false, found 1"},
        {"'pbrMetallicRoughness':{'metallicFactor':1.5}",
         "pbrMetallicRoughness.metallicFactor: expected a number in [0, 1], found 1.5"},
        {"'pbrMetallicRoughness':{'baseColorFactor':[1,1,1]}",
         "pbrMetallicRoughness.baseColorFactor: expected an array of 4 numbers, found an array of "
         "3"},
        {"'emissiveFactor':[0,-1,0]", "emissiveFactor[1]: expected a number >= 0, found -1"},
        {"'extensions':{'KHR_materials_ior':{'ior':0.5}}",
         "extensions.KHR_materials_ior.ior: expected a number >= 1, found 0.5"},
        {"'normalTexture':{}",
         "normalTexture.index: expected the index of a texture, found nothing"},
        {"'normalTexture':{'index':0}",
         "normalTexture.index: expected the index of a texture, of which there are 0, found 0"},
    };
    import_fixture f;
    import_init(&f);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char line[512];
        assert_int_equal(import_format(&f, PAINTED("%s"), cases[i].material), AIR_ERROR_FORMAT);
        snprintf(line, sizeof line, "room.gltf: $.materials[0].%s\n", cases[i].message);
        assert_string_equal(f.said[AIR_MESSAGE_ERROR], line);
    }
    import_finish(&f);
}

/* ---- emission ---- */

#define LAMP(generator)                                                                            \
    "{'asset':{'version':'2.0','generator':'" generator "'},'nodes':[{'mesh':0}],'materials':[{"   \
    "'emissiveFactor':[1,0.5,0.25],'extensions':{'KHR_materials_emissive_strength':{'"             \
    "emissiveStrength':683}}}]," GLTF_PAINTED_TRIANGLE "}"

static void expect_emission(import_fixture *f, const char *text, double strength, air_units units)
{
    import_loads(f, text);
    const air_vec3 e = material_of(f)->emission;
    expect_near(e.x, strength);
    expect_near(e.y, 0.5 * strength);
    expect_near(e.z, 0.25 * strength);
    assert_int_equal(f->snapshot->emissive_units, units);
}

static void emission_is_photometric_unless_blender_wrote_it_or_the_caller_says_so(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    expect_emission(&f, LAMP("hand"), 1.0, AIR_UNITS_PHOTOMETRIC);
    expect_emission(&f, LAMP("Blender by hand"), 1.0, AIR_UNITS_PHOTOMETRIC);
    expect_emission(&f, LAMP("Khronos glTF Blender I/O v4.0.44"), 683.0, AIR_UNITS_RADIOMETRIC);
    expect_emission(&f, LAMP("Khronos Blender glTF 2.0 exporter"), 683.0, AIR_UNITS_RADIOMETRIC);
    f.params.emissive_units = AIR_UNITS_PHOTOMETRIC;
    expect_emission(&f, LAMP("Khronos glTF Blender I/O v4.0.44"), 1.0, AIR_UNITS_PHOTOMETRIC);
    f.params.emissive_units = AIR_UNITS_RADIOMETRIC;
    expect_emission(&f, LAMP("hand"), 683.0, AIR_UNITS_RADIOMETRIC);
    import_finish(&f);
}

static void an_emissive_factor_above_1_is_taken_with_a_warning(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    f.params.emissive_units = AIR_UNITS_RADIOMETRIC;
    import_loads(&f, PAINTED("'emissiveFactor':[10,0,0]"));
    assert_true(material_of(&f)->emission.x == 10.0f);
    import_expect(&f, AIR_MESSAGE_WARNING,
                  "materials with an emissiveFactor above 1, taken as it is: 1");
    import_finish(&f);
}

/* ---- specular and glossiness ---- */

static void specular_glossiness_becomes_metal_and_roughness(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
#define GLOSSY(factors)                                                                            \
    PAINTED("'extensions':{'KHR_materials_pbrSpecularGlossiness':{" factors "}}")
    /* a dielectric of reflectance 0.04 is one, with the diffuse colour as its base: 0.96 of it is
     * what is left */
    import_loads(&f, GLOSSY("'diffuseFactor':[0.5,0.25,0.125,0.5],'specularFactor':[0.04,0.04,0.04]"
                            ",'glossinessFactor':0.75"));
    const air_material *m = material_of(&f);
    assert_true(fabsf(m->metallic) < 1e-5f);
    assert_true(fabsf(m->base_color.x - 0.5f) < 1e-5f && fabsf(m->base_color.z - 0.125f) < 1e-5f);
    assert_true(m->roughness == 0.25f && m->alpha == 0.5f);
    /* no diffuse part and a coloured reflectance: a metal of that colour */
    import_loads(&f, GLOSSY("'diffuseFactor':[0,0,0,1],'specularFactor':[1,0.75,0.5]"));
    m = material_of(&f);
    assert_true(fabsf(m->metallic - 1.0f) < 1e-5f && m->roughness == 0.0f);
    assert_true(fabsf(m->base_color.y - 0.75f) < 1e-5f && fabsf(m->base_color.z - 0.5f) < 1e-5f);
    import_expect_silence(&f, AIR_MESSAGE_WARNING);
    import_finish(&f);
}

static void a_tinted_reflectance_is_announced_as_left_out(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    import_loads(
        &f, PAINTED("'extensions':{'KHR_materials_specular':{'specularColorFactor':[1,0,0]}}"));
    import_expect(&f, AIR_MESSAGE_WARNING,
                  "materials whose reflectance is tinted or textured, taken without: 1");
    import_finish(&f);
}

/* ---- textures ---- */

static void a_texture_has_its_sampler_colour_space_and_coordinates(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    import_loads(
        &f,
        TEXTURED("'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'texCoord':1},"
                 "'metallicRoughnessTexture':{'index':1}},'normalTexture':{'index':1,'scale':0.5}",
                 "'textures':[{'source':0,'sampler':0},{'source':0}],"
                 "'samplers':[{'wrapS':33071,'wrapT':33648,'magFilter':9728}]"));
    const air_material *m = material_of(&f);
    const air_texture *color = m->base_color_slot.texture,
                      *other = m->metallic_roughness_slot.texture;
    assert_non_null(color);
    assert_non_null(other);
    assert_int_equal(color->width, 2);
    assert_int_equal(color->height, 1);
    assert_true(color->srgb && !other->srgb);
    assert_int_equal(color->wrap_u, AIR_WRAP_CLAMP);
    assert_int_equal(color->wrap_v, AIR_WRAP_MIRROR);
    assert_int_equal(color->filter, AIR_TEXTURE_NEAREST);
    assert_int_equal(other->wrap_u, AIR_WRAP_REPEAT);
    assert_int_equal(other->filter, AIR_TEXTURE_LINEAR);
    assert_int_equal(m->base_color_slot.uv_set, 1);
    assert_int_equal(m->metallic_roughness_slot.uv_set, 0);
    assert_true(m->normal_scale == 0.5f);
    /* the same image, sampler and colour space: one texture */
    assert_ptr_equal(other, m->normal_slot.texture);
    assert_int_equal(f.snapshot->texture_count, 2);
    const uint8_t *bytes = color->bytes;
    assert_int_equal(bytes[0], 255);
    assert_int_equal(bytes[color->channels + 1], 128);
    import_finish(&f);
}

static void a_texture_transform_moves_turns_and_scales(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    /* the example of the extension: the lower left quadrant, turned clockwise by a right angle */
    import_loads(
        &f,
        TEXTURED("'normalTexture':{'index':0,'texCoord':0,'extensions':{'KHR_texture_transform':{"
                 "'offset':[0,1],'rotation':1.5707963267948966,'scale':[0.5,0.5],'texCoord':1}}}",
                 "'textures':[{'source':0}]"));
    const air_texture_slot *slot = &material_of(&f)->normal_slot;
    assert_int_equal(slot->uv_set, 1);
    const float corners[4][2] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
    const float expected[4][2] = {{0, 1}, {0, 0.5f}, {0.5f, 1}, {0.5f, 0.5f}};
    for (size_t i = 0; i < 4; ++i) {
        const float *m = slot->uv_transform, u = corners[i][0], v = corners[i][1];
        assert_true(fabsf(m[0] * u + m[1] * v + m[2] - expected[i][0]) <
                    1e-6f); /* cos(pi/2) in floats */
        assert_true(fabsf(m[3] * u + m[4] * v + m[5] - expected[i][1]) < 1e-6f);
    }
    import_finish(&f);
}

static void textures_that_cannot_be_shown_are_left_out_with_a_warning(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    import_loads(
        &f,
        TEXTURED("'normalTexture':{'index':0,'texCoord':2},'pbrMetallicRoughness':{'"
                 "baseColorTexture':{'index':1}}",
                 "'textures':[{'source':0},{'extensions':{'KHR_texture_basisu':{'source':0}}}]"));
    assert_false(material_of(&f)->textured);
    import_expect(&f, AIR_MESSAGE_WARNING,
                  "textures with a coordinate set above TEXCOORD_1 left out: 1");
    import_expect(&f, AIR_MESSAGE_WARNING, "textures without a PNG or JPEG source left out: 1");
    import_finish(&f);
}

static void a_picture_that_is_none_is_refused_by_name(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
#define FROM(image)                                                                                \
    "{" GLTF_SCENE                                                                                 \
    ",'nodes':[{'mesh':0}],'materials':[{'normalTexture':{'index':0}}],'textures':[{'source':0}]," \
    "'images':[{" image "}]," GLTF_PAINTED_TRIANGLE "}"
    assert_int_equal(import_text(&f, FROM("'uri':'data:image/png;base64,AAAA'")), AIR_ERROR_FORMAT);
    import_expect(&f, AIR_MESSAGE_ERROR, "room.gltf: $.images[0].uri");
    assert_int_equal(import_text(&f, FROM("'bufferView':0")), AIR_ERROR_FORMAT);
    import_expect(&f, AIR_MESSAGE_ERROR, "room.gltf: $.images[0]");
    assert_int_equal(import_text(&f, FROM("'uri':'wood.png'")), AIR_ERROR_IO);
    import_expect(&f, AIR_MESSAGE_ERROR, "wood.png");
    assert_int_equal(import_text(&f, FROM("")), AIR_ERROR_FORMAT);
    import_expect(&f, AIR_MESSAGE_ERROR,
                  "room.gltf: $.images[0].uri: expected a URI, found nothing");
    import_finish(&f);
}

static void a_material_that_no_mesh_uses_is_not_read(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    import_loads(
        &f, "{" GLTF_SCENE ",'nodes':[{'mesh':0}],'materials':[{},{'normalTexture':{'index':0}}],"
            "'textures':[{'source':0}],'images':[{'uri':'gone.png'}]," GLTF_PAINTED_TRIANGLE "}");
    assert_int_equal(f.snapshot->material_count, 2);
    import_finish(&f);
}

/* ---- glass ---- */

#define GLASS(volume)                                                                              \
    "'materials':[{'extensions':{'KHR_materials_transmission':{'transmissionFactor':0.75},"        \
    "'KHR_materials_ior':{'ior':1.25}" volume "}}]"
#define ABSORBING                                                                                  \
    ",'KHR_materials_volume':{'thicknessFactor':0.1,'attenuationDistance':0.5,"                    \
    "'attenuationColor':[1,0.5,0]}"

static void transmission_is_thin_without_a_volume(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    import_loads(&f,
                 "{" GLTF_SCENE ",'nodes':[{'mesh':0}]," GLASS("") "," GLTF_PAINTED_TRIANGLE "}");
    assert_true(material_of(&f)->transmission == 0.75f && material_of(&f)->ior == 1.25f);
    assert_true(material_of(&f)->thin_walled);
    import_expect_silence(&f, AIR_MESSAGE_WARNING);
    import_loads(
        &f, "{" GLTF_SCENE ",'nodes':[{'mesh':0}]," GLASS(
                ",'KHR_materials_volume':{'thicknessFactor':0.1}") "," GLTF_PAINTED_TRIANGLE "}");
    assert_false(material_of(&f)->thin_walled);
    assert_int_equal(f.snapshot->media.count, 0);
    import_expect_silence(&f, AIR_MESSAGE_WARNING);
    import_finish(&f);
}

static void closed_glass_absorbs_and_open_glass_is_announced(void **state)
{
    (void)state;
    static uint8_t cube[168];
    import_fixture f;
    import_init(&f);
    import_serve_cube(&f, cube);
    import_loads(&f, "{" GLTF_SCENE ",'nodes':[{'mesh':0}]," GLASS(ABSORBING) "," GLTF_CUBE_OF(
                         "'material':0") "}");
    assert_int_equal(f.snapshot->media.count, 1);
    const air_vec3 sigma_a = f.snapshot->media.media[0].sigma_t;
    expect_near(sigma_a.x, 0.0);
    expect_near(sigma_a.y, log(2.0) / 0.5);
    expect_near(sigma_a.z, log(1e6) / 0.5); /* black is let through by a millionth */
    import_expect_silence(&f, AIR_MESSAGE_WARNING);
    import_loads(&f, "{" GLTF_SCENE
                     ",'nodes':[{'mesh':0}]," GLASS(ABSORBING) "," GLTF_PAINTED_TRIANGLE "}");
    assert_int_equal(f.snapshot->media.count, 0);
    import_expect(&f, AIR_MESSAGE_WARNING,
                  "meshes that are not closed, whose glass is left without absorption: 1");
    import_finish(&f);
}

/* Spheres that stand for triangles absorb as these would; cylinders and disks are open. */
static void glass_of_exact_shapes_absorbs(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    import_loads(&f, "{" GLTF_SCENE
                     ",'nodes':[{'mesh':0,'translation':[0,3,0],'extras':{'airlight':{'shape':"
                     "'sphere'}}}]," GLASS(ABSORBING) "," GLTF_PAINTED_TRIANGLE "}");
    assert_int_equal(f.snapshot->media.count, 1);
    assert_int_equal(f.snapshot->media.media[0].boundary, AIR_BOUNDARY_ELLIPSOID);
    expect_near(f.snapshot->media.media[0].bounds_max[1], 4.0);
    import_expect_silence(&f, AIR_MESSAGE_WARNING);
    import_loads(&f, "{" GLTF_SCENE ",'nodes':[{'mesh':0,'extras':{'airlight':{'shape':"
                     "'disk'}}}]," GLASS(ABSORBING) "," GLTF_PAINTED_TRIANGLE "}");
    assert_int_equal(f.snapshot->media.count, 0);
    import_expect(&f, AIR_MESSAGE_WARNING, "not closed, whose glass is left without absorption: 1");
    import_finish(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_defaults_are_those_of_gltf),
        cmocka_unit_test(factors_are_taken_as_they_are),
        cmocka_unit_test(numbers_out_of_range_are_refused_with_their_place),
        cmocka_unit_test(emission_is_photometric_unless_blender_wrote_it_or_the_caller_says_so),
        cmocka_unit_test(an_emissive_factor_above_1_is_taken_with_a_warning),
        cmocka_unit_test(specular_glossiness_becomes_metal_and_roughness),
        cmocka_unit_test(a_tinted_reflectance_is_announced_as_left_out),
        cmocka_unit_test(a_texture_has_its_sampler_colour_space_and_coordinates),
        cmocka_unit_test(a_texture_transform_moves_turns_and_scales),
        cmocka_unit_test(textures_that_cannot_be_shown_are_left_out_with_a_warning),
        cmocka_unit_test(a_picture_that_is_none_is_refused_by_name),
        cmocka_unit_test(a_material_that_no_mesh_uses_is_not_read),
        cmocka_unit_test(transmission_is_thin_without_a_volume),
        cmocka_unit_test(closed_glass_absorbs_and_open_glass_is_announced),
        cmocka_unit_test(glass_of_exact_shapes_absorbs),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
