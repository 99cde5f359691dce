/* godot_probes.c: a grid of probes as Godot's capture data: harmonics, tetrahedra, and the tree
 * that finds the tetrahedron of a point. */
#include <math.h>
#include <string.h>

#include "lightmap/godot.h"

enum { TETRAHEDRA = 6, CELL_NODES = 5, SCALARS = 6 };

static const float one_over_pi = 0.318309886183790672f;

/* Kuhn's division of a cell: tetrahedron k goes from the lowest corner along the axes in this
 * order; it holds the points whose coordinates in the cell fall in this order. Cells fit each
 * other. */
static const uint8_t orders[TETRAHEDRA][3] = {{0, 1, 2}, {0, 2, 1}, {2, 0, 1},
                                              {1, 0, 2}, {1, 2, 0}, {2, 1, 0}};

/* Which coordinate is the larger one: five questions whose answers lead to one of the six. Children
 * of 5 and above are tetrahedra. */
static const struct {
    uint8_t a, b;                        /* is coordinate a above b? */
    uint8_t over, under;                 /* what then, what else */
} questions[CELL_NODES] = {{0, 1, 1, 2}, /* x > y? */
                           {1, 2, CELL_NODES + 0, 3},
                           {0, 2, CELL_NODES + 3, 4}, /* x > y: y > z?; y > x: x > z? */
                           {0, 2, CELL_NODES + 1, CELL_NODES + 2},  /* z > y: x > z? */
                           {1, 2, CELL_NODES + 4, CELL_NODES + 5}}; /* z > x: y > z? */

typedef struct probe_tree {
    air_context *context;
    const air_probe_set *set;
    size_t cells[3];
    double rows[3][3]; /* coordinate k of a point p in cells: rows[k] . p - shift[k] */
    double shift[3];
    air_sink *sink;
    int32_t *nodes; /* SCALARS each */
    size_t node_count;
} probe_tree;

static void cross(const float a[3], const float b[3], double out[3])
{
    for (size_t k = 0; k < 3; k++) {
        const size_t i = (k + 1) % 3, j = (k + 2) % 3;
        out[k] = (double)a[i] * (double)b[j] - (double)a[j] * (double)b[i];
    }
}

static double dot(const double a[3], const float b[3])
{
    return a[0] * (double)b[0] + a[1] * (double)b[1] + a[2] * (double)b[2];
}

/* The map from points to cells; false if the steps span no volume. */
static bool invert_steps(probe_tree *self)
{
    const air_probe_set *set = self->set;
    for (size_t k = 0; k < 3; k++) {
        double normal[3];
        cross(set->step[(k + 1) % 3], set->step[(k + 2) % 3], normal);
        const double volume = dot(normal, set->step[k]);
        if (!(fabs(volume) > 0.0)) {
            return false;
        }
        for (size_t i = 0; i < 3; i++) {
            self->rows[k][i] = normal[i] / volume;
        }
        self->shift[k] = dot(self->rows[k], set->origin);
    }
    return true;
}

/* A node that asks: is row . p above bound? Its plane has unit normal, as Godot's. */
static void set_node(probe_tree *self, size_t node, const double row[3], double bound, int32_t over,
                     int32_t under)
{
    const double length = sqrt(row[0] * row[0] + row[1] * row[1] + row[2] * row[2]);
    const float plane[4] = {(float)(row[0] / length), (float)(row[1] / length),
                            (float)(row[2] / length), (float)(bound / length)};
    int32_t *out = self->nodes + SCALARS * node;
    memcpy(out, plane, sizeof plane);
    out[4] = over;
    out[5] = under;
}

/* Leaves are -(tetrahedron + 1). */
static int32_t cell_child(uint8_t child, size_t first_node, size_t cell)
{
    return child < CELL_NODES ? (int32_t)(first_node + child)
                              : -(int32_t)(TETRAHEDRA * cell + child - CELL_NODES + 1);
}

