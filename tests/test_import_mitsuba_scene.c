/* Where things of a scene file come to lie: sensors, shapes and lights, by geometry alone. */
#include "core/vec.h"
#include "mitsuba_fixture.h"
#include "scene/lights/environment.h"

#define RADIAN (AIR_PI_F / 180.0f)

/* ---- sensors ---- */

/* A sensor at (1,2,3) that looks along +X with +Z up. What airlight's camera has to the right is
 * the cross product of both. */
static void sensors_look_at_their_target(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "0.6.0",
                  "<sensor type='perspective' id='eye'><transform name='toWorld'>"
                  "<lookAt origin='1,2,3' target='5,2,3' up='0,0,2'/></transform></sensor>");
    const float *m = mitsuba_camera(self, 0)->to_world;
    assert_string_equal(mitsuba_camera(self, 0)->name, "eye");
    assert_floats(m, 12, (const float[]){0, 0, -1, 1, -1, 0, 0, 2, 0, 1, 0, 3});
}

/* What a sensor with x scaled by -1 has to its left, an unmirrored one has to its right: rays
 * through pixels as far from either edge are the same. */
static void mirrored_sensors_mirror(void **state)
{
    import_fixture *self = *state;
    const char *scale[] = {"", "<scale x='-1'/>"};
    air_vec3 dirs[2], origin;
    for (size_t i = 0; i < 2; ++i) {
        char inside[400];
        snprintf(inside, sizeof inside,
                 "<sensor type='perspective'><transform name='to_world'>%s"
                 "<lookat origin='1 2 3' target='4 6 8' up='0 1 0'/></transform></sensor>",
                 scale[i]);
        mitsuba_loads(self, "3.0.0", inside);
        assert_int_equal(air_scene_commit(self->scene, &self->snapshot, NULL), AIR_OK);
        air_camera_ray(&self->snapshot->cameras[0], 64, 48, i == 0 ? 10.0f : 54.0f, 7.0f, &origin,
                       &dirs[i]);
        assert_true(mitsuba_camera(self, 0)->mirrored == (i == 1));
        /* and again through the description of the snapshot */
        air_camera_desc desc;
        assert_int_equal(air_snapshot_camera_desc(self->snapshot, AIR_NONE, &desc), AIR_OK);
        air_handle handle = AIR_NONE;
        assert_int_equal(air_scene_add_camera(self->scene, &desc, &handle), AIR_OK);
        assert_floats(mitsuba_camera(self, 1)->to_world, 12, mitsuba_camera(self, 0)->to_world);
    }
    assert_true(vec3_length(vec3_sub(dirs[0], dirs[1])) < 1e-6f);
}

/* tan(fov_y / 2) of 39.3077 degrees across 800 x 600: by the definition of each axis. */
static void fields_of_view_are_those_of_their_axis(void **state)
{
    import_fixture *self = *state;
    const char *axes[] = {"x", "y", "diagonal", "smaller", "larger"};
    const float t = tanf(0.5f * 39.3077f * RADIAN), aspect = 4.0f / 3.0f;
    const float expected[] = {t / aspect, t, t * 0.6f, t, t / aspect}; /* 0.6: 3 of 3, 4, 5 */
    for (size_t i = 0; i < 5; ++i) {
        char inside[400];
        snprintf(inside, sizeof inside,
                 "<sensor type='perspective'><float name='fov' value='39.3077'/>"
                 "<string name='fov_axis' value='%s'/><film type='hdrfilm'>"
                 "<integer name='width' value='800'/><integer name='height' value='600'/></film>"
                 "</sensor>",
                 axes[i]);
        mitsuba_loads(self, "3.0.0", inside);
        const float tangent = tanf(0.5f * mitsuba_camera(self, 0)->fov_y_rad);
        assert_floats(&tangent, 1, &expected[i]);
    }
    /* 36 mm by 24 mm of film behind 50 mm, its diagonal spread over 4 : 3 */
    mitsuba_loads(self, "3.0.0", "<sensor type='perspective'/>");
    const float tangent = tanf(0.5f * mitsuba_camera(self, 0)->fov_y_rad);
    const float whole = sqrtf(36.0f * 36.0f + 24.0f * 24.0f) / 100.0f * 0.6f;
    assert_floats(&tangent, 1, &whole);
}

