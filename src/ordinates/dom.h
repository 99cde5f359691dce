/* dom.h: the discrete-ordinates solver's state, and what a version of its kernel provides.
 *
 * Directions come in octants: those of the first (all components positive), and their mirror
 * images. Octant bit 0: x is negative, bit 1: y, bit 2: z. Harmonics are even or odd under each
 * mirroring, so they fall into eight classes, too; sums over the moments of a class serve all
 * octants, which differ only by signs: a Walsh-Hadamard transform of eight. */
#ifndef AIR_ORDINATES_DOM_H
#define AIR_ORDINATES_DOM_H

#include "airlight/ordinates_dom.h"

enum {
    DOM_OCTANTS = 8,
    DOM_MOMENTS_MAX = AIR_DOM_BANDS_MAX * AIR_DOM_BANDS_MAX,
    DOM_GROUP = 4, /* directions of an octant are filled up to a multiple of this, with weight 0 */
    DOM_BLOCKS_MAX = 64
};

/* Where the classes begin among the moments in order of class, by bands (test_ordinates_dom counts
 * them). A table, so that kernels written for a fixed number of bands have constants. */
static const int dom_class_begin[AIR_DOM_BANDS_MAX + 1][DOM_OCTANTS + 1] = {
    {0, 0, 0, 0, 0, 0, 0, 0, 0},          {0, 1, 1, 1, 1, 1, 1, 1, 1},
    {0, 1, 2, 3, 3, 4, 4, 4, 4},          {0, 3, 4, 5, 6, 7, 8, 9, 9},
    {0, 3, 6, 9, 10, 13, 14, 15, 16},     {0, 6, 9, 12, 15, 18, 21, 24, 25},
    {0, 6, 12, 18, 21, 27, 30, 33, 36},   {0, 10, 16, 22, 28, 34, 40, 46, 49},
    {0, 10, 20, 30, 36, 46, 52, 58, 64},  {0, 15, 25, 35, 45, 55, 65, 75, 81},
    {0, 15, 30, 45, 55, 70, 80, 90, 100},
};

/* Numbers in the precision of the version at work: doubles in plain C, else floats. */
typedef union dom_array {
    void *any;
    float *f;
    double *d;
} dom_array;

/* Sums over one slab or of one vector with another. */
typedef struct dom_sums {
    double change, size; /* squares of what changed, and of what is there */
} dom_sums;

/* Anderson's acceleration: the last steps' differences. Made by the first solve that needs them. */
typedef struct dom_history {
    int count, next_slot;
    dom_array residual, last_residual, last_next;
    dom_array residuals[AIR_DOM_DEPTH_MAX], nexts[AIR_DOM_DEPTH_MAX];
    double gram[AIR_DOM_DEPTH_MAX][AIR_DOM_DEPTH_MAX], right[AIR_DOM_DEPTH_MAX];
    double *dots; /* of each k: gram's new row, and right */
} dom_history;

struct dom_kernel;

struct air_dom {
    air_context *context;
    air_dom_params params;
    const struct dom_kernel *kernel;
    size_t number;      /* bytes of one */
    size_t cells, slab; /* cells of all, of one k */
    int moments;
    int directions; /* of one octant, filled up */
    size_t row;     /* directions * 4: numbers per cell and octant */
    size_t octant;  /* numbers from one octant's radiance to the next's */
    bool uniform;   /* one phase function for all cells and channels: in `emitting` */

    int order[DOM_MOMENTS_MAX];        /* moments by class */
    int class_of[DOM_MOMENTS_MAX + 3]; /* of order[m]; kernels go on to a multiple of 4 */
    int band_of[DOM_MOMENTS_MAX];
    double *dir[3], *weight; /* of the first octant's directions */
    /* Per moment (in order) and direction, times 4 channels: y_lm, with g_l where that is uniform;
     * and weight times y_lm. */
    dom_array emitting, gathering;
    dom_array slope[3]; /* 2 |O_axis| / cell_m, times 4 channels */
    dom_array weights;  /* times 4 channels */

