/* The airlight object: where it may stand, what it may say, and how it is refused. */
#include <math.h>
#include <stdlib.h>

#include "import_fixture.h"
#include "scene/media/grid.h"

/* A glTF file with a cube named Fog, and a sidecar beside it with this text. */
typedef struct sidecar_fixture {
    import_fixture base;
    uint8_t cube[168];
    char sidecar[FIXTURE_TEXT];
} sidecar_fixture;

#define CUBE_ROOM "{" GLTF_SCENE ",'nodes':[{'mesh':0,'name':'Fog'}]," GLTF_CUBE "}"

static void start(sidecar_fixture *f)
{
    import_init(&f->base);
    import_serve_cube(&f->base, f->cube);
}

static air_status beside(sidecar_fixture *f, const char *text)
{
    assert_true(strlen(text) < sizeof f->sidecar);
    strcpy(f->sidecar, text);
    import_quotes(f->sidecar);
    import_serve(&f->base, "room.airlight.json", f->sidecar, strlen(f->sidecar));
    return import_text(&f->base, CUBE_ROOM);
}

static void beside_loads(sidecar_fixture *f, const char *text)
{
    if (beside(f, text) != AIR_OK)
        fail_msg("%s", air_context_last_error(f->base.context));
}

/* Refused with one message: "room.airlight.json: " and this. */
static void beside_refused(sidecar_fixture *f, const char *text, const char *message)
{
    char line[1024];
    assert_int_not_equal(beside(f, text), AIR_OK);
    snprintf(line, sizeof line, "room.airlight.json: %s\n", message);
    assert_string_equal(f->base.said[AIR_MESSAGE_ERROR], line);
}

static const air_medium *only_medium(const sidecar_fixture *f)
{
    assert_int_equal(f->base.snapshot->media.count, 1);
    return &f->base.snapshot->media.media[0];
}

static const air_light *only_light(const sidecar_fixture *f)
{
    assert_int_equal(f->base.snapshot->lights.explicit_count, 1);
    return &f->base.snapshot->lights.entries[0];
}

/* Relative, a few roundings of single precision. */
static void expect_near(float value, double expected)
{
    if (fabs((double)value - expected) > 1e-6 * fabs(expected) + 1e-6)
        fail_msg("%.9g is not %.9g", (double)value, expected);
}

static void expect_bounds(const air_medium *medium, const float min[3], const float max[3])
{
    for (size_t i = 0; i < 3; ++i) {
        expect_near(medium->bounds_min[i], (double)min[i]);
        expect_near(medium->bounds_max[i], (double)max[i]);
    }
}

/* ---- where it may stand ---- */

static void a_medium_on_a_node_is_bounded_by_its_mesh(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    import_loads(&f.base, "{" GLTF_SCENE
                          ",'nodes':[{'mesh':0,'name':'Fog','translation':[0,2,0],'scale':[3,2,1],"
                          "'extras':{'airlight':{'medium':{'sigma_s':0.5,'sigma_a':[0.1,0.2,0.3],'"
                          "g':0.25}}}}]," GLTF_CUBE "}");
    const air_medium *medium = only_medium(&f);
    assert_string_equal(medium->name, "Fog");
    assert_int_equal(medium->boundary, AIR_BOUNDARY_BOX);
    expect_bounds(medium, (const float[]){-3, 0, -1}, (const float[]){3, 4, 1});
    expect_near(medium->sigma_s.y, 0.5);
    expect_near(medium->sigma_a.z, 0.3f);
    assert_int_equal(medium->phase.kind, AIR_PHASE_HG);
    assert_true(medium->phase.g == 0.25f);
    assert_int_equal(f.base.snapshot->mesh_count, 0); /* the boundary is no surface */
    import_finish(&f.base);
}

static void a_boundary_may_stay_visible(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    import_loads(&f.base,
                 "{" GLTF_SCENE ",'nodes':[{'mesh':0,'extras':{'airlight':{'medium':{'sigma_s':1,"
                 "'boundary_visible':true}}}}]," GLTF_CUBE "}");
    assert_int_equal(f.base.snapshot->mesh_count, 1);
    import_finish(&f.base);
}

static void blender_writes_the_object_as_a_string(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    char text[] = "{" GLTF_ASSET
                  ",'scenes':[{'extras':{'airlight':'{\\'media\\':[{\\'visibility\\':50}]}'}}]}";
    import_loads(&f.base, text);
    expect_near(only_medium(&f)->sigma_t.x, 3.912023005428146 / 50.0);
    char broken[] = "{" GLTF_ASSET ",'scenes':[{'extras':{'airlight':'{\\'media\\':'}}]}";
    assert_int_equal(import_text(&f.base, broken), AIR_ERROR_FORMAT);
    import_expect(&f.base, AIR_MESSAGE_ERROR,
                  "room.gltf: $.scenes[0].extras.airlight: not valid JSON at line 1, column 9");
    char negative[] =
        "{" GLTF_ASSET ",'scenes':[{'extras':{'airlight':'{\\'media\\':[{\\'sigma_s\\':-1}]}'}}]}";
    import_refuses(&f.base, negative, AIR_ERROR_FORMAT,
                   "room.gltf: $.scenes[0].extras.airlight.media[0].sigma_s: expected a number >= "
                   "0, found -1");
    import_finish(&f.base);
}

static void all_places_are_read_in_order(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    char beside_text[] = "{'media':[{'name':'beside','sigma_s':1}]}",
         with_text[] = "{'media':[{'name':'with','sigma_s':1}]}";
    import_quotes(beside_text);
    import_quotes(with_text);
    const char *with[] = {"more/with.json"};
    const char *media[] = {"sigma_s=1,name=argument", "visibility=20"};
    import_serve(&f.base, "room.airlight.json", beside_text, strlen(beside_text));
    import_serve(&f.base, "more/with.json", with_text, strlen(with_text));
    f.base.params.with = with;
    f.base.params.with_count = 1;
    f.base.params.media = media;
    f.base.params.media_count = 2;
    import_loads(
        &f.base,
        "{" GLTF_ASSET ",'extras':{'airlight':{'media':[{'name':'root','sigma_s':1}]}},"
        "'scenes':[{'nodes':[0],'extras':{'airlight':{'media':[{'name':'scene','sigma_s':1}]}}}],"
        "'nodes':[{'extras':{'airlight':{'media':[{'name':'node','sigma_s':1}]}}}]}");
    static const char *const names[] = {"root", "scene",    "node",    "beside",
                                        "with", "argument", "medium 2"};
    assert_int_equal(f.base.snapshot->media.count, 7);
    for (size_t i = 0; i < 7; ++i)
        assert_string_equal(f.base.snapshot->media.media[i].name, names[i]);
    import_finish(&f.base);
}

