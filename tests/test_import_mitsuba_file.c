/* What scene files may be made of: parameters, includes, references; and what they may not. */
#include "mitsuba_fixture.h"

#define POINT(intensity)                                                                           \
    "<emitter type='point' id='lamp'><float name='intensity' value='" intensity "'/></emitter>"

static void parameters_are_put_in(void **state)
{
    import_fixture *self = *state;
    const char *defines[] = {"power=7"};
    const char *scene = "<default name='pow' value='2'/><default name='power' value='3'/>"
                        "<default name='kind' value='point'/>"
                        "<emitter type='$kind'><rgb name='intensity' value='$pow ${power}, "
                        "1$pow'/></emitter>";
    mitsuba_loads(self, "3.0.0", scene);
    assert_floats(mitsuba_light(self, 0)->color, 3, (const float[]){2.0f, 3.0f, 12.0f});
    self->params.defines = defines;
    self->params.define_count = 1;
    mitsuba_loads(self, "3.0.0", scene);
    assert_floats(mitsuba_light(self, 0)->color, 3, (const float[]){2.0f, 7.0f, 12.0f});
    defines[0] = "power";
    assert_int_equal(mitsuba_inside(self, "3.0.0", scene), AIR_ERROR_ARGUMENT);
    assert_string_equal(air_context_last_error(self->context),
                        "--define \"power\": expected NAME=VALUE");
}

static void unset_parameters_are_refused(void **state)
{
    mitsuba_refuses(*state, "3.0.0", POINT("$watts"),
                    "line 2: <float name=\"intensity\">: the parameter $watts has no value: "
                    "expected a <default> before it, or --define watts=VALUE");
}

static void a_backslash_keeps_the_dollar(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "3.0.0", "<emitter type='point' id='\\$5'/>");
    assert_string_equal(mitsuba_light(self, 0)->name, "$5");
}

static void includes_stand_where_they_are(void **state)
{
    import_fixture *self = *state;
    const char *lamp = "<scene version='0.6.0'><emitter type='point' id='a'><float "
                       "name='intensity' value='$w'/></emitter></scene>";
    const char *bare = "<emitter version='3.0' type='point' id='b'/>";
    import_serve(self, "scenes/parts/lamp.xml", lamp, strlen(lamp));
    import_serve(self, "scenes/bare.xml", bare, strlen(bare));
    mitsuba_loads(self, "3.0.0",
                  "<default name='w' value='5'/><include filename='parts/lamp.xml'/>"
                  "<include filename='bare.xml'/><emitter type='point' id='c'/>");
    assert_int_equal(mitsuba_count(self, AIR_OBJECT_LIGHT), 3);
    assert_string_equal(mitsuba_light(self, 0)->name, "a");
    assert_string_equal(mitsuba_light(self, 1)->name, "b");
    assert_string_equal(mitsuba_light(self, 2)->name, "c");
    assert_true(mitsuba_light(self, 0)->color[0] == 5.0f);
}

static void includes_in_circles_are_refused(void **state)
{
    import_fixture *self = *state;
    const char *other = "<scene version='3.0'><include filename='room.xml'/></scene>";
    import_serve(self, "scenes/other.xml", other, strlen(other));
    assert_int_equal(mitsuba_inside(self, "3.0.0", "<include filename='other.xml'/>"),
                     AIR_ERROR_FORMAT);
    assert_string_equal(air_context_last_error(self->context),
                        "scenes/other.xml: line 1: <include>: \"room.xml\" includes itself, by way "
                        "of this");
}

static void files_stay_in_the_folder(void **state)
{
    import_fixture *self = *state;
    mitsuba_refuses(self, "3.0.0", "<include filename='../secret.xml'/>",
                    "line 2: <include>: \"../secret.xml\" lies outside the scene's folder, "
                    "expected a path within it, or --files-anywhere");
    assert_int_equal(mitsuba_inside(self, "3.0.0", "<include filename='/etc/hostname'/>"),
                     AIR_ERROR_UNSUPPORTED);
    assert_int_equal(mitsuba_inside(self, "3.0.0", "<include filename='a/../../b.xml'/>"),
                     AIR_ERROR_UNSUPPORTED);
    self->params.files_anywhere = true;
    assert_int_equal(mitsuba_inside(self, "3.0.0", "<include filename='../secret.xml'/>"),
                     AIR_ERROR_IO);
}