static void films_are_kept(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "0.5.0",
                  "<sensor type='thinlens'><float name='apertureRadius' value='.1'/>"
                  "<float name='focusDistance' value='3'/>"
                  "<sampler type='ldsampler'><integer name='sampleCount' value='9'/></sampler>"
                  "<film type='hdrfilm'><integer name='width' value='80'/>"
                  "<integer name='height' value='60'/><integer name='cropOffsetX' value='10'/>"
                  "<integer name='cropWidth' value='20'/><integer name='cropOffsetY' value='5'/>"
                  "<rfilter type='gaussian'><float name='stddev' value='.4'/></rfilter>"
                  "</film></sensor>");
    const air_camera_desc *desc = mitsuba_camera(self, 0);
    const air_film_hint *film = &desc->film;
    assert_true(desc->lens_radius == 0.1f && desc->focus_distance == 3.0f);
    assert_true(film->known && film->width == 80 && film->height == 60 && film->samples == 9);
    assert_true(film->crop[0] == 10 && film->crop[1] == 5 && film->crop[2] == 30);
    assert_int_equal(film->crop[3], 60);
    assert_int_equal(film->filter, AIR_FILTER_GAUSSIAN);
    assert_floats(&film->filter_radius, 1, (const float[]){1.2f}); /* 3 standard deviations */
    mitsuba_loads(self, "3.0.0", "<sensor type='perspective'/>");
    film = &mitsuba_camera(self, 0)->film;
    assert_true(film->width == 768 && film->height == 576 && film->samples == 4);
    assert_int_equal(film->filter, AIR_FILTER_GAUSSIAN);
}

/* x from -1 to 1, scaled by 3, over a picture of 2 : 1. */
static void orthographic_sensors_see_their_scale(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "3.0.0",
                  "<sensor type='orthographic'><transform name='to_world'><scale x='3' y='3'/>"
                  "</transform><film type='hdrfilm'><integer name='width' value='20'/>"
                  "<integer name='height' value='10'/></film></sensor>");
    assert_int_equal(mitsuba_camera(self, 0)->kind, AIR_CAMERA_ORTHOGRAPHIC);
    assert_floats(&mitsuba_camera(self, 0)->half_height, 1, (const float[]){1.5f});
}

/* ---- transformations ---- */

/* Each operation after the one before: (1,0,0) doubled, turned to (0,2,0), moved to (0,2,5). */
static void operations_come_one_after_the_other(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "3.0.0",
                  "<shape type='cube'><transform name='to_world'><scale value='2'/>"
                  "<rotate z='3' angle='90'/><translate z='5'/></transform></shape>");
    const float *m = mitsuba_mesh(self, 0)->to_world;
    assert_floats(m, 12, (const float[]){0, -2, 0, 0, 2, 0, 0, 0, 0, 0, 2, 5});
    mitsuba_loads(self, "3.0.0",
                  "<shape type='cube'><transform name='to_world'>"
                  "<matrix value='1 2 3 4 0 1 0 5, 0 0 1 6 0 0 0 1'/></transform></shape>");
    assert_floats(mitsuba_mesh(self, 0)->to_world, 12,
                  (const float[]){1, 2, 3, 4, 0, 1, 0, 5, 0, 0, 1, 6});
    mitsuba_loads(
        self, "3.0.0",
        "<shape type='cube'><transform name='to_world'><matrix value='1 2 3 0 1 0 0 0 1'/>"
        "</transform></shape>");
    assert_floats(mitsuba_mesh(self, 0)->to_world, 12,
                  (const float[]){1, 2, 3, 0, 0, 1, 0, 0, 0, 0, 1, 0});
}