static void a_missing_with_file_is_an_error_a_missing_sidecar_is_not(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    const char *with[] = {"gone.json"};
    import_loads(&f.base, CUBE_ROOM);
    import_expect_silence(&f.base, AIR_MESSAGE_ERROR);
    f.base.params.with = with;
    f.base.params.with_count = 1;
    assert_int_equal(import_text(&f.base, CUBE_ROOM), AIR_ERROR_IO);
    import_expect(&f.base, AIR_MESSAGE_ERROR, "gone.json");
    import_finish(&f.base);
}

/* ---- media ---- */

static void coefficients_may_be_said_in_three_ways(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    beside_loads(&f, "{'media':[{'sigma_t':2,'albedo':[0.25,0.5,1],'emission':3}]}");
    expect_near(only_medium(&f)->sigma_s.x, 0.5);
    expect_near(only_medium(&f)->sigma_a.x, 1.5);
    expect_near(only_medium(&f)->sigma_a.z, 0.0);
    expect_near(only_medium(&f)->emission.y, 3.0);
    beside_loads(&f, "{'media':[{'visibility':100}]}");
    expect_near(only_medium(&f)->sigma_t.x, 0.03912023005428146);
    expect_near(only_medium(&f)->sigma_s.x, 0.99 * 0.03912023005428146);
    beside_loads(&f, "{'media':[{'sigma_a':1}]}");
    expect_near(only_medium(&f)->sigma_s.x, 0.0);
    beside_refused(&f, "{'media':[{'sigma_s':1,'sigma_t':2}]}",
                   "$.media[0].sigma_t: expected one of sigma_t, visibility, and sigma_s with "
                   "sigma_a, found several");
    beside_refused(&f, "{'media':[{'sigma_s':1,'albedo':1}]}",
                   "$.media[0].albedo: expected sigma_t or visibility beside the albedo");
    beside_refused(&f, "{'media':[{}]}",
                   "$.media[0]: expected sigma_s and sigma_a, or sigma_t, or visibility");
    import_finish(&f.base);
}

static void phase_functions_are_named(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    beside_loads(&f, "{'media':[{'sigma_s':1}]}");
    assert_int_equal(only_medium(&f)->phase.kind, AIR_PHASE_ISOTROPIC);
    beside_loads(&f, "{'media':[{'sigma_s':1,'phase':'rayleigh'}]}");
    assert_int_equal(only_medium(&f)->phase.kind, AIR_PHASE_RAYLEIGH);
    beside_loads(&f, "{'media':[{'sigma_s':1,'phase':{'type':'hg','g':-0.5}}]}");
    assert_int_equal(only_medium(&f)->phase.kind, AIR_PHASE_HG);
    assert_true(only_medium(&f)->phase.g == -0.5f);
    beside_refused(&f, "{'media':[{'sigma_s':1,'g':1}]}",
                   "$.media[0].g: expected a number above -1 and below 1, found 1");
    beside_refused(&f, "{'media':[{'sigma_s':1,'g':0.5,'phase':'rayleigh'}]}",
                   "$.media[0].g: only the phase function \"hg\" has a g");
    beside_refused(&f, "{'media':[{'sigma_s':1,'phase':'mie'}]}",
                   "$.media[0].phase: expected one of isotropic, hg, rayleigh, found \"mie\"");
    import_finish(&f.base);
}

static void mixtures_are_read(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    beside_loads(&f, "{'media':[{'sigma_s':1,'phase':{'type':'mixture','lobes':[{'type':'hg',"
                     "'g':0.5,'weight':6},{'type':'isotropic','weight':2,'comment':'haze'}]}}]}");
    const air_medium *medium = only_medium(&f);
    assert_int_equal(medium->phase.kind, AIR_PHASE_MIXTURE);
    assert_int_equal(medium->phase.mixture->lobe_count, 2);
    assert_int_equal(medium->phase.mixture->lobes[0].kind, AIR_PHASE_HG);
    assert_true(medium->phase.mixture->lobes[0].g == 0.5f);
    assert_true(medium->phase.mixture->lobes[0].weight == 0.75f);
    assert_true(medium->phase.mixture->lobes[1].weight == 0.25f);
    beside_loads(&f, "{'media':[{'sigma_s':1,'phase':{'type':'mixture','lobes':[{'type':"
                     "'rayleigh','weight':0.5}]}}]}");
    assert_int_equal(only_medium(&f)->phase.kind, AIR_PHASE_RAYLEIGH);
    import_finish(&f.base);
}

static void mixtures_out_of_order_are_refused(void **state)
{
    static const char *const cases[][2] = {
        {"{'type':'mixture'}", ".lobes: expected an array of 1 to 8 lobes, found nothing"},
        {"{'type':'mixture','lobes':[]}",
         ".lobes: expected an array of 1 to 8 lobes, found an array of 0"},
        {"{'type':'mixture','lobes':[1]}", ".lobes[0]: expected an object, found 1"},
        {"{'type':'mixture','lobes':[{'weight':1}]}",
         ".lobes[0].type: expected a phase function, found nothing"},
        {"{'type':'mixture','lobes':[{'type':'mixture','weight':1}]}",
         ".lobes[0].type: expected one of isotropic, hg, rayleigh, found \"mixture\""},
        {"{'type':'mixture','lobes':[{'type':'hg'}]}",
         ".lobes[0].weight: expected the lobe's weight, found nothing"},
        {"{'type':'mixture','lobes':[{'type':'hg','weight':-1}]}",
         ".lobes[0].weight: expected a number >= 0, found -1"},
        {"{'type':'mixture','lobes':[{'type':'hg','g':1,'weight':1}]}",
         ".lobes[0].g: expected a number above -1 and below 1, found 1"},
        {"{'type':'mixture','lobes':[{'type':'rayleigh','g':0,'weight':1}]}",
         ".lobes[0].g: only the phase function \"hg\" has a g"},
        {"{'type':'mixture','lobes':[{'type':'hg','weight':0}]}",
         ".lobes: expected a weight above 0"},
        {"{'type':'mixture','g':0.5,'lobes':[{'type':'hg','weight':1}]}",
         ".g: unknown key; known are type, lobes"},
        {"{'type':'hg','lobes':[]}", ".lobes: unknown key; known are type, g"},
        {"{'lobes':[]}", ".type: expected a phase function, found nothing"},
    };
    (void)state;
    sidecar_fixture f;
    start(&f);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char text[256], message[256];
        snprintf(text, sizeof text, "{'media':[{'sigma_s':1,'phase':%s}]}", cases[i][0]);
        snprintf(message, sizeof message, "$.media[0].phase%s", cases[i][1]);
        beside_refused(&f, text, message);
    }
    beside_refused(&f, "{'media':[{'sigma_s':1,'phase':'mixture'}]}",
                   "$.media[0].phase: expected one of isotropic, hg, rayleigh, found \"mixture\"");
    import_finish(&f.base);
}

