#include "atlas/outliers.h"

#include <math.h>

#include "core/vec.h"

/* REACH: texels on each side that one is held against. */
enum { REACH = 2, LEAST_OTHERS = 8, SHARE = 6 };

/* The texels [first, end) about a place that are on the page. */
typedef struct window {
    size_t first[2], end[2];
} window;

static window window_about(const air_outlier_surface *s, size_t texel, size_t reach)
{
    const size_t at[2] = {texel % s->width, texel / s->width}, size[2] = {s->width, s->height};
    window w;
    for (int k = 0; k < 2; k++) {
        w.first[k] = at[k] > reach ? at[k] - reach : 0;
        w.end[k] = at[k] + reach + 1 < size[k] ? at[k] + reach + 1 : size[k];
    }
    return w;
}

bool air_outlier_is(const air_outlier_surface *surface, const float *values, const float *variance,
                    size_t texel)
{
    const float value = values[texel], own = variance[texel];
    const window w = window_about(surface, texel, REACH);
    size_t count = 0, near = 0;
    float sum = 0.0f;
    if (!(own > 0.0f) || surface->charts[texel] == AIR_NO_CHART) {
        return false;
    }
    for (size_t y = w.first[1]; y < w.end[1]; y++) {
        for (size_t x = w.first[0]; x < w.end[0]; x++) {
            const size_t i = y * surface->width + x;
            const float more = value - values[i], noise = 9.0f * variance[i];
            if (i == texel || surface->charts[i] != surface->charts[texel]) {
                continue;
            }
            count++;
            if (more > 0.0f && more * more > noise && own > 4.0f * variance[i]) {
                sum += more;
            } else if (++near > (2 * REACH + 1) * (2 * REACH + 1) / SHARE) {
                return false;
            }
        }
    }
    const float more = sum / (float)(count - near);
    return count >= LEAST_OTHERS && near <= count / SHARE && more * more < 9.0f * own;
}

/* The mean of a texel's neighbours that are no outliers; if all are, what it has itself. */
static float mean_about(const air_outlier_surface *s, const uint16_t *marks, uint16_t bit,
                        const float *values, size_t texel)
{
    const window w = window_about(s, texel, 1);
    float sum = 0.0f, count = 0.0f;
    for (size_t y = w.first[1]; y < w.end[1]; y++) {
        for (size_t x = w.first[0]; x < w.end[0]; x++) {
            const size_t i = y * s->width + x;
            if (s->charts[i] == s->charts[texel] && (marks[i] & bit) == 0) {
                sum += values[i];
                count += 1.0f;
            }
        }
    }
    return count > 0.0f ? sum / count : values[texel];
}

/* How much of the light of texel a texel b gets for its area: less with the distance on the
 * surface, 0 from the radius on; and where there is less or more light than at a in proportion
 * less, so that shadows stay. */
static float share_of(const air_outlier_surface *s, size_t a, size_t b, const float *values,
                      float grain)
{
    float off = 0.0f, cosine = 0.0f, squared = 0.0f;
    for (size_t k = 0; k < 3; k++) {
        const float d = s->position[k][b] - s->position[k][a];
        off += s->normal[k][a] * d;
        cosine += s->normal[k][a] * s->normal[k][b];
        squared += d * d;
    }
    const float step = s->spacing[a] * s->spacing[a];
    const float most = (float)(AIR_OUTLIER_RADIUS * AIR_OUTLIER_RADIUS) * step;
    if (s->charts[a] != s->charts[b] || squared >= most || cosine < s->least_cosine ||
        off * off > 1.0001f * s->plane_distance * s->plane_distance * step) {
        return 0.0f;
    }
    const float falloff = 1.0f - squared / most;
    const float here = float_max(values[a], 0.0f) + grain,
                there = float_max(values[b], 0.0f) + grain;
    return falloff * falloff * float_min(here, there) / float_max(here, there);
}

static float area_of(const air_outlier_surface *s, size_t texel)
{
    return s->area != NULL ? s->area[texel] : 1.0f;
}

static void spread(const air_outlier_surface *s, const air_outlier *outlier, float *values)
{
    enum { SIDE = 2 * AIR_OUTLIER_RADIUS + 1 };
    float shares[SIDE * SIDE], sum = 0.0f;
    const window w = window_about(s, outlier->texel, AIR_OUTLIER_RADIUS);
    const float grain = outlier->light / (float)(AIR_OUTLIER_RADIUS * AIR_OUTLIER_RADIUS);
    size_t count = 0;
    for (size_t y = w.first[1]; y < w.end[1]; y++) {
        for (size_t x = w.first[0]; x < w.end[0]; x++) {
            const size_t i = y * s->width + x;
            const float share = share_of(s, outlier->texel, i, values, grain);
            sum += share * area_of(s, i);
            shares[count++] = share;
        }
    }
    if (!(sum > 0.0f)) { /* nothing is within reach, not even itself */
        values[outlier->texel] += outlier->light / area_of(s, outlier->texel);
        return;
    }
    const float factor = outlier->light / sum;
    count = 0;
    for (size_t y = w.first[1]; y < w.end[1]; y++) {
        for (size_t x = w.first[0]; x < w.end[0]; x++) {
            values[y * s->width + x] += factor * shares[count++];
        }
    }
}

void air_outliers_spread(const air_outlier_surface *surface, const uint16_t *marks, uint16_t bit,
                         air_outlier *list, float *values)
{
    const size_t texels = surface->width * surface->height;
    size_t count = 0;
    for (size_t i = 0; i < texels; i++) {
        if ((marks[i] & bit) != 0) {
            const float mean = mean_about(surface, marks, bit, values, i);
            list[count++] = (air_outlier){i, (values[i] - mean) * area_of(surface, i)};
        }
    }
    for (size_t k = 0; k < count; k++) {
        values[list[k].texel] -= list[k].light / area_of(surface, list[k].texel);
    }
    for (size_t k = 0; k < count; k++) {
        spread(surface, &list[k], values);
    }
}