static void bad_transformations_are_refused(void **state)
{
    import_fixture *self = *state;
    mitsuba_refuses(self, "3.0.0",
                    "<shape type='cube'><transform name='to_world'><translat x='2'/></transform>"
                    "</shape>",
                    "line 2: <translat>: expected translate, rotate, scale, lookat or matrix; did "
                    "you mean <translate>?");
    mitsuba_refuses(self, "3.0.0",
                    "<shape type='cube'><transform name='to_world'><scale x='0'/></transform>"
                    "</shape>",
                    "line 2: <shape type=\"cube\">: to_world scales the shape to nothing");
    mitsuba_refuses(self, "3.0.0",
                    "<shape type='cube'><transform name='to_world'><rotate angle='5'/></transform>"
                    "</shape>",
                    "line 2: <rotate>: expected an axis that is not 0");
    mitsuba_refuses(self, "3.0.0",
                    "<shape type='cube'><transform name='to_world'>"
                    "<lookat origin='0 0 0' target='0 1 0' up='0 1 0'/></transform></shape>",
                    "line 2: <lookat>: expected up not to be parallel to the direction of view");
}

/* ---- shapes ---- */

/* All normals of a cube point out of it, also those of its triangles. */
static void cubes_face_outwards(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "3.0.0", "<shape type='cube'/>");
    const air_geometry *cube = mitsuba_mesh(self, 0)->geometry;
    assert_int_equal(cube->triangle_count, 12);
    for (size_t t = 0; t < 12; ++t) {
        const uint32_t *i = cube->indices + 3 * t;
        const air_vec3 a = vec3_load(cube->positions + 3 * i[0]);
        const air_vec3 b = vec3_load(cube->positions + 3 * i[1]);
        const air_vec3 c = vec3_load(cube->positions + 3 * i[2]);
        const air_vec3 n = vec3_cross(vec3_sub(b, a), vec3_sub(c, a));
        assert_true(vec3_dot(n, a) > 0.0f);
        assert_floats(&(float){vec3_dot(n, vec3_load(cube->normals + 3 * i[1]))}, 1,
                      (const float[]){4.0f}); /* twice the area of half a face */
    }
}

/* (-1,-1) has (0,0) and (1,1) has (1,1); turned over it faces -Z. */
static void rectangles_have_their_coordinates(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "3.0.0",
                  "<shape type='rectangle'/><shape type='rectangle'>"
                  "<boolean name='flip_normals' value='true'/></shape>");
    for (size_t k = 0; k < 2; ++k) {
        const air_geometry *mesh = mitsuba_mesh(self, k)->geometry;
        for (size_t i = 0; i < 4; ++i) {
            const float *p = mesh->positions + 3 * i;
            assert_floats(mesh->uv[0] + 2 * i, 2,
                          (const float[]){0.5f * (p[0] + 1.0f), 0.5f * (p[1] + 1.0f)});
            assert_true(mesh->normals[3 * i + 2] == (k == 0 ? 1.0f : -1.0f));
        }
    }
}

/* The unit quadric's points through to_world: centre and pole of the sphere, ends of the cylinder.
 */
static void quadrics_lie_where_they_say(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "0.6.0",
                  "<shape type='sphere'><point name='center' x='1' y='2' z='3'/>"
                  "<float name='radius' value='2'/><transform name='toWorld'><translate x='10'/>"
                  "</transform><boolean name='flipNormals' value='true'/></shape>"
                  "<shape type='cylinder'><point name='p0' value='1 1 1'/>"
                  "<point name='p1' value='1 4 1'/><float name='radius' value='.5'/></shape>"
                  "<shape type='disk'><transform name='toWorld'><scale x='-1'/></transform>"
                  "</shape>");
    const air_mesh_record *sphere = mitsuba_mesh(self, 0), *cylinder = mitsuba_mesh(self, 1);
    float p[3];
    vec3_store(p, affine_point(sphere->to_world, vec3(0, 0, 1)));
    assert_floats(p, 3, (const float[]){11, 2, 5});
    vec3_store(p, affine_point(cylinder->to_world, vec3(0, 0, 0)));
    assert_floats(p, 3, (const float[]){1, 1, 1});
    vec3_store(p, affine_point(cylinder->to_world, vec3(0, 0, 1)));
    assert_floats(p, 3, (const float[]){1, 4, 1});
    const float reach =
        vec3_length(affine_vector(cylinder->to_world, vec3(cosf(1.0f), sinf(1.0f), 0.0f)));
    assert_floats(&reach, 1, (const float[]){0.5f});
    assert_int_equal(mitsuba_count(self, AIR_OBJECT_MESH), 3);
}