/* Rayleigh's by its values at five cosines: chords are off by 1/16 of 4/3 at most, 6 % of what is
 * there, so the fit is within a tenth. */
static void tables_become_lobes(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    beside_loads(&f, "{'media':[{'sigma_s':1,'phase':{'type':'table','cosines':[-1,-0.5,0,0.5,1],"
                     "'values':[8,5,4,5,8]}}]}");
    const air_medium *medium = only_medium(&f);
    for (float c = -1.0f; c <= 1.0f; c += 0.125f) {
        const float expected = 3.0f / (16.0f * AIR_PI_F) * (1.0f + c * c);
        assert_true(fabsf(air_phase_eval(medium->phase, c) - expected) < 0.1f * expected);
    }
    import_expect(&f.base, AIR_MESSAGE_INFO,
                  "room.airlight.json: $.media[0].phase: the table became ");
    import_expect_silence(&f.base, AIR_MESSAGE_WARNING);
    beside_loads(&f, "{'media':[{'sigma_s':1,'phase':{'type':'table','cosines':[-1,0,1],"
                     "'values':[0,1,0]}}]}");
    import_expect(&f.base, AIR_MESSAGE_WARNING,
                  "room.airlight.json: $.media[0].phase: the table became ");
    import_finish(&f.base);
}

static void tables_out_of_order_are_refused(void **state)
{
    static const char *const cases[][2] = {
        {"", ".cosines: expected an array of at least 2 numbers, found nothing"},
        {",'cosines':[1]",
         ".cosines: expected an array of at least 2 numbers, found an array of 1"},
        {",'cosines':[-1,1]",
         ".values: expected an array of 2 numbers, one per cosine, found nothing"},
        {",'cosines':[-1,1],'values':[1,2,3]",
         ".values: expected an array of 2 numbers, one per cosine, found an array of 3"},
        {",'cosines':[-1,'x'],'values':[1,2]", ".cosines[1]: expected a number, found \"x\""},
        {",'cosines':[-1,1],'values':[1,null]", ".values[1]: expected a number, found null"},
        {",'cosines':[-0.5,1],'values':[1,2]", ": cosines[0] is -0.5, but must be -1"},
        {",'cosines':[-1,0.5],'values':[1,2]", ": cosines[1] is 0.5, but must be 1"},
        {",'cosines':[-1,0,0,1],'values':[1,2,2,1]",
         ": cosines[2] is 0, but must be above the one before, 0"},
        {",'cosines':[-1,1],'values':[1,-2]",
         ": values[1] is -2, but must be finite and at least 0"},
        {",'cosines':[-1,1],'values':[0,0]", ": all values are 0"},
        {",'cosines':[-1,1],'values':[1,1],'g':0",
         ".g: unknown key; known are type, cosines, values"},
    };
    (void)state;
    sidecar_fixture f;
    start(&f);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char text[256], message[256];
        snprintf(text, sizeof text, "{'media':[{'sigma_s':1,'phase':{'type':'table'%s}}]}",
                 cases[i][0]);
        snprintf(message, sizeof message, "$.media[0].phase%s", cases[i][1]);
        beside_refused(&f, text, message);
    }
    import_finish(&f.base);
}

static void boxes_may_be_said_in_three_ways(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    beside_loads(&f, "{'media':[{'sigma_s':1,'boundary':{'box':{'min':[-1,0,2],'max':[1,1,4]}}}]}");
    assert_int_equal(only_medium(&f)->boundary, AIR_BOUNDARY_BOX);
    expect_bounds(only_medium(&f), (const float[]){-1, 0, 2}, (const float[]){1, 1, 4});
    /* a quarter turn about +Y swaps the lengths in x and z, about the box's own centre */
    beside_loads(&f, "{'media':[{'sigma_s':1,'boundary':{'box':{'center':[5,0,0],'size':[2,4,8],"
                     "'rotation':[0,0.70710678,0,0.70710678]}}}]}");
    expect_bounds(only_medium(&f), (const float[]){1, -2, -1}, (const float[]){9, 2, 1});
    beside_loads(&f,
                 "{'media':[{'sigma_s':1,'boundary':{'sphere':{'center':[1,2,3],'radius':2}}}]}");
    assert_int_equal(only_medium(&f)->boundary, AIR_BOUNDARY_ELLIPSOID);
    expect_near(only_medium(&f)->bounds_min[1], 0.0);
    expect_near(only_medium(&f)->bounds_max[2], 5.0);
    beside_loads(&f, "{'media':[{'sigma_s':1,'boundary':{'ellipsoid':[[2,0,0,1],[0,1,0,0],"
                     "[0,0,1,0]]}}]}");
    expect_near(only_medium(&f)->bounds_max[0], 3.0);
    beside_refused(&f, "{'media':[{'sigma_s':1,'boundary':{'sphere':{'center':[1,2,3]}}}]}",
                   "$.media[0].boundary.sphere.radius: expected a radius, found nothing");
    beside_refused(&f,
                   "{'media':[{'sigma_s':1,'boundary':{'ellipsoid':[[2,0,0,1],[0,0,0,0],"
                   "[0,0,1,0]]}}]}",
                   "$.media[0].boundary.ellipsoid: the ellipsoid has no volume");
    beside_loads(&f, "{'media':[{'sigma_s':1,'boundary':{'box':{'to_world':[[1,0,0,3],[0,2,0,0],[0,"
                     "0,1,0],[0,0,0,1]]}}}]}");
    expect_bounds(only_medium(&f), (const float[]){2, -2, -1}, (const float[]){4, 2, 1});
    beside_refused(&f, "{'media':[{'sigma_s':1,'boundary':{'box':{'min':[0,0,0],'max':[1,0,1]}}}]}",
                   "$.media[0].boundary.box.max[1]: expected a number above 0, which is the box's "
                   "min[1], found 0");
    beside_refused(&f, "{'media':[{'sigma_s':1,'boundary':{'box':{'min':[0,0,0]}}}]}",
                   "$.media[0].boundary.box.max: expected a point, found nothing");
    beside_refused(
        &f,
        "{'media':[{'sigma_s':1,'boundary':{'box':{'to_world':[[1,0,0,3],[0,0,0,0],[0,0,1,0]]}}}]}",
        "$.media[0].boundary.box: the box has no volume");
    import_finish(&f.base);
}

