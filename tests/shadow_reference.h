/* shadow_reference.h: shadows of triangle meshes by the definition, in doubles and world space: the
 * wedge under every triangle, none left out. And pictures of a lit medium made with them. */
#ifndef AIR_TESTS_SHADOW_REFERENCE_H
#define AIR_TESTS_SHADOW_REFERENCE_H

#include "airlight/shadow.h"
#include "cmocka_test.h"
#include "collimated_fixture.h"
#include "shadow_wedge.h"

enum { MOST_SHADOWS = 4096 };

/* What air_shadow_tree_query is to find; out has room for MOST_SHADOWS. */
static inline size_t reference_shadows(const shadow_wedges *self, const double o[3],
                                       const double v[3], double begin, double end,
                                       air_interval *out)
{
    size_t count = 0;
    for (size_t i = 0; i < self->count; i++) {
        count += clip_to_wedge(&self->wedges[i], o, v, begin, end, &out[count]);
        if (count == MOST_SHADOWS) {
            count = air_intervals_join(out, count);
            assert_true(count < MOST_SHADOWS);
        }
    }
    return air_intervals_join(out, count);
}

/* Distance to the first triangle along the ray, INFINITY if there is none. */
static inline double first_surface(const air_shadow_mesh *meshes, size_t mesh_count,
                                   const double o[3], const double v[3])
{
    double nearest = INFINITY;
    for (size_t m = 0; m < mesh_count; m++) {
        for (size_t i = 0; i < meshes[m].triangle_count; i++) {
            double p[3][3], u[3], w[3], n[3], d[3], c[3];
            triangle_corners(&meshes[m], i, p);
            subtract(p[1], p[0], u);
            subtract(p[2], p[0], w);
            subtract(o, p[0], d);
            cross(v, w, n);
            const double det = dot(u, n), size = fabs(det), turn = det < 0.0 ? -1.0 : 1.0;
            const double a = turn * dot(d, n);
            if (a < 0.0 || a > size) {
                continue;
            }
            cross(d, u, c);
            const double b = turn * dot(v, c), t = turn * dot(w, c);
            if (b >= 0.0 && a + b <= size && t > 0.0 && t < nearest * size) {
                nearest = t / size;
            }
        }
    }
    return nearest;
}

/* ---- pictures ---- */

enum { WIDTH = 40, HEIGHT = 30, PIXELS = WIDTH * HEIGHT };

/* A box of fog about meshes, and rays through it, each with its stretch inside the fog (empty where
 * there is none). */
typedef struct foggy_scene {
    double low[3], high[3], sigma_t, to_light[3];
    const air_shadow_mesh *meshes;
    size_t mesh_count;
    size_t ray_count;
    double origin[PIXELS][3], dir[PIXELS][3];
    air_interval stretch[PIXELS];
} foggy_scene;

static inline air_shadow_tree *make_tree(air_context *context, const foggy_scene *scene,
                                         const air_shadow_tree_params *base)
{
    double hull[8][3];
    air_shadow_tree_params params;
    air_shadow_tree *tree;
    air_shadow_tree_params_default(&params);
    params = base != NULL ? *base : params;
    for (int i = 0; i < 8; i++) {
        for (int k = 0; k < 3; k++) {
            hull[i][k] = (i >> k & 1) != 0 ? scene->high[k] : scene->low[k];
        }
    }
    memcpy(params.to_light, scene->to_light, sizeof params.to_light);
    params.hull = hull[0];
    params.hull_count = 8;
    assert_int_equal(
        air_shadow_tree_create(context, &params, scene->meshes, scene->mesh_count, &tree), AIR_OK);
    return tree;
}

/* Sets a ray's stretch: to the first surface, or through everything. */
static inline void set_ray(foggy_scene *scene, size_t i, const double origin[3],
                           const double dir[3], bool through)
{
    const air_collimated_medium fog = box_between(scene->low, scene->high);
    const double t_max =
        through ? INFINITY : first_surface(scene->meshes, scene->mesh_count, origin, dir);
    memcpy(scene->origin[i], origin, sizeof scene->origin[i]);
    memcpy(scene->dir[i], dir, sizeof scene->dir[i]);
    scene->stretch[i] = (air_interval){0.0, 0.0};
    (void)air_collimated_interval(&fog, origin, dir, t_max, &scene->stretch[i]);
}