static const char triangle_obj[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n"
                                   "f 1/1 2/2 3/3\n";

/* OBJ's v runs upwards and is turned, unless the file is said to be otherwise. */
static void meshes_come_from_files(void **state)
{
    import_fixture *self = *state;
    import_serve(self, "scenes/models/a.obj", triangle_obj, sizeof triangle_obj - 1);
    mitsuba_loads(self, "3.0.0",
                  "<shape type='obj'><string name='filename' value='models/a.obj'/></shape>"
                  "<shape type='obj'><string name='filename' value='models/a.obj'/>"
                  "<boolean name='flip_tex_coords' value='false'/>"
                  "<boolean name='face_normals' value='true'/></shape>");
    const air_geometry *turned = mitsuba_mesh(self, 0)->geometry;
    const air_geometry *plain = mitsuba_mesh(self, 1)->geometry;
    assert_floats(turned->uv[0], 6, (const float[]){0, 1, 1, 1, 0, 0});
    assert_floats(plain->uv[0], 6, (const float[]){0, 0, 1, 0, 0, 1});
    assert_floats(turned->normals, 3, (const float[]){0, 0, 1});
    assert_null(plain->normals);
    mitsuba_refuses(self, "3.0.0", "<shape type='obj'/>",
                    "line 2: <shape type=\"obj\">: expected the parameter filename");
}

/* A file whose normals point to the back of its triangle: its front is where they point. */
static void normals_say_where_the_front_is(void **state)
{
    import_fixture *self = *state;
    const char *obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 -1\nf 1//1 2//1 3//1\n";
    import_serve(self, "scenes/a.obj", obj, strlen(obj));
    mitsuba_loads(self, "3.0.0",
                  "<shape type='obj'><string name='filename' value='a.obj'/></shape>");
    const air_geometry *mesh = mitsuba_mesh(self, 0)->geometry;
    air_vec3 p[3];
    for (size_t i = 0; i < 3; ++i)
        p[i] = vec3_load(mesh->positions + 3 * (size_t)mesh->indices[i]);
    assert_true(vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[2], p[0])).z < 0.0f);
}

static void instances_are_copies(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "3.0.0",
                  "<shape type='shapegroup' id='pair'><shape type='cube'/><shape type='rectangle'>"
                  "<transform name='to_world'><translate x='1'/></transform></shape></shape>"
                  "<shape type='instance'><ref id='pair'/></shape>"
                  "<shape type='instance' id='far'><ref id='pair'/><transform name='to_world'>"
                  "<scale value='2'/><translate y='9'/></transform></shape>");
    assert_int_equal(mitsuba_count(self, AIR_OBJECT_MESH), 4);
    assert_floats(mitsuba_mesh(self, 3)->to_world, 12,
                  (const float[]){2, 0, 0, 2, 0, 2, 0, 9, 0, 0, 2, 0});
    assert_string_equal(mitsuba_mesh(self, 3)->base.name, "far");
}

/* Sidecars know shapes by their id. */
static void sidecars_name_shapes(void **state)
{
    import_fixture *self = *state;
    const char *sidecar = "{\"objects\": {\"lid\": {\"camera_visible\": false}}, \"media\": "
                          "[{\"sigma_s\": 1, \"boundary\": {\"mesh\": \"box\"}}]}";
    import_serve(self, "scenes/room.airlight.json", sidecar, strlen(sidecar));
    mitsuba_loads(self, "3.0.0", "<shape type='cube' id='box'/><shape type='rectangle' id='lid'/>");
    assert_int_equal(mitsuba_count(self, AIR_OBJECT_MESH), 1);
    assert_false(mitsuba_mesh(self, 0)->camera_visible);
    assert_int_equal(mitsuba_count(self, AIR_OBJECT_MEDIUM), 1);
}

/* ---- lights ---- */