static void other_boundaries_are_planes_meshes_and_none(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    beside_loads(&f, "{'media':[{'sigma_s':1,'boundary':'unbounded'}]}");
    assert_int_equal(only_medium(&f)->boundary, AIR_BOUNDARY_UNBOUNDED);
    beside_loads(
        &f,
        "{'media':[{'sigma_s':1,'boundary':{'planes':[[1,0,0,1],[-1,0,0,1],[0,1,0,2],[0,-1,0,0],"
        "[0,0,1,1],[0,0,-1,1],[1,1,0,2]]}}]}");
    expect_bounds(only_medium(&f), (const float[]){-1, 0, -1}, (const float[]){1, 2, 1});
    assert_int_equal(f.base.snapshot->mesh_count, 1);
    beside_loads(&f, "{'media':[{'sigma_s':1,'boundary':{'mesh':'Fog'}}]}");
    expect_bounds(only_medium(&f), (const float[]){-1, -1, -1}, (const float[]){1, 1, 1});
    assert_int_equal(f.base.snapshot->mesh_count, 0);
    beside_loads(
        &f, "{'media':[{'sigma_s':1,'boundary':{'mesh':'CubeMesh'},'boundary_visible':true}]}");
    assert_int_equal(f.base.snapshot->mesh_count, 1);
    beside_refused(
        &f, "{'media':[{'sigma_s':1,'boundary':{'mesh':'fogg'}}]}",
        "$.media[0].boundary.mesh: the scene has no object \"fogg\"; did you mean \"Fog\"?");
    beside_refused(&f, "{'media':[{'sigma_s':1,'boundary':'everywhere'}]}",
                   "$.media[0].boundary: expected one of unbounded, found \"everywhere\"");
    beside_refused(&f, "{'media':[{'sigma_s':1,'boundary':{'planes':[[0,0,0,1]]}}]}",
                   "$.media[0].boundary.planes[0]: expected nx, ny, nz, h with a normal that is "
                   "not 0, found an array of 4");
    import_finish(&f.base);
}

static void an_open_boundary_mesh_is_refused_with_file_and_place(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    assert_int_equal(import_text(&f.base,
                                 "{" GLTF_SCENE
                                 ",'nodes':[{'mesh':0,'name':'Leak','extras':{'airlight':{'medium':"
                                 "{'sigma_s':1}}}}]," GLTF_TRIANGLE "}"),
                     AIR_ERROR_ARGUMENT);
    import_expect(
        &f.base, AIR_MESSAGE_ERROR,
        "medium \"Leak (room.gltf: $.nodes[0].extras.airlight.medium)\": the boundary mesh");
    import_refuses(&f.base,
                   "{" GLTF_SCENE ",'nodes':[{'extras':{'airlight':{'medium':{'sigma_s':1}}}}]}",
                   AIR_ERROR_FORMAT,
                   "room.gltf: $.nodes[0].extras.airlight.medium.boundary: expected a boundary, as "
                   "the node has no mesh, found "
                   "nothing");
    import_finish(&f.base);
}

static void layers_and_height_fog_follow_their_node(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    beside_loads(
        &f,
        "{'media':[{'sigma_s':1,'density':{'exponential':{'base_height':1,'scale_height':4}}}]}");
    const air_medium *medium = only_medium(&f);
    assert_int_equal(medium->declared_kind, AIR_DENSITY_EXPONENTIAL);
    expect_near(medium->base_height, 1.0);
    expect_near(medium->inverse_scale_height, 0.25);
    beside_loads(&f, "{'media':[{'sigma_s':1,'density':{'layers':[{'bottom':0,'density':1},{'"
                     "bottom':2,'density':0.5}],"
                     "'top':5,'up':[0,0,2]}}]}");
    medium = only_medium(&f);
    assert_int_equal(medium->declared_kind, AIR_DENSITY_LAYERED);
    assert_true(medium->up.z == 1.0f && medium->up.y == 0.0f);
    assert_int_equal(f.base.snapshot->media.region_count, 2);
    /* a node of scale 2, 10 m up, turned so that its +Y is the world's +X */
    import_serve(&f.base, "room.airlight.json", "{}", 2);
    import_loads(&f.base,
                 "{" GLTF_SCENE
                 ",'nodes':[{'translation':[10,0,0],'scale':[2,2,2],'rotation':[0,0,-0.70710678,"
                 "0.70710678],'extras':{'airlight':{'media':[{'sigma_s':1,'density':{'exponential':"
                 "{'base_height':3,"
                 "'scale_height':4}}}]}}}]}");
    medium = only_medium(&f);
    expect_near(medium->up.x, 1.0);
    expect_near(medium->up.y, 0.0);
    expect_near(medium->base_height, 16.0);
    expect_near(medium->inverse_scale_height, 0.125);
    beside_refused(
        &f,
        "{'media':[{'sigma_s':1,'density':{'layers':[{'bottom':1,'density':1},{'bottom':1,'density'"
        ":1}]}}]}",
        "$.media[0].density.layers[1].bottom: expected a height above the layer before, found 1");
    beside_refused(&f, "{'media':[{'sigma_s':1,'density':{'exponential':{'scale_height':0}}}]}",
                   "$.media[0].density.exponential.scale_height: expected a number > 0, found 0");
    beside_refused(&f, "{'media':[{'sigma_s':1,'density':{}}]}",
                   "$.media[0].density: expected one of layers, exponential and grid");
    import_finish(&f.base);
}

