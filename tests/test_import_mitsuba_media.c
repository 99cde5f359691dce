/* Media of scene files: their numbers, where they are, and which one holds where several are. */
#include "mitsuba_fixture.h"
#include "scene/media/media.h"

#define FOG                                                                                        \
    "<medium type='homogeneous' id='fog'><rgb name='sigma_t' value='1 2 4'/>"                      \
    "<float name='albedo' value='.25'/><float name='scale' value='2'/></medium>"
#define SMOKE                                                                                      \
    "<medium type='homogeneous' id='smoke'><float name='sigma_s' value='3'/>"                      \
    "<float name='sigma_a' value='1'/></medium>"
#define SHELL(type, inside) "<shape type='" type "'><bsdf type='null'/>" inside "</shape>"

static void coefficients_come_both_ways(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "3.0.0",
                  FOG SMOKE SHELL("cube", "<ref name='interior' id='fog'/>")
                      SHELL("cube", "<ref name='interior' id='smoke'/><transform name='to_world'>"
                                    "<translate x='9'/></transform>"));
    assert_floats(mitsuba_medium(self, 0)->sigma_s, 3, (const float[]){.5f, 1, 2});
    assert_floats(mitsuba_medium(self, 0)->sigma_a, 3, (const float[]){1.5f, 3, 6});
    assert_floats(mitsuba_medium(self, 1)->sigma_s, 3, (const float[]){3, 3, 3});
    assert_floats(mitsuba_medium(self, 1)->sigma_a, 3, (const float[]){1, 1, 1});
    /* they do not meet, so that others may add to them */
    assert_int_equal(mitsuba_medium(self, 0)->combine, AIR_COMBINE_ADD);
    assert_int_equal(mitsuba_medium(self, 0)->boundary.kind, AIR_BOUNDARY_BOX);
}

static void presets_are_refused(void **state)
{
    mitsuba_refuses(*state, "0.6.0",
                    "<medium type='homogeneous' id='m'><string name='material' value='milk'/>"
                    "</medium>" SHELL("cube", "<ref name='interior' id='m'/>"),
                    "line 2: <medium type=\"homogeneous\" id=\"m\">: named materials of media are "
                    "not supported, expected sigma_s and sigma_a, or sigma_t and albedo");
}

static void phase_functions_are_read(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "3.0.0",
                  "<medium type='homogeneous' id='m'><phase type='blendphase'>"
                  "<float name='weight' value='.25'/><phase type='hg'><float name='g' value='.5'/>"
                  "</phase><phase type='rayleigh'/></phase></medium>" SHELL(
                      "cube", "<ref name='interior' id='m'/>"));
    const air_phase *phase = &mitsuba_medium(self, 0)->phase;
    assert_int_equal(phase->kind, AIR_PHASE_MIXTURE);
    assert_int_equal(phase->mixture->lobe_count, 2);
    assert_true(phase->mixture->lobes[0].kind == AIR_PHASE_HG &&
                phase->mixture->lobes[0].g == 0.5f && phase->mixture->lobes[0].weight == 0.75f);
    assert_true(phase->mixture->lobes[1].kind == AIR_PHASE_RAYLEIGH &&
                phase->mixture->lobes[1].weight == 0.25f);
    mitsuba_loads(self, "3.0.0",
                  "<medium type='homogeneous' id='m'><phase type='hg'/></medium>" SHELL(
                      "cube", "<ref name='interior' id='m'/>"));
    assert_true(mitsuba_medium(self, 0)->phase.kind == AIR_PHASE_HG &&
                mitsuba_medium(self, 0)->phase.g == 0.8f);
}

/* Which medium holds at a point: by the rule that medium.h states. */
static const char *medium_at(const import_fixture *self, const float point[3])
{
    const char *name = "none";
    int32_t most = INT32_MIN;
    for (size_t i = 0; i < mitsuba_count(self, AIR_OBJECT_MEDIUM); ++i) {
        const air_medium_desc *desc = mitsuba_medium(self, i);
        const float *m = desc->boundary.box_to_world;
        bool inside = true;
        float sum = 0.0f;
        for (size_t k = 0; k < 3; ++k) { /* boxes and spheres here are upright */
            const float x = (point[k] - m[4 * k + 3]) / m[5 * k];
            inside = inside && fabsf(x) <= 1.0f;
            sum += x * x;
        }
        if (desc->boundary.kind == AIR_BOUNDARY_ELLIPSOID)
            inside = sum <= 1.0f;
        if (desc->boundary.kind == AIR_BOUNDARY_UNBOUNDED)
            inside = true;
        if (inside && desc->priority >= most) {
            most = desc->priority;
            name = desc->name;
        }
    }
    return name;
}