/* A hundred lines that would be ten to the ninth. */
static void document_types_are_refused(void **state)
{
    import_fixture *self = *state;
    assert_int_equal(mitsuba_text(self,
                                  "<?xml version='1.0'?>\n<!DOCTYPE lolz [<!ENTITY a 'ha'>"
                                  "<!ENTITY b '&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;'>]>\n"
                                  "<scene version='3.0'><string name='x' value='&b;'/></scene>"),
                     AIR_ERROR_UNSUPPORTED);
    assert_string_equal(air_context_last_error(self->context),
                        "scenes/room.xml: line 2: <!DOCTYPE lolz>: document types and entities "
                        "are not read, expected <scene>");
}

static void deep_nesting_is_refused(void **state)
{
    import_fixture *self = *state;
    char text[4096] = "<scene version='3.0'>";
    for (int i = 0; i < 64; ++i)
        strcat(text, "<bsdf type='twosided'>");
    assert_int_equal(mitsuba_text(self, text), AIR_ERROR_UNSUPPORTED);
    assert_string_equal(air_context_last_error(self->context),
                        "scenes/room.xml: line 1: <bsdf>: elements are nested more than 64 deep");
}

static void broken_xml_names_the_line(void **state)
{
    import_fixture *self = *state;
    assert_int_equal(mitsuba_text(self, "<scene version='3.0'>\n<shape></scene>"),
                     AIR_ERROR_FORMAT);
    assert_string_equal(air_context_last_error(self->context),
                        "scenes/room.xml: line 2: not well-formed XML: mismatched tag");
}

static void versions_are_checked(void **state)
{
    import_fixture *self = *state;
    assert_int_equal(mitsuba_text(self, "<scene/>"), AIR_ERROR_FORMAT);
    assert_int_equal(mitsuba_text(self, "<scene version='0.1.0'/>"), AIR_ERROR_UNSUPPORTED);
    assert_int_equal(mitsuba_text(self, "<scene version='five'/>"), AIR_ERROR_UNSUPPORTED);
    assert_int_equal(mitsuba_text(self, "<scene version='0.4.0'/>"), AIR_OK);
    assert_int_equal(mitsuba_text(self, "<scene version='3.5.2'/>"), AIR_OK);
    assert_int_equal(mitsuba_text(self, "<shape version='3.5.2' type='cube'/>"), AIR_ERROR_FORMAT);
}

static void references_reach_both_ways(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "0.6.0",
                  "<shape type='cube'><ref id='also'/></shape>"
                  "<alias id='later' as='also'/>"
                  "<bsdf type='diffuse' id='later'><rgb name='reflectance' value='.1 .2 .3'/>"
                  "</bsdf>");
    assert_floats(mitsuba_material(self, 0)->base_color, 3, (const float[]){0.1f, 0.2f, 0.3f});
    mitsuba_refuses(self, "3.0.0",
                    "<bsdf type='diffuse' id='white'/><shape type='cube'><ref id='whyte'/></shape>",
                    "line 2: <ref id=\"whyte\">: nothing has the id \"whyte\"; did you mean "
                    "\"white\"?");
    mitsuba_refuses(self, "3.0.0", "<bsdf type='diffuse' id='a'/>\n<bsdf type='null' id='a'/>",
                    "line 3: <bsdf type=\"null\" id=\"a\">: the id \"a\" is taken by the <bsdf> of "
                    "line 2");
}

static void references_in_circles_are_refused(void **state)
{
    mitsuba_refuses(*state, "3.0.0",
                    "<bsdf type='twosided' id='a'><ref id='a'/></bsdf>"
                    "<shape type='cube'><ref id='a'/></shape>",
                    "line 2: <bsdf type=\"twosided\" id=\"a\">: it refers to itself, or elements "
                    "are nested too deep");
}