/* On a node that doubles lengths and stands at x = 3. */
static void detail_is_fixed_in_its_node(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    import_loads(&f.base,
                 "{" GLTF_SCENE ",'nodes':[{'mesh':0,'translation':[3,0,0],'scale':[2,2,2],"
                 "'extras':{'airlight':{'medium':{'sigma_s':1,'detail':{'strength':0.5,'scale':"
                 "0.25,'octaves':3,'seed':4294967295}}}}}]," GLTF_CUBE "}");
    const air_detail_field *field = &only_medium(&f)->detail;
    expect_near(field->strength, 0.5);
    expect_near(field->feature_m, 0.5);
    expect_near(field->to_lattice[0], 2.0);
    expect_near(field->to_lattice[3], -6.0);
    assert_int_equal(field->octaves, 3);
    beside_loads(&f, "{'media':[{'sigma_s':1,'boundary':{'mesh':'Fog'}}]}");
    assert_false(air_medium_is_detailed(only_medium(&f)));
    import_finish(&f.base);
}

static void bad_detail_is_refused(void **state)
{
    (void)state;
    static const struct {
        const char *detail, *message;
    } faults[] = {
        {"{'scale':1}", ".strength: expected a strength of at least 0 and below 1, found nothing"},
        {"{'strength':0.5}",
         ".scale: expected the size of the largest features in metres, found nothing"},
        {"{'strength':1,'scale':1}",
         ".strength: expected a number of at least 0 and below 1, found 1"},
        {"{'strength':-0.5,'scale':1}", ".strength: expected a number >= 0, found -0.5"},
        {"{'strength':'a','scale':1}", ".strength: expected a number >= 0, found \"a\""},
        {"{'strength':0.5,'scale':0}", ".scale: expected a number > 0, found 0"},
        {"{'strength':0.5,'scale':1,'octaves':0}",
         ".octaves: expected a whole number from 1 to 12, found 0"},
        {"{'strength':0.5,'scale':1,'octaves':13}",
         ".octaves: expected a whole number from 1 to 12, found 13"},
        {"{'strength':0.5,'scale':1,'seed':4294967296}",
         ".seed: expected a whole number below 2^32, found 4294967296"},
        {"{'strength':0.5,'scales':1}", ".scales: unknown key; did you mean \"scale\"?"},
        {"{'strength':0.5,'scale':1}",
         ": expected a boundary or a grid beside it: only media with an end have detail"},
    };
    sidecar_fixture f;
    start(&f);
    for (size_t i = 0; i < sizeof faults / sizeof faults[0]; ++i) {
        char text[256], message[256];
        snprintf(text, sizeof text, "{'media':[{'sigma_s':1,'detail':%s}]}", faults[i].detail);
        snprintf(message, sizeof message, "$.media[0].detail%s", faults[i].message);
        beside_refused(&f, text, message);
    }
    beside_loads(&f, "{'media':[{'sigma_s':1,'detail':{'strength':0,'scale':1}}]}");
    import_finish(&f.base);
}

static void a_grid_without_a_boundary_is_bounded_by_its_own_box(void **state)
{
    (void)state;
    static const float values[8] = {1, 1, 1, 1, 1, 1, 1, 1};
    sidecar_fixture f;
    start(&f);
    import_serve(&f.base, "smoke.raw", values, sizeof values);
    beside_loads(&f, "{'media':[{'sigma_s':1,'density':{'grid':{'file':'smoke.raw','size':[2,2,2],"
                     "'to_world':[[4,0,0,1],[0,4,0,0],[0,0,4,0]]}}}]}");
    const air_medium *medium = only_medium(&f);
    assert_int_equal(medium->declared_kind, AIR_DENSITY_GRID);
    assert_int_equal(medium->boundary, AIR_BOUNDARY_BOX);
    expect_bounds(medium, (const float[]){1, 0, 0}, (const float[]){5, 4, 4});
    beside_refused(&f, "{'media':[{'sigma_s':1,'density':{'grid':{'file':'smoke.raw'}}}]}",
                   "$.media[0].density.grid.size: expected an array of three sizes for a raw grid, "
                   "found nothing");
    beside_refused(&f,
                   "{'media':[{'sigma_s':1,'density':{'grid':{'file':'a.nvdb','size':[2,2,2]}}}]}",
                   "$.media[0].density.grid.size: only a raw grid has to be told its size");
    beside_refused(&f, "{'media':[{'sigma_s':1,'albedo_grid':{'file':'a.nvdb'}}]}",
                   "$.media[0].albedo_grid: expected a density grid beside it");
    import_finish(&f.base);
}

static void a_grid_whose_name_holds_hashes_is_that_of_the_frame(void **state)
{
    (void)state;
    static const char *const text =
        "{'media':[{'sigma_s':1,'density':{'grid':{'file':'smoke.##.raw','size':[2,2,2]}},"
        "'albedo_grid':{'file':'albedo.#.raw','size':[1,1,1],'channels':3}}]}";
    static const float values[8] = {2, 2, 2, 2, 2, 2, 2, 2}, albedo[3] = {0.5f, 0.5f, 0.5f};
    sidecar_fixture f;
    start(&f);
    import_serve(&f.base, "smoke.07.raw", values, sizeof values);
    import_serve(&f.base, "albedo.7.raw", albedo, sizeof albedo);
    f.base.params.frame = 7;
    beside_loads(&f, text);
    assert_float_equal(air_grid_max(only_medium(&f)->density_grid), 2.0f, 0.0f);
    assert_non_null(only_medium(&f)->albedo_grid);
    expect_bounds(only_medium(&f), (const float[]){0, 0, 0}, (const float[]){1, 1, 1});
    f.base.params.frame = AIR_FRAME_NONE;
    assert_int_equal(beside(&f, text), AIR_ERROR_IO);
    assert_string_equal(
        f.base.said[AIR_MESSAGE_ERROR],
        "smoke.##.raw: there is no such file, and # stands for the number of a frame: expected one "
        "(--frames of airlight render, --frame of bake and info)\n");
    f.base.params.frame = 8;
    assert_int_equal(beside(&f, text), AIR_ERROR_IO);
    assert_string_equal(f.base.said[AIR_MESSAGE_ERROR], "smoke.08.raw: cannot be read\n");
    import_finish(&f.base);
}

