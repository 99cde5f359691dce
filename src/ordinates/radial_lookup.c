/* radial_lookup.c: values at points. First where the points of a block are in the grid, in loops
 * without branches, then what is there. */
#include "core/exponential.h"
#include "core/vec.h"
#include "ordinates/radial.h"

enum { BLOCK = 64 };

/* Where points lie: cells before them and the weights of those after; inside: 0 beyond R. */
typedef struct places {
    float u[BLOCK], v[BLOCK], shell[BLOCK], inside[BLOCK];
} places;

typedef struct axes {
    float half_n, last, radius2, per_log2, shells_end;
} axes;

/* log2 x for 0 < x < 2^127, to 2e-7 of 1 or of itself: x = 2^k m, m in [1/sqrt 2, sqrt 2), and
 * log m = 2 artanh((m - 1) / (m + 1)) to its ninth power. */
static inline float log2_of(float x)
{
    const uint32_t bits = air_float_bits(x) - 0x3f3504f3u; /* of 1/sqrt 2 */
    const float k = (float)((int32_t)bits >> 23);
    const float m = air_float_from_bits((bits & 0x007fffffu) + 0x3f3504f3u);
    const float s = (m - 1.0f) / (m + 1.0f), q = s * s;
    const float odd = 1.0f + q * (1.0f / 3.0f + q * (0.2f + q * (1.0f / 7.0f + q * (1.0f / 9.0f))));
    return k + 2.88539008f * s * odd;
}

static void place(const axes *grid, size_t count, const float *restrict x, const float *restrict y,
                  const float *restrict z, places *restrict at)
{
    for (size_t i = 0; i < count; i++) {
        const float r2 = x[i] * x[i] + y[i] * y[i] + z[i] * z[i];
        const float sum = fabsf(x[i]) + fabsf(y[i]) + fabsf(z[i]);
        const float scale = 1.0f / float_max(sum, 1e-30f);
        const float px = x[i] * scale, py = y[i] * scale;
        const float fx = copysignf(1.0f - fabsf(py), px), fy = copysignf(1.0f - fabsf(px), py);
        const float qx = z[i] < 0.0f ? fx : px, qy = z[i] < 0.0f ? fy : py;
        at->u[i] = (qx + 1.0f) * grid->half_n - 0.5f;
        at->v[i] = (qy + 1.0f) * grid->half_n - 0.5f;
        const float log2_share = log2_of(float_max(r2 / grid->radius2, 1e-30f));
        const float shell = grid->shells_end + grid->per_log2 * log2_share;
        at->shell[i] = float_min(grid->last, float_max(0.0f, shell));
        at->inside[i] = r2 <= grid->radius2 ? 1.0f : 0.0f;
    }
}

static float mix(float a, float b, float t) { return a + (b - a) * t; }

/* Of one shell at (u, v), in cells from the centre of the first, -0.5 to n - 0.5. */
static float across_edge(uint32_t n, const float *values, float u, float v)
{
    double d[3] = {((double)u + 0.5) * 2.0 / n - 1.0, ((double)v + 0.5) * 2.0 / n - 1.0, 0.0};
    const double x = d[0], y = d[1];
    d[2] = 1.0 - fabs(x) - fabs(y);
    if (d[2] < 0.0) {
        d[0] = copysign(1.0 - fabs(y), x);
        d[1] = copysign(1.0 - fabs(x), y);
    }
    uint32_t cells[4];
    double weights[4], sum = 0.0;
    air_radial_surrounding(n, d, cells, weights);
    for (int c = 0; c < 4; c++) {
        sum += weights[c] * (double)values[cells[c]];
    }
    return (float)sum;
}

static float at_direction(uint32_t n, const float *values, float u, float v)
{
    if (!(u >= 0.0f && v >= 0.0f && u < (float)(n - 1) && v < (float)(n - 1))) {
        return across_edge(n, values, u, v);
    }
    const uint32_t i = (uint32_t)u, j = (uint32_t)v;
    const float *const cell = values + (size_t)j * n + i;
    const float tu = u - (float)i, tv = v - (float)j;
    return mix(mix(cell[0], cell[1], tu), mix(cell[n], cell[n + 1], tu), tv);
}

void air_radial_look_up(const air_radial_grid *grid, const float *values, size_t count,
                        const float *x, const float *y, const float *z, float *out)
{
    const uint32_t n = grid->directions;
    const size_t shell_size = (size_t)n * n;
    /* Centres of shells lie half a shell, in log r, inside their ends. */
    const axes sizes = {
        .half_n = 0.5f * (float)n,
        .last = (float)(grid->shells - 1),
        .radius2 = grid->radius_m * grid->radius_m,
        .per_log2 = (float)(0.5 / log2(radial_ratio(n))),
        .shells_end = (float)grid->shells - 0.5f,
    };
    places at;
    for (size_t begin = 0; begin < count; begin += BLOCK) {
        const size_t size = count - begin < BLOCK ? count - begin : BLOCK;
        place(&sizes, size, x + begin, y + begin, z + begin, &at);
        for (size_t i = 0; i < size; i++) {
            const uint32_t k = (uint32_t)at.shell[i], next = k + 1 < grid->shells ? k + 1 : k;
            const float inner = at_direction(n, values + k * shell_size, at.u[i], at.v[i]);
            const float outer = at_direction(n, values + next * shell_size, at.u[i], at.v[i]);
            out[begin + i] = at.inside[i] * mix(inner, outer, at.shell[i] - (float)k);
        }
    }
}