/* A ball of smoke in a box of fog in haze, whatever their order. */
static void the_inner_medium_holds(void **state)
{
    import_fixture *self = *state;
    const char *ball = "<shape type='sphere' id='ball'><bsdf type='null'/>"
                       "<ref name='interior' id='smoke'/><ref name='exterior' id='fog'/></shape>";
    const char *box = "<shape type='cube' id='box'><transform name='to_world'><scale value='2'/>"
                      "</transform><bsdf type='null'/><ref name='interior' id='fog'/>"
                      "<ref name='exterior' id='haze'/></shape>";
    for (int order = 0; order < 2; ++order) {
        char inside[2048];
        snprintf(inside, sizeof inside,
                 FOG SMOKE "<medium type='homogeneous' id='haze'/>%s%s"
                           "<sensor type='perspective'><ref id='haze'/></sensor>",
                 order == 0 ? ball : box, order == 0 ? box : ball);
        mitsuba_loads(self, "3.0.0", inside);
        assert_int_equal(mitsuba_count(self, AIR_OBJECT_MEDIUM), 3);
        assert_string_equal(medium_at(self, (const float[]){0, 0.5f, 0}), "smoke");
        assert_string_equal(medium_at(self, (const float[]){0, 1.5f, 0}), "fog");
        assert_string_equal(medium_at(self, (const float[]){0.9f, 0.9f, 0.9f}), "fog");
        assert_string_equal(medium_at(self, (const float[]){0, 3, 0}), "haze");
    }
}

/* The fog that a camera stands in is not everywhere if it is that of a box around the camera. */
static void a_sensor_inside_is_inside(void **state)
{
    import_fixture *self = *state;
    const char *scene = FOG SHELL(
        "cube", "<ref name='interior' id='fog'/>") "<sensor type='perspective'><transform "
                                                   "name='to_world'><translate z='%d'/></transform>"
                                                   "<ref id='fog'/></sensor>";
    char inside[2048];
    snprintf(inside, sizeof inside, scene, 0);
    mitsuba_loads(self, "3.0.0", inside);
    assert_int_equal(mitsuba_count(self, AIR_OBJECT_MEDIUM), 1);
    snprintf(inside, sizeof inside, scene, 5);
    mitsuba_loads(self, "3.0.0", inside);
    assert_int_equal(mitsuba_count(self, AIR_OBJECT_MEDIUM), 2);
}

/* Glass that has fog outside and nothing inside keeps it out; opaque things need not. */
static void clear_shapes_keep_fog_out(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "3.0.0",
                  FOG "<shape type='sphere' id='glass'><bsdf type='dielectric'/>"
                      "<ref name='exterior' id='fog'/></shape>"
                      "<shape type='cube'><bsdf type='diffuse'/><ref name='exterior' id='fog'/>"
                      "</shape>");
    assert_int_equal(mitsuba_count(self, AIR_OBJECT_MEDIUM), 2);
    assert_string_equal(medium_at(self, (const float[]){0, 0, 0}), "glass");
    assert_string_equal(medium_at(self, (const float[]){0, 2, 0}), "fog");
    for (size_t i = 0; i < 2; ++i)
        if (strcmp(mitsuba_medium(self, i)->name, "glass") == 0)
            assert_true(mitsuba_medium(self, i)->sigma_s[0] == 0.0f);
}