/* Then it is a name like any other. */
static void without_a_frame_a_file_may_have_hashes_in_its_name(void **state)
{
    (void)state;
    static const float values[8] = {2, 2, 2, 2, 2, 2, 2, 2};
    sidecar_fixture f;
    start(&f);
    import_serve(&f.base, "smoke#.raw", values, sizeof values);
    beside_loads(&f, "{'media':[{'sigma_s':1,'density':{'grid':{'file':'smoke#.raw','size':"
                     "[2,2,2]}}}]}");
    assert_int_equal(only_medium(&f)->boundary, AIR_BOUNDARY_BOX);
    import_finish(&f.base);
}

static void overlap_is_added_or_replaced(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    beside_loads(&f, "{'media':[{'sigma_s':1,'combine':'replace','priority':-3}]}");
    assert_int_equal(only_medium(&f)->combine, AIR_COMBINE_REPLACE);
    assert_int_equal(only_medium(&f)->priority, -3);
    beside_refused(&f, "{'media':[{'sigma_s':1,'priority':0.5}]}",
                   "$.media[0].priority: expected a whole number, found 0.5");
    import_finish(&f.base);
}

/* ---- lights ---- */

static void a_polygon_light_radiates_as_it_says(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    beside_loads(
        &f,
        "{'lights':[{'type':'polygon','name':'panel','vertices':[[0,2,0],[0,2,1],[1,2,1],[1,2,0]],"
        "'radiance':[1,2,3],'one_sided':false,'camera_visible':false,'casts_shadow':false}]}");
    const air_light *light = only_light(&f);
    assert_int_equal(light->kind, AIR_LIGHT_POLYGON);
    assert_true(light->color.x == 1.0f && light->color.z == 3.0f);
    assert_false(light->one_sided || light->camera_visible || light->casts_shadow);
    expect_near(light->area, 1.0);
    expect_near(light->normal.y, 1.0);
    import_finish(&f.base);
}

static void a_mirroring_node_keeps_the_front_of_a_polygon_light(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    /* mirrored in x: what shone up shines up */
    import_loads(&f.base,
                 "{" GLTF_SCENE
                 ",'nodes':[{'scale':[-1,1,1],'extras':{'airlight':{'lights':[{'type':'polygon',"
                 "'vertices':[[0,2,0],[0,2,1],[1,2,1],[1,2,0]],'radiance':1}]}}}]}");
    expect_near(only_light(&f)->normal.y, 1.0);
    import_finish(&f.base);
}

static void a_light_without_area_is_refused_with_file_and_place(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    assert_int_equal(
        beside(&f,
               "{'lights':[{'type':'polygon','vertices':[[0,0,0],[1,0,0],[2,0,0]],'radiance':1}]}"),
        AIR_ERROR_ARGUMENT);
    import_expect(&f.base, AIR_MESSAGE_ERROR,
                  "light \"lights[0] (room.airlight.json: $.lights[0])\": ");
    beside_refused(
        &f, "{'lights':[{'type':'polygon','vertices':[[0,0,0],[1,0,0]],'radiance':1}]}",
        "$.lights[0].vertices: expected an array of at least 3 points, found an array of 2");
    beside_refused(
        &f, "{'lights':[{'type':'polygon','vertices':[[0,0,0],[1,0,0],[0,1]],'radiance':1}]}",
        "$.lights[0].vertices[2]: expected an array of 3 numbers, found an array of 2");
    import_finish(&f.base);
}

static void a_collimated_light_passes_its_windows(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    beside_loads(&f, "{'lights':[{'type':'collimated','direction':[0,-2,0],'irradiance':3.5,'gobo':"
                     "[[[0,0,0],[1,0,0],[1,0,1]],"
                     "[[2,0,0],[3,0,0],[3,0,1],[2,0,1]]]}]}");
    const air_light *light = only_light(&f);
    assert_int_equal(light->kind, AIR_LIGHT_COLLIMATED);
    assert_true(light->dir.y == -1.0f && light->color.x == 3.5f);
    assert_int_equal(light->window_count, 2);
    assert_true(air_light_in_windows(light, vec3(0.75f, 9.0f, 0.25f)));
    assert_false(air_light_in_windows(light, vec3(1.5f, 9.0f, 0.25f)));
    assert_true(air_light_in_windows(light, vec3(2.5f, -9.0f, 0.75f)));
    beside_refused(
        &f, "{'lights':[{'type':'collimated','direction':[0,0,0],'irradiance':1}]}",
        "$.lights[0].direction: expected a direction that is not 0, found an array of 3");
    beside_refused(&f, "{'lights':[{'type':'collimated','direction':[0,1,0],'intensity':1}]}",
                   "$.lights[0].intensity: unknown key; known are type, name, direction, "
                   "irradiance, gobo, casts_shadow");
    import_finish(&f.base);
}

static void point_and_spot_lights_are_radiometric(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    beside_loads(&f, "{'lights':[{'type':'point','position':[1,2,3],'intensity':4}]}");
    assert_true(only_light(&f)->color.y == 4.0f && only_light(&f)->position.z == 3.0f);
    beside_loads(&f,
                 "{'lights':[{'type':'spot','position':[0,3,0],'direction':[0,-1,0],'intensity':4,"
                 "'inner_cone_degrees':20,'outer_cone_degrees':60}]}");
    const double scale = 1.0 / (cos(AIR_PI / 9.0) - 0.5);
    assert_true(fabs((double)only_light(&f)->spot_scale - scale) < 1e-4 * scale);
    assert_int_equal(only_light(&f)->falloff, AIR_SPOT_COSINE);
    beside_loads(&f,
                 "{'lights':[{'type':'spot','position':[0,3,0],'direction':[0,-1,0],'intensity':4,"
                 "'falloff':'angle'}]}");
    assert_int_equal(only_light(&f)->falloff, AIR_SPOT_ANGLE);
    beside_loads(&f, "{'lights':[{'type':'projector','position':[0,3,0],'direction':[0,-1,0],"
                     "'fov_x_degrees':90,'intensity':4}]}");
    assert_int_equal(only_light(&f)->kind, AIR_LIGHT_PROJECTOR);
    assert_true(fabsf(only_light(&f)->tan_half[1] - 1.0f) < 1e-6f);
    expect_near(only_light(&f)->frame.s.x, 1.0); /* north, -Z, is up in the picture */
    expect_near(only_light(&f)->frame.t.z, -1.0);
    expect_near(only_light(&f)->frame.n.y, 1.0);
    beside_refused(
        &f,
        "{'lights':[{'type':'spot','position':[0,3,0],'direction':[0,-1,0],'intensity':4,"
        "'inner_cone_degrees':60,'outer_cone_degrees':60}]}",
        "$.lights[0].inner_cone_degrees: expected an angle below the outer one (60 degrees), found "
        "60");
    beside_refused(
        &f, "{'lights':[{'type':'point','position':[1,2,3]}]}",
        "$.lights[0].intensity: expected a number >= 0, or an array of three, found nothing");
    import_finish(&f.base);
}