static void names_of_old_and_new_are_the_same(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "3.0.0",
                  "<emitter type='spot'><float name='cutoffAngle' value='30'/>"
                  "<transform name='toWorld'><lookAt origin='0 0 0' target='1 0 0'/></transform>"
                  "</emitter>"
                  "<emitter type='spot'><float name='cutoff_angle' value='30'/>"
                  "<transform name='to_world'><lookat origin='0 0 0' target='1 0 0'/></transform>"
                  "</emitter>");
    assert_true(mitsuba_light(self, 0)->outer_cone_rad == mitsuba_light(self, 1)->outer_cone_rad);
    assert_memory_equal(mitsuba_light(self, 0)->dir, mitsuba_light(self, 1)->dir,
                        3 * sizeof(float));
    import_expect_silence(self, AIR_MESSAGE_WARNING);
}

static void what_is_not_read_is_said(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "3.0.0",
                  "<emitter type='point'>\n<float name='intenzity' value='1'/></emitter>");
    assert_string_equal(self->said[AIR_MESSAGE_WARNING],
                        "scenes/room.xml: line 3: <float name=\"intenzity\">: nothing is done with "
                        "it\n");
}

static void unknown_plugins_are_refused_or_replaced(void **state)
{
    import_fixture *self = *state;
    const char *scene = "<shape type='cubus'/>";
    mitsuba_refuses(self, "3.0.0", scene,
                    "line 2: <shape type=\"cubus\">: the shape \"cubus\" is not supported, did you "
                    "mean \"cube\"? (--lenient: it is left out)");
    self->params.lenient = true;
    mitsuba_loads(self, "3.0.0", scene);
    import_expect(self, AIR_MESSAGE_WARNING, "it is left out");
    assert_int_equal(mitsuba_count(self, AIR_OBJECT_MESH), 0);
}

static void wrong_values_are_refused(void **state)
{
    import_fixture *self = *state;
    mitsuba_refuses(self, "3.0.0", POINT("bright"),
                    "line 2: <float name=\"intensity\">: expected one finite number as "
                    "value, found \"bright\"");
    mitsuba_refuses(self, "3.0.0", "<shape type='sphere'><string name='radius' value='1'/></shape>",
                    "line 2: <string name=\"radius\">: expected <float> or <integer>");
    mitsuba_refuses(self, "3.0.0",
                    "<shape type='cube'><boolean name='flip_normals' value='maybe'/></shape>",
                    "line 2: <boolean name=\"flip_normals\">: expected one of false, true, found "
                    "\"maybe\"");
}

static void files_that_fail_say_who_names_them(void **state)
{
    import_fixture *self = *state;
    import_serve(self, "scenes/empty.obj", "", 0);
    mitsuba_refuses(self, "3.0.0",
                    "<shape type='obj'><string name='filename' value='none.obj'/></shape>",
                    "line 2: <shape type=\"obj\">: scenes/none.obj: cannot be read");
    mitsuba_refuses(
        self, "3.0.0", "<shape type='obj'><string name='filename' value='empty.obj'/></shape>",
        "line 2: <shape type=\"obj\">: scenes/empty.obj: expected at least one face (f)");
    mitsuba_refuses(self, "3.0.0",
                    "<shape type='cube'><bsdf type='diffuse'><texture type='bitmap' "
                    "name='reflectance'>\n<string name='filename' value='no.png'/></texture></bsdf>"
                    "</shape>",
                    "line 2: <texture type=\"bitmap\" name=\"reflectance\">: scenes/no.png: cannot "
                    "be read");
    mitsuba_refuses(self, "3.0.0",
                    "<emitter type='envmap'><string name='filename' value='no.exr'/></emitter>",
                    "line 2: <emitter type=\"envmap\">: scenes/no.exr: cannot be read");
    mitsuba_refuses(self, "3.0.0", "\n<include filename='no.xml'/>",
                    "line 3: <include>: scenes/no.xml: cannot be read");
}