static const char tetrahedron[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n";

/* The fourth face is missing, and then there. */
static void open_shapes_bound_nothing(void **state)
{
    import_fixture *self = *state;
    char closed[256];
    const char *scene = FOG "<shape type='obj'><string name='filename' value='t.obj'/>"
                            "<bsdf type='null'/><ref name='interior' id='fog'/></shape>";
    import_serve(self, "scenes/t.obj", tetrahedron, sizeof tetrahedron - 1);
    mitsuba_refuses(self, "3.0.0", scene,
                    "line 2: <shape type=\"obj\">: the shape is not closed, so that it bounds no "
                    "medium (--lenient: the medium within is left out)");
    self->params.lenient = true;
    mitsuba_loads(self, "3.0.0", scene);
    assert_int_equal(mitsuba_count(self, AIR_OBJECT_MEDIUM), 0);
    self->params.lenient = false;
    static const char *const last[] = {"f 1 4 3", "f 1 3 4"}; /* whichever way it runs */
    for (size_t i = 0; i < 2; ++i) {
        snprintf(closed, sizeof closed, "%s%s\n", tetrahedron, last[i]);
        import_serve(self, "scenes/t.obj", closed, strlen(closed));
        mitsuba_loads(self, "3.0.0", scene);
        assert_int_equal(mitsuba_medium(self, 0)->boundary.kind, AIR_BOUNDARY_MESH);
    }
}

/* ---- grids ---- */

/* 3 x 2 x 2 values in the box from (-1,-1,-1) to (1,1,1). */
static size_t make_volume(uint8_t *out)
{
    const int32_t numbers[5] = {1, 3, 2, 2, 1};
    const float box[6] = {-1, -1, -1, 1, 1, 1};
    float values[12];
    for (size_t i = 0; i < 12; ++i)
        values[i] = (float)(i % 3);
    memcpy(out, "VOL\3", 4);
    memcpy(out + 4, numbers, sizeof numbers);
    memcpy(out + 24, box, sizeof box);
    memcpy(out + 48, values, sizeof values);
    return 48 + sizeof values;
}

/* The density is i at the place where the version has value i along x. */
static void check_grid(import_fixture *self, const char *version, const char *inside,
                       const float places[3])
{
    char scene[2048];
    snprintf(scene, sizeof scene,
             "<medium type='heterogeneous' id='m'><volume name='%s' type='gridvolume'>"
             "<string name='filename' value='v.vol'/>%s</volume><float name='scale' value='2'/>"
             "<float name='albedo' value='1'/></medium>%s",
             version[0] == '0' ? "density" : "sigma_t", inside,
             SHELL("cube", "<transform name='to_world'><scale value='9'/></transform>"
                           "<ref name='interior' id='m'/>"));
    mitsuba_loads(self, version, scene);
    assert_int_equal(air_scene_commit(self->scene, &self->snapshot, NULL), AIR_OK);
    const air_medium_desc *desc = mitsuba_medium(self, 0);
    assert_floats(desc->sigma_s, 3, (const float[]){2, 2, 2});
    const air_medium *medium = &self->snapshot->media.media[0];
    for (size_t i = 0; i < 3; ++i) {
        float p[3];
        vec3_store(p, affine_point(medium->world_to_grid, vec3(places[i], places[0], places[0])));
        assert_true(fabsf(p[0] - (float)i) < 1e-5f);
    }
}

static void grids_fill_the_box_of_their_version(void **state)
{
    import_fixture *self = *state;
    uint8_t bytes[128];
    import_serve(self, "scenes/v.vol", bytes, make_volume(bytes));
    /* 0.x: nodes on the faces of the file's box */
    check_grid(self, "0.6.0", "", (const float[]){-1, 0, 1});
    check_grid(self, "0.6.0", "<point name='min' value='0 0 0'/><point name='max' value='4 4 4'/>",
               (const float[]){0, 2, 4});
    /* 3: cells of the unit cube */
    check_grid(self, "3.0.0", "", (const float[]){1.0f / 6.0f, 0.5f, 5.0f / 6.0f});
    check_grid(self, "3.0.0", "<boolean name='use_grid_bbox' value='true'/>",
               (const float[]){-2.0f / 3.0f, 0, 2.0f / 3.0f});
    check_grid(self, "3.0.0", "<transform name='to_world'><scale value='6'/></transform>",
               (const float[]){1, 3, 5});
}

/* A room of fog is what the sensor is in, or what another shape has outside. */
static void media_that_nobody_sees_are_told(void **state)
{
    import_fixture *self = *state;
    const char *fog = "<medium type='homogeneous' id='fog'><float name='sigma_t' value='1'/>"
                      "</medium>";
    snprintf(self->text, sizeof self->text,
             "<scene version='3.0.0'>%s<shape type='cube'><ref name='interior' id='fog'/></shape>"
             "</scene>",
             fog);
    assert_int_equal(mitsuba_text(self, self->text), AIR_OK);
    assert_int_equal(mitsuba_count(self, AIR_OBJECT_MEDIUM), 0);
    import_expect(self, AIR_MESSAGE_WARNING,
                  "line 1: <shape type=\"cube\">: the shape is opaque, so that nobody sees the "
                  "medium within; <bsdf type=\"null\"/> lets rays pass");
    snprintf(self->text, sizeof self->text,
             "<scene version='3.0.0'>%s<shape type='cube'><ref name='interior' id='fog'/></shape>"
             "<sensor type='perspective'><ref id='fog'/></sensor></scene>",
             fog);
    assert_int_equal(mitsuba_text(self, self->text), AIR_OK);
    assert_int_equal(mitsuba_count(self, AIR_OBJECT_MEDIUM), 1);
    import_expect_silence(self, AIR_MESSAGE_WARNING);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(coefficients_come_both_ways, set_up, tear_down),
        cmocka_unit_test_setup_teardown(presets_are_refused, set_up, tear_down),
        cmocka_unit_test_setup_teardown(phase_functions_are_read, set_up, tear_down),
        cmocka_unit_test_setup_teardown(the_inner_medium_holds, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_sensor_inside_is_inside, set_up, tear_down),
        cmocka_unit_test_setup_teardown(clear_shapes_keep_fog_out, set_up, tear_down),
        cmocka_unit_test_setup_teardown(open_shapes_bound_nothing, set_up, tear_down),
        cmocka_unit_test_setup_teardown(grids_fill_the_box_of_their_version, set_up, tear_down),
        cmocka_unit_test_setup_teardown(media_that_nobody_sees_are_told, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