static void lights_shine_where_they_say(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(
        self, "3.0.0",
        "<emitter type='point'><point name='position' x='1' y='2' z='3'/>"
        "<rgb name='intensity' value='1 2 3'/></emitter>"
        "<emitter type='spot'><float name='cutoff_angle' value='40'/>"
        "<transform name='to_world'><lookat origin='0 5 0' target='0 0 0' up='1 0 0'/>"
        "</transform></emitter>"
        "<emitter type='directional'><vector name='direction' x='1' z='-1'/>"
        "<float name='irradiance' value='5'/></emitter>"
        "<emitter type='directional'><transform name='to_world'><rotate x='1' angle='90'/>"
        "</transform></emitter>"
        "<emitter type='constant'><spectrum name='radiance' value='.5'/></emitter>");
    assert_floats(mitsuba_light(self, 0)->position, 3, (const float[]){1, 2, 3});
    assert_floats(mitsuba_light(self, 0)->color, 3, (const float[]){1, 2, 3});
    const air_light_desc *spot = mitsuba_light(self, 1);
    assert_int_equal(spot->falloff, AIR_SPOT_ANGLE);
    assert_floats(spot->dir, 3, (const float[]){0, -1, 0});
    assert_floats(&spot->outer_cone_rad, 1, (const float[]){40.0f * RADIAN});
    assert_floats(&spot->inner_cone_rad, 1, (const float[]){30.0f * RADIAN});
    assert_floats(mitsuba_light(self, 2)->color, 3, (const float[]){5, 5, 5});
    assert_true(mitsuba_light(self, 2)->dir[2] < 0.0f);
    assert_floats(mitsuba_light(self, 3)->dir, 3, (const float[]){0, -1, 0});
    assert_int_equal(mitsuba_light(self, 4)->kind, AIR_LIGHT_ENVIRONMENT);
    assert_floats(mitsuba_light(self, 4)->color, 3, (const float[]){0.5f, 0.5f, 0.5f});
}

/* What is 1 at all wavelengths is white as a reflectance, and has luminance 1 as a light; 6500 K is
 * redder than 10000 K. */
static void colours_come_in_all_forms(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(
        self, "0.6.0",
        "<emitter type='point'><spectrum name='intensity' value='300:1, 900:1'/></emitter>"
        "<emitter type='point'><blackbody name='intensity' temperature='6500K'/></emitter>"
        "<emitter type='point'><blackbody name='intensity' temperature='10000' "
        "scale='2'/></emitter>"
        "<emitter type='point'><srgb name='intensity' value='1, 0.5, 0.04045'/></emitter>"
        "<shape type='cube'><bsdf type='diffuse'>"
        "<spectrum name='reflectance' value='300:.5 900:.5'/></bsdf></shape>");
    /* the observer's table ends within the interval given: rounding only */
    assert_true(fabsf(vec3_luminance(vec3_load(mitsuba_light(self, 0)->color)) - 1.0f) < 1e-3f);
    const float *warm = mitsuba_light(self, 1)->color, *cold = mitsuba_light(self, 2)->color;
    assert_true(warm[0] > 0.0f && warm[0] / warm[2] > cold[0] / cold[2]);
    assert_floats(mitsuba_light(self, 3)->color, 3,
                  (const float[]){1.0f, 0.21404114f, 0.04045f / 12.92f});
    for (size_t i = 0; i < 3; ++i) /* D65 of the integral against that of the matrix: 0.11 % */
        assert_true(fabsf(mitsuba_material(self, 0)->base_color[i] - 0.5f) < 2e-3f);
}

/* A collimated beam from a window: its corners and the way it faces. */
static void windows_send_beams(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "3.0.0",
                  "<shape type='rectangle' id='w'><transform name='to_world'><scale x='2'/>"
                  "<rotate x='1' angle='90'/></transform><emitter type='directionalarea'>"
                  "<float name='radiance' value='3'/></emitter></shape>");
    const air_light_desc *beam = mitsuba_light(self, 0);
    assert_int_equal(beam->kind, AIR_LIGHT_COLLIMATED);
    assert_floats(beam->dir, 3, (const float[]){0, -1, 0});
    assert_int_equal(beam->window_count, 1);
    assert_floats(beam->windows[0].vertices, 12,
                  (const float[]){-2, 0, -1, 2, 0, -1, 2, 0, 1, -2, 0, 1});
    assert_false(mitsuba_mesh(self, 0)->casts_shadow);
    mitsuba_refuses(self, "3.0.0", "<shape type='cube'><emitter type='directionalarea'/></shape>",
                    "line 2: <emitter type=\"directionalarea\">: directionalarea is supported for "
                    "rectangles only (--lenient: the shape does not shine)");
}

