/* shadow_build.c: the tree, from the top.
 *
 * A cell knows the height below which every point of it is in shadow (low) and the height from
 * which on every point is lit (high). low comes from covers: a triangle over the whole cell, or a
 * patch of triangles that continue each other and have no border in it. What lies below low
 * throws no shadow that is not thrown already, so it is dropped; this is what keeps leaves small.
 *
 * The cells of the first levels are made level by level, then each subtree below them by itself, in
 * parallel, into arrays of its own, which are put together in order: the tree does not depend on
 * the number of threads. */
#include "collimated/shadow_build.h"

#include <math.h>
#include <string.h>

#include "core/host.h"
#include "core/triple.h"
#include "core/vec.h"

enum {
    TOP_LEVELS = 3, /* levels made together: 64 subtrees */
    TASKS_MAX = 64
};

/* A square of the plane across the light. */
typedef struct cell {
    double x, y, half; /* centre, half side without the pad */
    uint32_t depth;
} cell;

/* A triangle in a cell. */
typedef struct reference {
    int32_t triangle;
    uint32_t edges; /* bit e: edge e meets the cell */
    float low, high;
    int32_t patch; /* union-find parent, an index among the cell's references */
    bool open;     /* of a patch's root: it has a border in the cell */
} reference;

/* What is being made of one subtree. Grows; failed: memory is out. */
typedef struct subtree {
    air_context *context;
    const air_shadow_tree_params *params;
    const shadow_mesh *mesh;
    double pad;
    int32_t
        *places; /* per triangle: where among the cell's references it was put last; the worker's */
    reference *references; /* of the cell under way */
    size_t reference_capacity;
    int32_t *stack; /* triangles of the cells on the way down */
    size_t stack_count, stack_capacity;
    shadow_node *nodes; /* children in fours */
    size_t node_count, node_capacity;
    shadow_triangle *leaves; /* the leaves' triangles */
    size_t leaf_count, leaf_capacity;
    bool failed;
} subtree;

/* Makes room for count items; false if memory is out. */
static bool reserve(subtree *self, void **items, size_t *capacity, size_t count, size_t size)
{
    if (count <= *capacity) {
        return true;
    }
    size_t grown = *capacity < 64 ? 64 : *capacity;
    while (grown < count) {
        grown += grown / 2;
    }
    void *moved = air_reallocate(self->context, *items, grown, size);
    if (moved == NULL) {
        self->failed = true;
        return false;
    }
    *items = moved;
    *capacity = grown;
    return true;
}

/* ---- one triangle in one cell ---- */

/* Do the two edges' ends leave the square on this axis to one side? */
static bool apart(double a, double b, double centre, double half)
{
    return double_max(a, b) < centre - half || double_min(a, b) > centre + half;
}

/* The heights of the triangle's plane over the square, where the triangle is larger than it and not
 * seen edge-on: tighter than its corners'. */
static void tighten(const shadow_triangle *t, const cell *c, double half, double area,
                    reference *out)
{
    const double x0 = (double)t->x[0], y0 = (double)t->y[0], z0 = (double)t->z[0];
    const double ux = (double)t->x[1] - x0, uy = (double)t->y[1] - y0, uz = (double)t->z[1] - z0;
    const double vx = (double)t->x[2] - x0, vy = (double)t->y[2] - y0, vz = (double)t->z[2] - z0;
    const double size2 = double_max(ux * ux + uy * uy, vx * vx + vy * vy);
    if (!(fabs(area) > 1e-6 * size2) || size2 < half * half) {
        return;
    }
    const double gx = (uz * vy - vz * uy) / area, gy = (ux * vz - vx * uz) / area;
    const double middle = z0 + gx * (c->x - x0) + gy * (c->y - y0);
    const double reach = (fabs(gx) + fabs(gy)) * half;
    /* rounded outwards by more than the rounding of float and of the plane */
    const double slack = 1e-6 * (reach + fabs(z0)) * 0.25;
    out->low = (float)double_max((double)out->low, middle - reach - slack);
    out->high = (float)double_min((double)out->high, middle + reach + slack);
}

