#include "scene/media/field.h"

#include "scene/media/grid.h"

/* Heights above the base in scale heights: a + b t along the ray. */
typedef struct height_line {
    float a, b;
} height_line;

static height_line make_line(const air_medium *medium, air_vec3 origin, air_vec3 dir)
{
    const float inverse = medium->inverse_scale_height;
    return (height_line){(vec3_dot(medium->up, origin) - medium->base_height) * inverse,
                         vec3_dot(medium->up, dir) * inverse};
}

static float height_at(height_line line, float t)
{
    return line.b == 0.0f ? line.a : line.a + line.b * t; /* t may be INFINITY */
}

/* Integral of exp(-(a + b t)) over [t0, t1], where the height is positive. From the lower end on,
 * the density only falls. */
static float falling_depth(height_line line, float t0, float t1)
{
    const float lower = fmaxf(fminf(height_at(line, t0), height_at(line, t1)), 0.0f);
    const float density = expf(-lower);
    const float rise = fabsf(line.b);
    if (isinf(t1)) {
        return line.b > 0.0f ? density / line.b : density > 0.0f ? INFINITY : 0.0f;
    }
    const float length = t1 - t0, x = rise * length;
    /* (1 - exp(-x)) / x; below 1e-4 its expansion 1 - x/2 is off by less than x^2/6 < 2e-9 */
    const float mean = x > 1e-4f ? -expm1f(-x) / x : 1.0f - 0.5f * x;
    return density * length * mean;
}

float air_exponential_depth(const air_medium *medium, air_vec3 origin, air_vec3 dir, float t0,
                            float t1)
{
    const height_line line = make_line(medium, origin, dir);
    const float h0 = height_at(line, t0), h1 = height_at(line, t1);
    if (h0 <= 0.0f && h1 <= 0.0f) {
        return t1 - t0;
    }
    if (h0 >= 0.0f && h1 >= 0.0f) {
        return falling_depth(line, t0, t1);
    }
    const float cross = fminf(fmaxf(-line.a / line.b, t0), t1);
    return h0 < 0.0f ? (cross - t0) + falling_depth(line, cross, t1)
                     : falling_depth(line, t0, cross) + (t1 - cross);
}

float air_exponential_max(const air_medium *medium, air_vec3 origin, air_vec3 dir, float t0,
                          float t1)
{
    const height_line line = make_line(medium, origin, dir);
    return expf(-fmaxf(fminf(height_at(line, t0), height_at(line, t1)), 0.0f));
}

float air_exponential_piece(const air_medium *medium, air_vec3 origin, air_vec3 dir, float t0)
{
    const float nothing = 104.0f; /* exp(-104) is 0 in float */
    const height_line line = make_line(medium, origin, dir);
    const float h = height_at(line, t0), rise = fabsf(line.b);
    if (rise == 0.0f || (line.b < 0.0f && h <= 0.0f) || (line.b > 0.0f && h >= nothing)) {
        return INFINITY;
    }
    const float flat = line.b > 0.0f ? fmaxf(-h, 0.0f) : fmaxf(h - nothing, 0.0f);
    return fmaxf(t0 + (flat + 1.0f) / rise, t0 * (1.0f + 1e-6f));
}

static air_coefficients scaled(const air_medium *medium, float density)
{
    return (air_coefficients){vec3_scale(medium->sigma_s, density),
                              vec3_scale(medium->sigma_t, density),
                              vec3_scale(medium->emission, density)};
}

/* Of a medium with a density grid, where that has this value. */
static air_coefficients at_density(const air_medium *medium, air_vec3 point, air_vec3 density)
{
    air_coefficients out = {.sigma_t = vec3_mul(medium->sigma_t, density)};
    if (medium->albedo_grid != NULL) {
        const air_vec3 albedo =
            air_grid_lookup(medium->albedo_grid, affine_point(medium->world_to_albedo, point));
        out.sigma_s =
            vec3(out.sigma_t.x * fminf(albedo.x, 1.0f), out.sigma_t.y * fminf(albedo.y, 1.0f),
                 out.sigma_t.z * fminf(albedo.z, 1.0f));
    } else {
        out.sigma_s = vec3_mul(medium->sigma_s, density);
    }
    out.emission = vec3_mul(medium->emission, density);
    if (medium->emission_grid != NULL && !vec3_is_zero(medium->emission)) {
        out.emission =
            vec3_mul(out.emission, air_grid_lookup(medium->emission_grid,
                                                   affine_point(medium->world_to_emission, point)));
    }
    return out;
}

static air_coefficients grid_coefficients(const air_medium *medium, air_vec3 point)
{
    const air_vec3 density =
        air_grid_lookup(medium->density_grid, affine_point(medium->world_to_grid, point));
    if (vec3_is_zero(density)) {
        return (air_coefficients){vec3_set1(0.0f), vec3_set1(0.0f), vec3_set1(0.0f)};
    }
    return at_density(medium, point, density);
}

air_coefficients air_medium_full_coefficients(const air_medium *medium, air_vec3 point)
{
    const air_vec3 full = vec3_set1(1.0f);
    return medium->kind == AIR_DENSITY_GRID ? at_density(medium, point, full)
                                            : scaled(medium, 1.0f);
}

static air_coefficients plain_coefficients(const air_medium *medium, const air_region *region,
                                           air_vec3 point)
{
    switch (medium->kind) {
    case AIR_DENSITY_EXPONENTIAL: {
        const float height = vec3_dot(medium->up, point) - medium->base_height;
        return scaled(medium, expf(-fmaxf(height * medium->inverse_scale_height, 0.0f)));
    }
    case AIR_DENSITY_GRID:
        return grid_coefficients(medium, point);
    default:
        return scaled(medium, region->density);
    }
}

static air_coefficients with_factor(air_coefficients plain, float factor)
{
    return (air_coefficients){vec3_scale(plain.sigma_s, factor), vec3_scale(plain.sigma_t, factor),
                              vec3_scale(plain.emission, factor)};
}

/* Nothing is there, whatever the detail. */
static bool is_nothing(const air_coefficients *c)
{
    return vec3_is_zero(c->sigma_t) && vec3_is_zero(c->emission);
}

air_coefficients air_medium_coefficients(const air_medium *medium, const air_region *region,
                                         air_vec3 point)
{
    const air_coefficients plain = plain_coefficients(medium, region, point);
    if (!air_medium_is_detailed(medium) || is_nothing(&plain)) {
        return plain;
    }
    return with_factor(plain, air_detail_factor(&medium->detail, point, 0.0f));
}

void air_medium_coefficients_run(const air_medium *medium, const air_region *region,
                                 const air_vec3 *points, size_t count, float width_m,
                                 air_coefficients *out)
{
    air_vec3 places[AIR_LOOKS];
    float factors[AIR_LOOKS];
    size_t index[AIR_LOOKS], some = 0;
    const bool detailed = air_medium_is_detailed(medium);
    for (size_t i = 0; i < count; i++) {
        out[i] = plain_coefficients(medium, region, points[i]);
        if (detailed && !is_nothing(&out[i])) {
            places[some] = points[i];
            index[some++] = i;
        }
    }
    if (some > 0) {
        air_detail_factors(&medium->detail, places, some, width_m, factors);
    }
    for (size_t i = 0; i < some; i++) {
        out[index[i]] = with_factor(out[index[i]], factors[i]);
    }
}