/* Mitsuba: u = atan2(x, -z) / (2 pi), so that u = 1/4 is +X, 1/2 is +Z and 3/4 is -X, and v = 0 is
 * +Y. Columns of a picture 4 wide have these in their middles after a turn by an eighth. */
static void environments_keep_mitsubas_directions(void **state)
{
    import_fixture *self = *state;
    /* a PFM of 4 x 2 texels: the upper row red 1, 2, 3, 4; rows go from the bottom up */
    static uint8_t pfm[16 + 96];
    const char *header = "PF\n4 2\n-1.0\n";
    const size_t length = strlen(header);
    float texels[24] = {0.0f};
    for (size_t i = 0; i < 4; ++i)
        texels[12 + 3 * i] = (float)i + 1.0f;
    memcpy(pfm, header, length);
    memcpy(pfm + length, texels, sizeof texels);
    import_serve(self, "scenes/sky.pfm", pfm, length + sizeof texels);
    mitsuba_loads(self, "3.0.0",
                  "<emitter type='envmap'><string name='filename' value='sky.pfm'/>"
                  "<float name='scale' value='2'/></emitter>");
    assert_int_equal(air_scene_commit(self->scene, &self->snapshot, NULL), AIR_OK);
    const air_light *light = &self->snapshot->lights.entries[0];
    for (size_t i = 0; i < 4; ++i) {
        /* the middle of texel i of the upper row: u = (i + 1/2) / 4, v = 1/4 */
        const float phi = ((float)i + 0.5f) * 0.5f * AIR_PI_F;
        const float s = sqrtf(0.5f);
        const air_vec3 dir = vec3(s * sinf(phi), s, -s * cosf(phi));
        const float red = air_environment_radiance(light, dir).x;
        /* the angle goes through atan2 and back: rounding moves it by 1e-6 of a texel at most */
        assert_true(fabsf(red - 2.0f * ((float)i + 1.0f)) < 1e-4f);
    }
}

/* A picture of 2 x 1 from (0,0,5) towards the origin. A sensor in its place would have +X to the
 * right; over all of its width there are 60 degrees. */
static void projectors_throw_their_picture(void **state)
{
    import_fixture *self = *state;
    static uint8_t pfm[64];
    const char *header = "PF\n2 1\n-1.0\n";
    const float texels[6] = {1, 1, 1, 3, 3, 3};
    memcpy(pfm, header, strlen(header));
    memcpy(pfm + strlen(header), texels, sizeof texels);
    import_serve(self, "scenes/slide.pfm", pfm, strlen(header) + sizeof texels);
    mitsuba_loads(self, "3.0.0",
                  "<emitter type='projector'><texture name='irradiance' type='bitmap'>"
                  "<string name='filename' value='slide.pfm'/></texture>"
                  "<float name='scale' value='2'/><float name='fov' value='60'/>"
                  "<transform name='to_world'><lookat origin='0 0 5' target='0 0 0' up='0 1 0'/>"
                  "</transform></emitter>");
    const air_light_desc *desc = mitsuba_light(self, 0);
    assert_int_equal(desc->kind, AIR_LIGHT_PROJECTOR);
    assert_floats(desc->color, 1, (const float[]){2.0f * AIR_PI_F});
    assert_floats(&desc->fov_x_rad, 1, (const float[]){60.0f * RADIAN});
    assert_floats(desc->position, 3, (const float[]){0, 0, 5});
    assert_floats(desc->to_world, 9, (const float[]){1, 0, 0, 0, 1, 0, 0, 0, 1});
}