/* Triangle and square against each other by separating axes. False if they are apart. */
static bool meet(const subtree *self, int32_t triangle, const cell *c, double low, reference *out)
{
    const shadow_triangle *t = &self->mesh->triangles[triangle];
    const double half = c->half + self->pad;
    out->triangle = triangle;
    out->low = fminf(t->z[0], fminf(t->z[1], t->z[2]));
    out->high = fmaxf(t->z[0], fmaxf(t->z[1], t->z[2]));
    if (!((double)out->high > low)) {
        return false;
    }
    double x[3], y[3];
    for (int k = 0; k < 3; k++) {
        x[k] = (double)t->x[k] - c->x;
        y[k] = (double)t->y[k] - c->y;
    }
    if (double_min(x[0], double_min(x[1], x[2])) > half ||
        double_max(x[0], double_max(x[1], x[2])) < -half ||
        double_min(y[0], double_min(y[1], y[2])) > half ||
        double_max(y[0], double_max(y[1], y[2])) < -half) {
        return false;
    }
    const double area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
    const double turn = area > 0.0 ? 1.0 : -1.0;
    out->edges = 0;
    for (int e = 0; e < 3; e++) {
        const int f = e == 2 ? 0 : e + 1;
        const double dx = x[f] - x[e], dy = y[f] - y[e];
        const double inside = turn * (dy * x[e] - dx * y[e]); /* of the centre, times the length */
        const double reach = (fabs(dx) + fabs(dy)) * half;
        if (inside < -reach) {
            return false;
        }
        if (inside <= reach && !apart(x[e], x[f], 0.0, half) && !apart(y[e], y[f], 0.0, half)) {
            out->edges |= 1u << e;
        }
    }
    tighten(t, c, half, area, out);
    return true;
}

/* ---- covers ---- */

static int32_t patch_root(reference *references, int32_t i)
{
    while (references[i].patch != i) {
        references[i].patch = references[references[i].patch].patch;
        i = references[i].patch;
    }
    return i;
}

static void join_patches(reference *references, int32_t a, int32_t b)
{
    const int32_t x = patch_root(references, a), y = patch_root(references, b);
    if (x != y) {
        references[x].patch = y;
        references[y].open = references[y].open || references[x].open;
        references[y].low = fminf(references[y].low, references[x].low);
    }
}

/* The reference of a neighbour, -1 if it is not in the cell. */
static int32_t place_of(const subtree *self, int32_t triangle, size_t count)
{
    const int32_t place = self->places[triangle];
    return place >= 0 && (size_t)place < count && self->references[place].triangle == triangle
               ? place
               : -1;
}

/* Raises low to the highest cover. A patch whose every edge in the cell leads on to another of its
 * triangles has no border there, so its projection fills the cell. */
static float raise_low(subtree *self, size_t count, float low)
{
    reference *references = self->references;
    for (size_t i = 0; i < count; i++) {
        references[i].patch = (int32_t)i;
        references[i].open = false;
        self->places[references[i].triangle] = (int32_t)i;
    }
    for (size_t i = 0; i < count; i++) {
        for (int e = 0; e < 3; e++) {
            if ((references[i].edges >> e & 1u) == 0) {
                continue;
            }
            const int32_t next = self->mesh->neighbours[3 * references[i].triangle + e];
            const int32_t place = next >= 0 ? place_of(self, next, count) : -1;
            if (place >= 0) {
                join_patches(references, (int32_t)i, place);
            } else {
                references[patch_root(references, (int32_t)i)].open = true;
            }
        }
    }
    for (size_t i = 0; i < count; i++) {
        if (references[i].patch == (int32_t)i && !references[i].open) {
            low = fmaxf(low, references[i].low);
        }
    }
    return low;
}

static float raise_low_by_single(const subtree *self, size_t count, float low)
{
    for (size_t i = 0; i < count; i++) {
        if (self->references[i].edges == 0) {
            low = fmaxf(low, self->references[i].low);
        }
    }
    return low;
}

/* ---- cells ---- */

/* Finds what of the triangles matters in the cell, raises *low, and keeps the rest on top of the
 * stack. Returns how many they are; *high: the height above which all is lit. */