static void an_environment_is_constant_or_an_image(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    beside_loads(&f, "{'lights':[{'type':'environment','radiance':[1,2,3]}]}");
    const air_light *light = only_light(&f);
    assert_int_equal(light->kind, AIR_LIGHT_ENVIRONMENT);
    assert_null(light->environment);
    assert_true(light->color.z == 3.0f);
    /* a 2x1 colour PFM, rows from the bottom */
    uint8_t pfm[12 + 24];
    const float pixels[6] = {1, 2, 3, 4, 5, 6};
    memcpy(pfm, "PF\n2 1\n-1.0\n", 12);
    memcpy(pfm + 12, pixels, sizeof pixels);
    import_serve(&f.base, "sky.pfm", pfm, sizeof pfm);
    beside_loads(&f,
                 "{'lights':[{'type':'environment','image':'sky.pfm','rotation_y_degrees':90}]}");
    assert_non_null(only_light(&f)->environment);
    assert_true(only_light(&f)->color.x == 1.0f);
    assert_int_equal(f.base.snapshot->texture_count, 1);
    beside_refused(
        &f, "{'lights':[{'type':'environment'}]}",
        "$.lights[0].radiance: expected a number >= 0, or an array of three, found nothing");
    import_finish(&f.base);
}

static void the_environment_argument_is_a_constant_or_an_image(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    f.base.params.environment = "constant=.5";
    import_loads(&f.base, CUBE_ROOM);
    assert_true(only_light(&f)->color.x == 0.5f && only_light(&f)->color.z == 0.5f);
    f.base.params.environment = "constant=1,2,3";
    import_loads(&f.base, CUBE_ROOM);
    assert_true(only_light(&f)->color.x == 1.0f && only_light(&f)->color.z == 3.0f);
    static const char *const bad[] = {"constant=",   "constant=1,2",  "constant=1,2,3,4",
                                      "constant=-1", "constant=1,,2", "constant=1,2,"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
        char message[256];
        f.base.params.environment = bad[i];
        snprintf(message, sizeof message,
                 "--environment \"%s\": column 10: expected a radiance >= 0, or three as R,G,B",
                 bad[i]);
        import_refuses(&f.base, CUBE_ROOM, AIR_ERROR_ARGUMENT, message);
    }
    f.base.params.environment = "gone.hdr";
    assert_int_equal(import_text(&f.base, CUBE_ROOM), AIR_ERROR_IO);
    import_finish(&f.base);
}

/* ---- camera, objects, keys ---- */

static void the_last_sidecars_camera_is_the_first_of_the_scene(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    char with_text[] = "{'camera':{'name':'closeup','position':[0,5,0],'look_at':[0,0,0],'half_"
                       "height':2,'aspect':1}}";
    import_quotes(with_text);
    const char *with[] = {"with.json"};
    import_serve(&f.base, "with.json", with_text, strlen(with_text));
    f.base.params.with = with;
    f.base.params.with_count = 1;
    beside_loads(&f, "{'camera':{'position':[0,0,5],'look_at':[0,0,0],'fov_y_degrees':40}}");
    assert_int_equal(f.base.snapshot->camera_count, 2);
    const air_camera *first = &f.base.snapshot->cameras[0], *second = &f.base.snapshot->cameras[1];
    assert_string_equal(first->name, "closeup");
    assert_int_equal(first->kind, AIR_CAMERA_ORTHOGRAPHIC);
    assert_true(first->half_height == 2.0f && first->aspect == 1.0f);
    expect_near(first->to_world[6], 1.0);  /* looks down: its +Z is up */
    expect_near(first->to_world[9], -1.0); /* and its +Y north, -Z */
    assert_int_equal(second->kind, AIR_CAMERA_PERSPECTIVE);
    expect_near(second->fov_y_rad, 40.0 * AIR_PI / 180.0);
    const float expected[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 5};
    for (size_t i = 0; i < 12; ++i)
        expect_near(second->to_world[i], (double)expected[i]);
    assert_true(second->lens_radius == 0.0f);
    import_finish(&f.base);
}

static void a_lens_is_in_focus_where_the_camera_looks(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    beside_loads(&f, "{'camera':{'position':[0,0,5],'look_at':[0,0,2],'fov_y_degrees':40,"
                     "'lens_radius':0.05}}");
    expect_near(f.base.snapshot->cameras[0].lens_radius, 0.05);
    expect_near(f.base.snapshot->cameras[0].focus_distance, 3.0);
    beside_loads(&f, "{'camera':{'position':[0,0,5],'look_at':[0,0,2],'fov_y_degrees':40,"
                     "'lens_radius':0.05,'focus_distance':7}}");
    expect_near(f.base.snapshot->cameras[0].focus_distance, 7.0);
    beside_refused(&f,
                   "{'camera':{'position':[0,0,5],'look_at':[0,0,2],'half_height':1,"
                   "'lens_radius':0.05}}",
                   "$.camera.lens_radius: expected fov_y_degrees with it: a lens is perspective");
    import_finish(&f.base);
}