/* The five nodes of a cell. */
static void add_cell(probe_tree *self, const size_t at[3])
{
    const size_t cell = (at[2] * self->cells[1] + at[1]) * self->cells[0] + at[0];
    const size_t first = self->node_count;
    self->node_count += CELL_NODES;
    for (size_t q = 0; q < CELL_NODES; q++) {
        const size_t a = questions[q].a, b = questions[q].b;
        double row[3];
        for (size_t i = 0; i < 3; i++) {
            row[i] = self->rows[a][i] - self->rows[b][i];
        }
        const double bound = self->shift[a] + (double)at[a] - (self->shift[b] + (double)at[b]);
        set_node(self, first + q, row, bound, cell_child(questions[q].over, first, cell),
                 cell_child(questions[q].under, first, cell));
    }
}

/* Halves a box of cells until one is left; children come behind their parent. The depth is the sum
 * of the logarithms of the grid's sizes. */
static int32_t add_box(probe_tree *self, const size_t low[3], const size_t high[3])
{
    size_t axis = 0;
    for (size_t k = 1; k < 3; k++) {
        axis = high[k] - low[k] > high[axis] - low[axis] ? k : axis;
    }
    const size_t node = self->node_count;
    if (high[axis] - low[axis] == 1) {
        add_cell(self, low);
        return (int32_t)node;
    }
    const size_t middle = low[axis] + (high[axis] - low[axis]) / 2;
    size_t upper_low[3], lower_high[3];
    memcpy(upper_low, low, sizeof upper_low);
    memcpy(lower_high, high, sizeof lower_high);
    upper_low[axis] = middle;
    lower_high[axis] = middle;
    self->node_count++;
    const int32_t over = add_box(self, upper_low, high);
    const int32_t under = add_box(self, low, lower_high);
    set_node(self, node, self->rows[axis], self->shift[axis] + (double)middle, over, under);
    return (int32_t)node;
}

static bool print_tetrahedra(const probe_tree *self)
{
    const size_t *size = self->set->size;
    const size_t strides[3] = {1, size[0], size[0] * size[1]};
    bool done = air_godot_print(self->sink, "\"tetrahedra\": PackedInt32Array(");
    const size_t cell_count = self->cells[0] * self->cells[1] * self->cells[2];
    for (size_t cell = 0; cell < cell_count && done; cell++) {
        const size_t x = cell % self->cells[0], y = cell / self->cells[0] % self->cells[1];
        const size_t z = cell / self->cells[0] / self->cells[1];
        for (size_t k = 0; k < TETRAHEDRA; k++) {
            size_t corner = x + strides[1] * y + strides[2] * z;
            for (size_t i = 0; i < 4; i++) {
                done = done &&
                       air_godot_print(self->sink, "%s%zu", cell + k + i > 0 ? ", " : "", corner);
                corner += i < 3 ? strides[orders[k][i]] : 0;
            }
        }
    }
    return done && air_godot_print(self->sink, "),\n");
}

static bool print_tree(probe_tree *self)
{
    static const size_t zero[3] = {0, 0, 0};
    (void)add_box(self, zero, self->cells);
    bool done = air_godot_print(self->sink, "\"bsp\": PackedInt32Array(");
    for (size_t i = 0; i < SCALARS * self->node_count && done; i++) {
        done = air_godot_print(self->sink, "%s%ld", i > 0 ? ", " : "", (long)self->nodes[i]);
    }
    return done && air_godot_print(self->sink, "),\n");
}

/* Godot keeps coefficients of radiance over pi, in our order; all layers together. */
static bool print_points(const probe_tree *self, float unit)
{
    const air_probe_set *set = self->set;
    bool done = air_godot_print(self->sink, "\"points\": PackedVector3Array(");
    for (size_t i = 0; i < 3 * set->count && done; i++) {
        done = air_godot_print(self->sink, "%s%.9g", i > 0 ? ", " : "", (double)set->positions[i]);
    }
    done = done && air_godot_print(self->sink, "),\n\"sh\": PackedColorArray(");
    for (size_t i = 0; i < AIR_PROBE_COEFFICIENTS * set->count && done; i++) {
        double colour[3] = {0.0, 0.0, 0.0};
        for (size_t c = 0; c < 3; c++) {
            for (size_t k = 0; k < AIR_LAYER_COUNT; k++) {
                colour[c] += (double)set->layers[k][3 * i + c];
            }
            colour[c] *= (double)(one_over_pi * unit);
        }
        done = air_godot_print(self->sink, "%s%.9g, %.9g, %.9g, 1", i > 0 ? ", " : "", colour[0],
                               colour[1], colour[2]);
    }
    return done && air_godot_print(self->sink, "),\n");
}