static size_t sift(subtree *self, const cell *c, const int32_t *triangles, size_t count, float *low,
                   float *high)
{
    size_t met = 0, kept = 0;
    *high = *low;
    if (!reserve(self, (void **)&self->references, &self->reference_capacity, count,
                 sizeof *self->references)) {
        return 0;
    }
    for (size_t i = 0; i < count; i++) {
        met += meet(self, triangles[i], c, (double)*low, &self->references[met]);
    }
    *low = self->params->covers ? raise_low(self, met, *low) : raise_low_by_single(self, met, *low);
    *high = *low;
    if (!reserve(self, (void **)&self->stack, &self->stack_capacity, self->stack_count + met,
                 sizeof *self->stack)) {
        return 0;
    }
    for (size_t i = 0; i < met; i++) {
        if (self->references[i].high > *low) {
            self->stack[self->stack_count + kept++] = self->references[i].triangle;
            *high = fmaxf(*high, self->references[i].high);
        }
    }
    self->stack_count += kept;
    return kept;
}

static void make_leaf(subtree *self, const int32_t *triangles, size_t count, shadow_node *out)
{
    out->first = ~(int32_t)self->leaf_count;
    out->triangle_count = (int32_t)count;
    if (!reserve(self, (void **)&self->leaves, &self->leaf_capacity, self->leaf_count + count,
                 sizeof *self->leaves)) {
        return;
    }
    for (size_t i = 0; i < count; i++) {
        self->leaves[self->leaf_count++] = self->mesh->triangles[triangles[i]];
    }
}

static cell child_of(const cell *c, unsigned k)
{
    const double half = 0.5 * c->half;
    return (cell){c->x + ((k & 1u) != 0 ? half : -half), c->y + ((k & 2u) != 0 ? half : -half),
                  half, c->depth + 1};
}

/* What the children know of the whole. */
static void narrow(shadow_node *node, const shadow_node children[4])
{
    const float low =
        fminf(fminf(children[0].low, children[1].low), fminf(children[2].low, children[3].low));
    const float high =
        fmaxf(fmaxf(children[0].high, children[1].high), fmaxf(children[2].high, children[3].high));
    node->low = fmaxf(node->low, low);
    node->high = fmaxf(node->low, fminf(node->high, high));
}

static bool is_leaf(const subtree *self, const cell *c, size_t count)
{
    return count <= self->params->leaf_size || c->depth >= self->params->max_depth;
}

/* Makes the cell and all below it. The triangles lie on the stack, begin on. */
static void make_cell(subtree *self, const cell *c, size_t begin, size_t count, float low,
                      shadow_node *out)
{
    const size_t top = self->stack_count;
    float high;
    int32_t *given = self->stack;
    /* the stack may move while it grows */
    if (!reserve(self, (void **)&self->stack, &self->stack_capacity, top + count,
                 sizeof *self->stack)) {
        return;
    }
    given = self->stack + begin;
    const size_t kept = sift(self, c, given, count, &low, &high);
    *out = (shadow_node){low, high, ~0, 0};
    if (self->failed) {
        return;
    }
    if (is_leaf(self, c, kept)) {
        make_leaf(self, self->stack + top, kept, out);
        self->stack_count = top;
        return;
    }
    const size_t first = self->node_count;
    shadow_node children[4];
    if (!reserve(self, (void **)&self->nodes, &self->node_capacity, first + 4,
                 sizeof *self->nodes)) {
        return;
    }
    self->node_count += 4;
    out->first = (int32_t)first;
    for (unsigned k = 0; k < 4 && !self->failed; k++) {
        const cell child = child_of(c, k);
        make_cell(self, &child, top, kept, low, &children[k]);
    }
    if (!self->failed) {
        memcpy(self->nodes + first, children, sizeof children);
        narrow(out, children);
    }
    self->stack_count = top;
}

/* ---- all of it ---- */

/* A cell of the top levels: made from the triangles of the one above. */
typedef struct top_cell {
    cell at;
    shadow_node node;
    int32_t *triangles; /* kept, owned */
    size_t count;
    bool inner;
} top_cell;

typedef struct build {
    air_context *context;
    const shadow_mesh *mesh;
    const air_shadow_tree_params *params;
    double pad;
    top_cell cells[1 + 4 + 16 + 64]; /* level by level; the children of i are 4 i + 1 + k */
    subtree tasks[TASKS_MAX];
    int32_t **places; /* per worker */
    size_t level_begin;
} build;

static subtree subtree_make(const build *self, size_t worker)
{
    return (subtree){.context = self->context,
                     .params = self->params,
                     .mesh = self->mesh,
                     .pad = self->pad,
                     .places = self->places[worker]};
}