static void elements_need_their_attributes(void **state)
{
    import_fixture *self = *state;
    mitsuba_refuses(self, "3.0.0", "<shape type='obj'><string name='filename' value=''/></shape>",
                    "line 2: <shape type=\"obj\">: expected the name of a file");
    mitsuba_refuses(self, "3.0.0", "<shape/>", "line 2: <shape>: expected the attribute type");
    assert_int_equal(mitsuba_text(self, "<svg/>"), AIR_ERROR_FORMAT);
    assert_string_equal(air_context_last_error(self->context),
                        "scenes/room.xml: line 1: <svg>: expected the attribute version, as in "
                        "<scene version=\"3.0.0\">");
}

static void parameters_that_nothing_asks_for_are_told(void **state)
{
    import_fixture *self = *state;
    const char *const defines[] = {"w=2", "v=3"};
    self->params.defines = defines;
    self->params.define_count = 2;
    mitsuba_loads(self, "3.0.0", POINT("$w"));
    assert_string_equal(self->said[AIR_MESSAGE_WARNING], "--define \"v=3\": the scene has no $v\n");
}

/* Whatever allocation fails, the load fails cleanly or the scene is the same. */
static void memory_may_run_out_anywhere(void **state)
{
    import_fixture *self = *state;
    const char *scene =
        "<default name='p' value='2'/><bsdf type='mask' id='m'><bsdf type='diffuse'>"
        "<texture name='reflectance' type='checkerboard'/></bsdf></bsdf>"
        "<medium type='homogeneous' id='fog'><spectrum name='sigma_t' value='400:1, 700:$p'/>"
        "</medium>"
        "<shape type='cube' id='box'><ref id='m'/><ref name='interior' id='fog'/></shape>"
        "<sensor type='perspective'/>";
    size_t failures = 0;
    for (int allowed = 0; allowed < 400; ++allowed) {
        import_reset(self);
        atomic_store(&self->allocator.remaining, allowed);
        const air_status status = mitsuba_inside(self, "3.0.0", scene);
        atomic_store(&self->allocator.remaining, FIXTURE_MANY);
        if (status == AIR_OK)
            break;
        assert_int_equal(status, AIR_ERROR_MEMORY);
        ++failures;
    }
    assert_non_null(self->scene);
    assert_true(failures > 10);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(parameters_are_put_in, set_up, tear_down),
        cmocka_unit_test_setup_teardown(unset_parameters_are_refused, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_backslash_keeps_the_dollar, set_up, tear_down),
        cmocka_unit_test_setup_teardown(includes_stand_where_they_are, set_up, tear_down),
        cmocka_unit_test_setup_teardown(includes_in_circles_are_refused, set_up, tear_down),
        cmocka_unit_test_setup_teardown(files_stay_in_the_folder, set_up, tear_down),
        cmocka_unit_test_setup_teardown(document_types_are_refused, set_up, tear_down),
        cmocka_unit_test_setup_teardown(deep_nesting_is_refused, set_up, tear_down),
        cmocka_unit_test_setup_teardown(broken_xml_names_the_line, set_up, tear_down),
        cmocka_unit_test_setup_teardown(versions_are_checked, set_up, tear_down),
        cmocka_unit_test_setup_teardown(references_reach_both_ways, set_up, tear_down),
        cmocka_unit_test_setup_teardown(references_in_circles_are_refused, set_up, tear_down),
        cmocka_unit_test_setup_teardown(names_of_old_and_new_are_the_same, set_up, tear_down),
        cmocka_unit_test_setup_teardown(what_is_not_read_is_said, set_up, tear_down),
        cmocka_unit_test_setup_teardown(unknown_plugins_are_refused_or_replaced, set_up, tear_down),
        cmocka_unit_test_setup_teardown(wrong_values_are_refused, set_up, tear_down),
        cmocka_unit_test_setup_teardown(files_that_fail_say_who_names_them, set_up, tear_down),
        cmocka_unit_test_setup_teardown(elements_need_their_attributes, set_up, tear_down),
        cmocka_unit_test_setup_teardown(parameters_that_nothing_asks_for_are_told, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(memory_may_run_out_anywhere, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