static void skies_have_a_sun(void **state)
{
    import_fixture *self = *state;
    mitsuba_loads(self, "0.6.0",
                  "<emitter type='sunsky'><vector name='sunDirection' x='0' y='1' z='1'/>"
                  "<integer name='resolution' value='16'/></emitter>");
    assert_int_equal(mitsuba_count(self, AIR_OBJECT_LIGHT), 2);
    import_expect_silence(self, AIR_MESSAGE_WARNING);
    assert_int_equal(mitsuba_light(self, 0)->kind, AIR_LIGHT_ENVIRONMENT);
    assert_string_equal(mitsuba_light(self, 0)->name, "sky");
    const air_light_desc *sun = mitsuba_light(self, 1);
    assert_string_equal(sun->name, "sun");
    assert_int_equal(sun->kind, AIR_LIGHT_COLLIMATED);
    assert_true(sun->dir[1] < 0.0f && sun->dir[2] < 0.0f && sun->color[0] > 0.0f);
    mitsuba_loads(self, "0.6.0",
                  "<emitter type='sky'><integer name='resolution' value='16'/></emitter>");
    assert_int_equal(mitsuba_count(self, AIR_OBJECT_LIGHT), 1);
    mitsuba_refuses(self, "0.6.0",
                    "<emitter type='sky'><integer name='year' value='1000000000'/></emitter>",
                    "line 2: <emitter type=\"sky\">: expected year to be 1 to 9999, found "
                    "1000000000");
    mitsuba_loads(self, "0.6.0",
                  "<emitter type='sunsky' id='day'><integer name='resolution' value='16'/>"
                  "<float name='sunRadiusScale' value='18.5'/></emitter>");
    assert_string_equal(mitsuba_light(self, 0)->name, "day.sky");
    assert_string_equal(mitsuba_light(self, 1)->name, "day.sun");
    import_expect(self, AIR_MESSAGE_WARNING,
                  "line 2: <emitter type=\"sunsky\" id=\"day\">: the sun is taken without extent: "
                  "sun_radius_scale 18.5 would make its shadows soft");
}

static void suns_need_a_day_and_a_place(void **state)
{
    import_fixture *self = *state;
    mitsuba_refuses(self, "0.6.0",
                    "<emitter type='sun'><integer name='month' value='13'/></emitter>",
                    "line 2: <emitter type=\"sun\">: expected month to be 1 to 12, found 13");
    mitsuba_refuses(self, "0.6.0",
                    "<emitter type='sun'><vector name='sunDirection' x='0' y='0' z='0'/></emitter>",
                    "line 2: <emitter type=\"sun\">: expected a sun_direction that is not 0");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(sensors_look_at_their_target, set_up, tear_down),
        cmocka_unit_test_setup_teardown(mirrored_sensors_mirror, set_up, tear_down),
        cmocka_unit_test_setup_teardown(fields_of_view_are_those_of_their_axis, set_up, tear_down),
        cmocka_unit_test_setup_teardown(films_are_kept, set_up, tear_down),
        cmocka_unit_test_setup_teardown(orthographic_sensors_see_their_scale, set_up, tear_down),
        cmocka_unit_test_setup_teardown(operations_come_one_after_the_other, set_up, tear_down),
        cmocka_unit_test_setup_teardown(bad_transformations_are_refused, set_up, tear_down),
        cmocka_unit_test_setup_teardown(cubes_face_outwards, set_up, tear_down),
        cmocka_unit_test_setup_teardown(rectangles_have_their_coordinates, set_up, tear_down),
        cmocka_unit_test_setup_teardown(quadrics_lie_where_they_say, set_up, tear_down),
        cmocka_unit_test_setup_teardown(meshes_come_from_files, set_up, tear_down),
        cmocka_unit_test_setup_teardown(normals_say_where_the_front_is, set_up, tear_down),
        cmocka_unit_test_setup_teardown(instances_are_copies, set_up, tear_down),
        cmocka_unit_test_setup_teardown(sidecars_name_shapes, set_up, tear_down),
        cmocka_unit_test_setup_teardown(lights_shine_where_they_say, set_up, tear_down),
        cmocka_unit_test_setup_teardown(colours_come_in_all_forms, set_up, tear_down),
        cmocka_unit_test_setup_teardown(windows_send_beams, set_up, tear_down),
        cmocka_unit_test_setup_teardown(environments_keep_mitsubas_directions, set_up, tear_down),
        cmocka_unit_test_setup_teardown(projectors_throw_their_picture, set_up, tear_down),
        cmocka_unit_test_setup_teardown(skies_have_a_sun, set_up, tear_down),
        cmocka_unit_test_setup_teardown(suns_need_a_day_and_a_place, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