static void subtree_finish(subtree *task)
{
    air_free(task->context, task->references);
    air_free(task->context, task->stack);
    task->references = NULL;
    task->stack = NULL;
}

/* One cell of a level: sifted, not yet divided. */
static void make_top_cell(void *user, size_t index, size_t worker)
{
    build *self = user;
    const size_t i = self->level_begin + index;
    top_cell *c = &self->cells[i];
    const top_cell *parent = i > 0 ? &self->cells[(i - 1) / 4] : NULL;
    if (parent != NULL && !parent->inner) {
        return;
    }
    subtree task = subtree_make(self, worker);
    size_t kept = 0;
    if (parent != NULL) {
        c->at = child_of(&parent->at, (unsigned)((i - 1) % 4));
        c->node.low = parent->node.low;
        kept = sift(&task, &c->at, parent->triangles, parent->count, &c->node.low, &c->node.high);
    } else {
        kept = sift(&task, &c->at, c->triangles, c->count, &c->node.low, &c->node.high);
        air_free(self->context, c->triangles);
    }
    c->triangles = task.stack; /* may be NULL where nothing was kept */
    c->count = kept;
    c->inner = !task.failed && !is_leaf(&task, &c->at, kept);
    c->node.first = task.failed ? INT32_MIN : ~0;
    air_free(self->context, task.references);
}

/* A cell that the levels above have left: the subtree below it. */
static void make_subtree(void *user, size_t index, size_t worker)
{
    build *self = user;
    top_cell *c = &self->cells[self->level_begin + index];
    const top_cell *parent = &self->cells[(self->level_begin + index - 1) / 4];
    subtree *task = &self->tasks[index];
    if (!parent->inner) {
        return;
    }
    *task = subtree_make(self, worker);
    c->at = child_of(&parent->at, (unsigned)((self->level_begin + index - 1) % 4));
    if (reserve(task, (void **)&task->stack, &task->stack_capacity, parent->count,
                sizeof *task->stack)) {
        memcpy(task->stack, parent->triangles, parent->count * sizeof *task->stack);
        task->stack_count = parent->count;
        make_cell(task, &c->at, 0, parent->count, parent->node.low, &c->node);
    }
    subtree_finish(task);
}

/* ---- putting it together ---- */

/* Appends a subtree's nodes and triangles to the tree's, and moves its references to them. */
static void append(air_shadow_tree *tree, const subtree *task, shadow_node *root)
{
    const int32_t nodes = (int32_t)tree->node_count, triangles = (int32_t)tree->triangle_count;
    shadow_node *copied = tree->nodes + tree->node_count;
    if (task->node_count > 0) {
        memcpy(copied, task->nodes, task->node_count * sizeof *copied);
    }
    if (task->leaf_count > 0) {
        memcpy(tree->triangles + tree->triangle_count, task->leaves,
               task->leaf_count * sizeof *tree->triangles);
    }
    for (size_t i = 0; i <= task->node_count; i++) {
        shadow_node *node = i < task->node_count ? &copied[i] : root;
        node->first = node->first < 0 ? ~(~node->first + triangles) : node->first + nodes;
    }
    tree->node_count += task->node_count;
    tree->triangle_count += task->leaf_count;
}

/* The leaf of a top cell that is not divided. */
static void append_leaf(air_shadow_tree *tree, build *self, top_cell *c)
{
    subtree task = subtree_make(self, 0);
    task.leaves = tree->triangles;
    task.leaf_count = tree->triangle_count;
    task.leaf_capacity = SIZE_MAX; /* there is room */
    make_leaf(&task, c->triangles, c->count, &c->node);
    tree->triangle_count = task.leaf_count;
}

static const size_t level_begins[TOP_LEVELS + 2] = {0, 1, 5, 21, 85};