static bool print_bounds(const probe_tree *self)
{
    const air_probe_set *set = self->set;
    float low[3], high[3];
    memcpy(low, set->positions, sizeof low);
    memcpy(high, set->positions, sizeof high);
    for (size_t i = 3; i < 3 * set->count; i++) {
        low[i % 3] = fminf(low[i % 3], set->positions[i]);
        high[i % 3] = fmaxf(high[i % 3], set->positions[i]);
    }
    return air_godot_print(self->sink,
                           "probe_data = {\n\"baked_exposure\": 1.0,\n"
                           "\"bounds\": AABB(%.9g, %.9g, %.9g, %.9g, %.9g, %.9g),\n",
                           (double)low[0], (double)low[1], (double)low[2],
                           (double)high[0] - (double)low[0], (double)high[1] - (double)low[1],
                           (double)high[2] - (double)low[2]);
}

/* The first grid that fills space; the others are counted. */
static const air_probe_set *choose(const air_lightmap *lightmap, probe_tree *tree)
{
    for (size_t i = 0; i < lightmap->probe_set_count; i++) {
        const air_probe_set *set = &lightmap->probe_sets[i];
        tree->set = set;
        if (set->grid && set->size[0] > 1 && set->size[1] > 1 && set->size[2] > 1 &&
            set->count < INT32_MAX / TETRAHEDRA && invert_steps(tree)) {
            return set;
        }
    }
    tree->set = NULL;
    return NULL;
}

static air_status print_grid(probe_tree *self, float unit)
{
    size_t cell_count = 1;
    for (size_t k = 0; k < 3; k++) {
        self->cells[k] = self->set->size[k] - 1;
        cell_count *= self->cells[k];
    }
    /* Five nodes in each cell and one less than cells to part them. */
    self->nodes =
        air_allocate(self->context, cell_count, (CELL_NODES + 1) * SCALARS * sizeof *self->nodes);
    if (self->nodes == NULL) {
        return air_fail_memory(self->context, "lightmap.tres");
    }
    const bool done = print_bounds(self) && print_tree(self) &&
                      air_godot_print(self->sink, "\"interior\": false,\n"
                                                  "\"lightprobe_hash\": 0,\n") &&
                      print_points(self, unit) && print_tetrahedra(self) &&
                      air_godot_print(self->sink, "}\n");
    air_free(self->context, self->nodes);
    return done ? AIR_OK : air_fail_memory(self->context, "lightmap.tres");
}

air_status air_godot_print_probes(air_context *context, const air_lightmap *lightmap, float unit,
                                  air_sink *sink)
{
    probe_tree tree = {.context = context, .sink = sink};
    const air_probe_set *set = choose(lightmap, &tree);
    const size_t left_out = lightmap->probe_set_count - (set != NULL ? 1 : 0);
    if (left_out > 0) {
        air_warn(
            context,
            "lightmap.tres: %zu of %zu sets of probes are left out: Godot gets the first grid of "
            "2 x 2 x 2 or more",
            left_out, lightmap->probe_set_count);
    }
    if (set != NULL) {
        return print_grid(&tree, unit);
    }
    static const char nothing[] =
        "probe_data = {\n\"baked_exposure\": 1.0,\n\"bounds\": AABB(0, 0, 0, 0, 0, 0),\n"
        "\"bsp\": PackedInt32Array(),\n\"interior\": false,\n\"lightprobe_hash\": 0,\n"
        "\"points\": PackedVector3Array(),\n\"sh\": PackedColorArray(),\n"
        "\"tetrahedra\": PackedInt32Array()\n}\n";
    return air_godot_print(sink, "%s", nothing) ? AIR_OK
                                                : air_fail_memory(context, "lightmap.tres");
}