static void bad_cameras_are_refused(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    beside_refused(
        &f, "{'camera':{'position':[0,0,5],'look_at':[0,0,5],'fov_y_degrees':40}}",
        "$.camera.look_at: expected a point apart from the position, found an array of 3");
    beside_refused(
        &f, "{'camera':{'position':[0,0,5],'look_at':[0,0,0],'up':[0,0,1],'fov_y_degrees':40}}",
        "$.camera.up: expected a direction that is not that of the view, found an array of 3");
    beside_refused(
        &f, "{'camera':{'position':[0,0,5],'look_at':[0,0,0]}}",
        "$.camera: expected either fov_y_degrees (perspective) or half_height (orthographic)");
    beside_refused(&f, "{'camera':{'position':[0,0,5],'look_at':[0,0,0],'fov_y_degrees':180}}",
                   "$.camera.fov_y_degrees: expected an angle below 179.9 degrees, found 180");
    import_finish(&f.base);
}

static void flags_reach_the_objects_they_name(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    beside_loads(&f, "{'objects':{'Fog':{'camera_visible':false}}}");
    assert_int_equal(f.base.snapshot->meshes[0]->mask & AIR_MASK_CAMERA, 0);
    assert_int_not_equal(f.base.snapshot->meshes[0]->mask & AIR_MASK_SHADOW_OPAQUE, 0);
    beside_loads(&f, "{'objects':{'CubeMesh':{'casts_shadow':false}}}");
    assert_int_not_equal(f.base.snapshot->meshes[0]->mask & AIR_MASK_CAMERA, 0);
    assert_int_equal(f.base.snapshot->meshes[0]->mask & AIR_MASK_SHADOW_OPAQUE, 0);
    beside_refused(&f, "{'objects':{'Frog':{}}}",
                   "$.objects.Frog: the scene has no object \"Frog\"; did you mean \"Fog\"?");
    beside_refused(&f, "{'objects':{'Fog':{'visible':true}}}",
                   "$.objects.Fog.visible: unknown key; known are camera_visible, casts_shadow");
    import_serve(&f.base, "room.airlight.json", "{}", 2);
    import_loads(&f.base,
                 "{" GLTF_SCENE
                 ",'nodes':[{'mesh':0,'extras':{'airlight':{'casts_shadow':false}}}]," GLTF_CUBE
                 "}");
    assert_int_equal(f.base.snapshot->meshes[0]->mask & AIR_MASK_SHADOW_OPAQUE, 0);
    import_finish(&f.base);
}

static void a_byte_order_mark_does_no_harm(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    beside_loads(&f, "\xef\xbb\xbf{'media':[{'sigma_s':1}]}");
    assert_int_equal(f.base.snapshot->media.count, 1);
    import_finish(&f.base);
}

static void unknown_keys_name_the_nearest_known_one(void **state)
{
    (void)state;
    sidecar_fixture f;
    start(&f);
    beside_refused(&f, "{'medias':[]}", "$.medias: unknown key; did you mean \"media\"?");
    beside_refused(&f, "{'medium':{}}", "$.medium: unknown key; did you mean \"media\"?");
    beside_refused(&f, "{'media':[{'Sigma_S':1}]}",
                   "$.media[0].Sigma_S: unknown key; did you mean \"sigma_s\"?");
    beside_refused(&f, "{'media':[{'sigma_s':1,'boundary':{'bax':{}}}]}",
                   "$.media[0].boundary.bax: unknown key; did you mean \"box\"?");
    beside_refused(
        &f, "{'strange key':1}",
        "$[\"strange key\"]: unknown key; known are media, lights, camera, objects, version");
    beside_refused(&f, "{'version':2}", "$.version: expected version 1, found 2");
    beside_refused(&f, "[]", "$: expected an object, found an array of 0");
    beside_loads(&f, "{'version':1,'comment':'haze','media':[{'comment':'thin','sigma_s':0.01}]}");
    beside_refused(&f, "{'media':[],'media':[]}",
                   "$: not valid JSON at line 1, column 19: duplicate object key near '\"media\"'");
    import_finish(&f.base);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_medium_on_a_node_is_bounded_by_its_mesh),
        cmocka_unit_test(a_boundary_may_stay_visible),
        cmocka_unit_test(blender_writes_the_object_as_a_string),
        cmocka_unit_test(all_places_are_read_in_order),
        cmocka_unit_test(a_missing_with_file_is_an_error_a_missing_sidecar_is_not),
        cmocka_unit_test(coefficients_may_be_said_in_three_ways),
        cmocka_unit_test(phase_functions_are_named),
        cmocka_unit_test(mixtures_are_read),
        cmocka_unit_test(mixtures_out_of_order_are_refused),
        cmocka_unit_test(tables_become_lobes),
        cmocka_unit_test(tables_out_of_order_are_refused),
        cmocka_unit_test(boxes_may_be_said_in_three_ways),
        cmocka_unit_test(other_boundaries_are_planes_meshes_and_none),
        cmocka_unit_test(an_open_boundary_mesh_is_refused_with_file_and_place),
        cmocka_unit_test(layers_and_height_fog_follow_their_node),
        cmocka_unit_test(detail_is_fixed_in_its_node),
        cmocka_unit_test(bad_detail_is_refused),
        cmocka_unit_test(a_grid_without_a_boundary_is_bounded_by_its_own_box),
        cmocka_unit_test(a_grid_whose_name_holds_hashes_is_that_of_the_frame),
        cmocka_unit_test(without_a_frame_a_file_may_have_hashes_in_its_name),
        cmocka_unit_test(overlap_is_added_or_replaced),
        cmocka_unit_test(a_polygon_light_radiates_as_it_says),
        cmocka_unit_test(a_mirroring_node_keeps_the_front_of_a_polygon_light),
        cmocka_unit_test(a_light_without_area_is_refused_with_file_and_place),
        cmocka_unit_test(a_collimated_light_passes_its_windows),
        cmocka_unit_test(point_and_spot_lights_are_radiometric),
        cmocka_unit_test(an_environment_is_constant_or_an_image),
        cmocka_unit_test(the_environment_argument_is_a_constant_or_an_image),
        cmocka_unit_test(the_last_sidecars_camera_is_the_first_of_the_scene),
        cmocka_unit_test(a_lens_is_in_focus_where_the_camera_looks),
        cmocka_unit_test(bad_cameras_are_refused),
        cmocka_unit_test(flags_reach_the_objects_they_name),
        cmocka_unit_test(a_byte_order_mark_does_no_harm),
        cmocka_unit_test(unknown_keys_name_the_nearest_known_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