static air_status allocate_tree(build *self, air_shadow_tree *tree)
{
    size_t nodes = 4, triangles = 1; /* to have one */
    for (size_t i = 0; i < level_begins[TOP_LEVELS]; i++) {
        nodes += self->cells[i].inner ? 4 : 0;
        triangles += self->cells[i].inner ? 0 : self->cells[i].count;
    }
    for (size_t i = 0; i < TASKS_MAX; i++) {
        nodes += self->tasks[i].node_count;
        triangles += self->tasks[i].leaf_count;
    }
    if (nodes > INT32_MAX || triangles > INT32_MAX) {
        return air_fail(self->context, AIR_ERROR_UNSUPPORTED, "shadow tree: too many cells");
    }
    tree->nodes = air_allocate(self->context, nodes, sizeof *tree->nodes);
    tree->triangles = air_allocate(self->context, triangles, sizeof *tree->triangles);
    return tree->nodes == NULL || tree->triangles == NULL
               ? air_fail_memory(self->context, "shadow tree")
               : AIR_OK;
}

/* The cell's node and all below it, children first. */
static void assemble(build *self, air_shadow_tree *tree, size_t i, size_t place)
{
    top_cell *c = &self->cells[i];
    if (i >= level_begins[TOP_LEVELS]) {
        append(tree, &self->tasks[i - level_begins[TOP_LEVELS]], &c->node);
    } else if (!c->inner) {
        append_leaf(tree, self, c);
    } else {
        const size_t first = tree->node_count;
        tree->node_count += 4;
        c->node.first = (int32_t)first;
        for (size_t k = 0; k < 4; k++) {
            assemble(self, tree, 4 * i + 1 + k, first + k);
        }
        narrow(&c->node, tree->nodes + first);
    }
    tree->nodes[place] = c->node;
}

static bool start(build *self, const air_shadow_tree *tree)
{
    const size_t workers = air_context_thread_count(self->context);
    top_cell *root = &self->cells[0];
    self->places = air_allocate(self->context, workers, sizeof *self->places);
    root->triangles = air_allocate(self->context, self->mesh->count, sizeof *root->triangles);
    bool done = self->places != NULL && root->triangles != NULL;
    for (size_t i = 0; done && i < workers; i++) {
        self->places[i] = air_allocate(self->context, self->mesh->count, sizeof *self->places[i]);
        done = self->places[i] != NULL;
    }
    for (size_t i = 0; done && i < self->mesh->count; i++) {
        root->triangles[i] = (int32_t)i;
    }
    root->count = self->mesh->count;
    root->at = (cell){0.0, 0.0, 0.5 * tree->frame.side, 0};
    root->node.low = (float)tree->frame.floor;
    return done;
}

static bool make_levels(build *self)
{
    for (size_t level = 0; level < TOP_LEVELS; level++) {
        const size_t count = level_begins[level + 1] - level_begins[level];
        self->level_begin = level_begins[level];
        air_parallel_for(self->context, count, make_top_cell, self);
        for (size_t i = 0; i < count; i++) {
            if (self->cells[self->level_begin + i].node.first == INT32_MIN) {
                return false;
            }
        }
    }
    self->level_begin = level_begins[TOP_LEVELS];
    air_parallel_for(self->context, TASKS_MAX, make_subtree, self);
    for (size_t i = 0; i < TASKS_MAX; i++) {
        if (self->tasks[i].failed) {
            return false;
        }
    }
    return true;
}

static void finish(build *self)
{
    const size_t workers = air_context_thread_count(self->context);
    for (size_t i = 0; i < TASKS_MAX; i++) {
        air_free(self->context, self->tasks[i].nodes);
        air_free(self->context, self->tasks[i].leaves);
    }
    for (size_t i = 0; i < sizeof self->cells / sizeof *self->cells; i++) {
        air_free(self->context, self->cells[i].triangles);
    }
    for (size_t i = 0; self->places != NULL && i < workers; i++) {
        air_free(self->context, self->places[i]);
    }
    air_free(self->context, self->places);
    air_free(self->context, self);
}

air_status air_shadow_build(const air_shadow_tree_params *params, const shadow_mesh *mesh,
                            air_shadow_tree *tree)
{
    build *self = air_allocate(tree->context, 1, sizeof *self);
    if (self == NULL) {
        return air_fail_memory(tree->context, "shadow tree");
    }
    self->context = tree->context;
    self->mesh = mesh;
    self->params = params;
    self->pad = tree->frame.pad;
    air_status status = start(self, tree) && make_levels(self)
                            ? allocate_tree(self, tree)
                            : air_fail_memory(tree->context, "shadow tree");
    if (status == AIR_OK) {
        tree->node_count = 4;
        assemble(self, tree, 0, 0);
    }
    finish(self);
    return status;
}