/* Rays through the centres of width x height pixels; every other one goes on behind the first
 * surface. */
static inline void set_camera(foggy_scene *scene, const double eye[3], const double towards[3],
                              double fov_deg, size_t width, size_t height)
{
    double f[3], r[3], u[3], up[3] = {0.0, 1.0, 0.0};
    memcpy(f, towards, sizeof f);
    normalise(f);
    if (fabs(f[1]) > 0.999) {
        up[1] = 0.0;
        up[2] = 1.0;
    }
    cross(f, up, r);
    normalise(r);
    cross(r, f, u);
    const double half = tan(0.5 * fov_deg * acos(-1.0) / 180.0);
    scene->ray_count = width * height;
    for (size_t i = 0; i < scene->ray_count; i++) {
        const double x = (2.0 * ((double)(i % width) + 0.5) - (double)width) / (double)height;
        const double y = 1.0 - 2.0 * ((double)(i / width) + 0.5) / (double)height;
        double v[3];
        for (int k = 0; k < 3; k++) {
            v[k] = f[k] + half * (x * r[k] + y * u[k]);
        }
        normalise(v);
        set_ray(scene, i, eye, v, i % 2 == 1);
    }
}

/* The light of a ray's lit stretches. */
static inline double light_between(const foggy_scene *scene, size_t i, const air_interval *shadows,
                                   size_t count)
{
    static air_interval lit[MOST_SHADOWS + 1];
    const air_collimated_medium fog = box_between(scene->low, scene->high);
    roomy_profile room;
    double sum = 0.0;
    const size_t gaps =
        air_intervals_gaps(shadows, count, scene->stretch[i].begin, scene->stretch[i].end, lit);
    air_collimated_profile_make(&fog, scene->to_light, scene->sigma_t, scene->origin[i],
                                scene->dir[i], INFINITY, roomy(&room));
    for (size_t k = 0; k < gaps; k++) {
        sum += air_collimated_partial_integral(&room.profile, lit[k].begin, lit[k].end);
    }
    return sum;
}

/* The picture by the tree, or by the reference where tree is NULL. */
static inline void make_picture(const foggy_scene *scene, const air_shadow_tree *tree,
                                double out[PIXELS])
{
    static air_interval shadows[MOST_SHADOWS];
    shadow_wedges wedges = {0};
    if (tree == NULL) {
        wedges = make_wedges(scene->meshes, scene->mesh_count, scene->to_light);
        assert_non_null(wedges.wedges);
    }
    for (size_t i = 0; i < scene->ray_count; i++) {
        const air_interval *s = &scene->stretch[i];
        const double *o = scene->origin[i], *v = scene->dir[i];
        size_t count = tree == NULL ? reference_shadows(&wedges, o, v, s->begin, s->end, shadows)
                                    : air_shadow_tree_query(tree, o, v, s->begin, s->end, shadows,
                                                            MOST_SHADOWS);
        assert_true(count <= MOST_SHADOWS);
        out[i] = s->begin < s->end ? light_between(scene, i, shadows, count) : 0.0;
    }
    free(wedges.wedges);
}

/* PSNR in dB over the peak of the reference. A black reference has no peak: the picture then has to
 * be black within 5e-9 of the fog's diagonal D, which is less than the rounding of a float at its
 * corners, 2^-24 D/2 = 3e-8 D: no stretch of light may have been made up. */
static inline double picture_psnr(const foggy_scene *scene, const double reference[PIXELS],
                                  const double picture[PIXELS])
{
    double peak = 0.0, sum = 0.0, worst = 0.0, diagonal[3];
    subtract(scene->high, scene->low, diagonal);
    for (size_t i = 0; i < scene->ray_count; i++) {
        const double error = fabs(picture[i] - reference[i]);
        assert_true(error >= 0.0); /* not NaN */
        peak = fmax(peak, reference[i]);
        worst = fmax(worst, error);
        sum += error * error;
    }
    /* slivers of light between the reference's own wedges, 1e-16 of the fog each, are no light */
    if (peak < 1e-12 * sqrt(dot(diagonal, diagonal))) {
        return worst <= 5e-9 * sqrt(dot(diagonal, diagonal)) ? INFINITY : -INFINITY;
    }
    return -10.0 * log10(sum / (double)scene->ray_count / (peak * peak));
}

#endif