    dom_array sigma_s, sigma_t; /* of the scaled medium; [cell][4] */
    dom_array sigma_a;
    dom_array phase; /* g_l of the scaled medium, [cell][bands][4]; unused where uniform */
    double legendre[AIR_DOM_BANDS_MAX + 1]; /* where uniform: g_0 .. g_bands, not scaled */
    float *peak;                            /* [cell][4] */

    dom_array light;       /* [cell][moments][4] */
    dom_array field, next; /* likewise; next: what a sweep makes of field */
    dom_array radiance;    /* octant * [cell][row]: sources, then radiances */
    dom_array face_x;      /* what leaves a slab's rows: [octant][j][row] */
    dom_array face_y;      /* what arrives from the row before: [octant][i][row] */
    dom_array face_z;      /* from the slab before: [octant][j][i][row] */
    double *leaving;       /* [octant][axis][row]: sums over the far faces */
    dom_array inflow;      /* [octant][row] radiance */
    uint32_t inflow_faces;
    dom_sums *sums; /* of each k */

    void *blocks[DOM_BLOCKS_MAX]; /* what is allocated */
    int block_count;
    dom_history history;
};

/* A version of the kernel: plain C in doubles, or lanes of floats. */
typedef struct dom_kernel {
    /* radiance = source of every direction, from these moments and light, in the cells of slab k.
     */
    void (*emit)(struct air_dom *dom, const dom_array *field, size_t k);
    /* radiance = what the sources of an octant add up to. */
    void (*sweep)(struct air_dom *dom, int octant);
    /* next = moments of radiance in slab k; sums[k]. */
    void (*gather)(struct air_dom *dom, size_t k);
    /* For Anderson's acceleration. dot: few enough for floats. */
    double (*dot)(const dom_array *a, const dom_array *b, size_t begin, size_t end);
    void (*subtract)(const dom_array *a, const dom_array *b, dom_array *out, size_t begin,
                     size_t end);
    /* out = a - sum of factors[i] * parts[i] */
    void (*combine)(const dom_array *a, const dom_array *parts, const double *factors, int count,
                    dom_array *out, size_t begin, size_t end);
} dom_kernel;

extern const dom_kernel dom_kernel_plain, dom_kernel_sse42, dom_kernel_avx2, dom_kernel_avx512;

/* g_l of the scaled medium. */
static inline double dom_scaled_legendre(double g_l, double peak)
{
    return (g_l - peak) / (1.0 - peak);
}

static inline double dom_get(const struct air_dom *dom, const dom_array *array, size_t i)
{
    return dom->number == sizeof(double) ? array->d[i] : (double)array->f[i];
}

static inline void dom_put(const struct air_dom *dom, dom_array *array, size_t i, double value)
{
    if (dom->number == sizeof(double)) {
        array->d[i] = value;
    } else {
        array->f[i] = (float)value;
    }
}

/* Where the radiances of a cell along an octant's directions begin. */
static inline size_t dom_radiance(const struct air_dom *dom, size_t octant, size_t cell)
{
    return octant * dom->octant + cell * dom->row;
}

/* The numbers [*begin, *end) of slab k in an array of moments. */
static inline void dom_slab_range(const struct air_dom *dom, size_t k, size_t *begin, size_t *end)
{
    const size_t size = dom->slab * (size_t)dom->moments * AIR_DOM_STRIDE;
    *begin = k * size;
    *end = *begin + size;
}

/* An array of `count` zeros, aligned to 64 bytes, that goes with the solver. False: no memory. */
bool dom_array_make(struct air_dom *dom, size_t count, dom_array *out);

/* Fills emitting and gathering, from legendre. */
void dom_make_harmonics(struct air_dom *dom);

/* The sign of a class's moments in an octant. */
static inline double dom_sign(int class, int octant)
{
    return __builtin_popcount((unsigned)(class & octant)) % 2 == 0 ? 1.0 : -1.0;
}

#endif
