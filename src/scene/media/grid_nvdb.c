#include <inttypes.h>
#include <string.h>

#include "scene/media/grid_bricks.h"
#include "scene/media/nvdb_file.h"

/* PNanoVDB.h reads through this buffer. The file is not trusted: a read beyond the end gives 0 and
 * is noted. */
typedef struct pnanovdb_buf_t {
    const uint8_t *bytes;
    uint64_t size;
    bool *beyond_end;
} pnanovdb_buf_t;

static inline uint32_t pnanovdb_buf_read_uint32(pnanovdb_buf_t buf, uint64_t byte_offset)
{
    uint32_t value = 0;
    if (buf.size < sizeof value || byte_offset > buf.size - sizeof value) {
        *buf.beyond_end = true;
        return 0;
    }
    memcpy(&value, buf.bytes + byte_offset, sizeof value);
    return value;
}

static inline uint64_t pnanovdb_buf_read_uint64(pnanovdb_buf_t buf, uint64_t byte_offset)
{
    uint64_t value = 0;
    if (buf.size < sizeof value || byte_offset > buf.size - sizeof value) {
        *buf.beyond_end = true;
        return 0;
    }
    memcpy(&value, buf.bytes + byte_offset, sizeof value);
    return value;
}

typedef uint32_t pnanovdb_grid_type_t;
#define PNANOVDB_GRID_TYPE_GET(grid_typeIn, nameIn) pnanovdb_grid_type_constants[grid_typeIn].nameIn
#define PNANOVDB_C
#define PNANOVDB_BUF_CUSTOM
#include <nanovdb/PNanoVDB.h>

#define MAGIC_GRID UINT64_C(0x314244566f6e614e) /* "NanoVDB1", since format 32.6 */

/* Sides of nodes and tiles, in cells of 8^3 voxels: leaves and tiles of lower nodes, tiles of upper
 * nodes, of the root. */
enum { LEAF_CELLS = 1, LOWER_CELLS = 16, UPPER_CELLS = 512 };

/* In a cell's source: it is the address of a leaf, else that of a tile's value. Addresses are
 * multiples of 4. */
enum { SOURCE_IS_LEAF = 1 };

typedef struct nvdb_tree {
    air_context *context;
    const char *path;
    pnanovdb_buf_t buf;
    pnanovdb_grid_type_t type;
    pnanovdb_root_handle_t root;
    size_t channels;
    float background[3];
    bool beyond_end; /* a read went beyond the end */
    bool misplaced;  /* a node is where none can be, or there are more than the bytes can hold */
    int64_t low[3], high[3]; /* cells in use, [low, high) */
    uint64_t *sources;       /* per cell in use: where its values are, 0 for the background */
    uint64_t visited; /* bytes of the nodes seen; nodes are disjoint, so that they sum to less than
                         the grid */
} nvdb_tree;

/* What is done with each leaf and active tile: its first cell, its side in cells, its source. */
typedef void (*visit_cells)(nvdb_tree *tree, const int64_t cell[3], int64_t side, uint64_t source);

static bool supported_type(uint32_t type)
{
    return type == PNANOVDB_GRID_TYPE_FLOAT || type == PNANOVDB_GRID_TYPE_DOUBLE ||
           type == PNANOVDB_GRID_TYPE_VEC3F || type == PNANOVDB_GRID_TYPE_FP4 ||
           type == PNANOVDB_GRID_TYPE_FP8 || type == PNANOVDB_GRID_TYPE_FP16 ||
           type == PNANOVDB_GRID_TYPE_FPN;
}

/* A value stored as it is: of tiles, the background, and leaves that are not quantised. */
static float read_value(const nvdb_tree *tree, uint64_t address, size_t channel)
{
    const pnanovdb_address_t at = {address};
    if (tree->type == PNANOVDB_GRID_TYPE_DOUBLE) {
        return (float)pnanovdb_read_double(tree->buf, at);
    }
    return pnanovdb_read_float(tree->buf, pnanovdb_address_offset(at, (uint32_t)(4 * channel)));
}

/* How many bits a value of a FpN leaf has, as a logarithm: 0 to 4. */
static uint32_t leaf_log_bits(const nvdb_tree *tree, pnanovdb_leaf_handle_t leaf)
{
    return pnanovdb_leaf_get_bbox_dif_and_flags(tree->buf, leaf) >> 29;
}

static float read_leaf(const nvdb_tree *tree, pnanovdb_leaf_handle_t leaf, pnanovdb_coord_t ijk,
                       size_t channel)
{
    const pnanovdb_address_t at =
        pnanovdb_leaf_get_value_address(tree->type, tree->buf, leaf, &ijk);
    switch (tree->type) {
    case PNANOVDB_GRID_TYPE_FP4:
        return pnanovdb_leaf_fp4_read_float(tree->buf, at, &ijk);
    case PNANOVDB_GRID_TYPE_FP8:
        return pnanovdb_leaf_fp8_read_float(tree->buf, at, &ijk);
    case PNANOVDB_GRID_TYPE_FP16:
        return pnanovdb_leaf_fp16_read_float(tree->buf, at, &ijk);
    case PNANOVDB_GRID_TYPE_FPN:
        return pnanovdb_leaf_fpn_read_float(tree->buf, at, &ijk);
    default:
        return read_value(tree, at.byte_offset, channel);
    }
}

/* Nodes are aligned and disjoint; a file in which they are not would make the walk over them long.
 */
static bool enter_node(nvdb_tree *tree, uint64_t address, uint64_t size)
{
    tree->visited += size;
    if (address % 8 != 0 || address >= tree->buf.size || size > tree->buf.size - address ||
        tree->visited > tree->buf.size) {
        tree->misplaced = true;
    }
    return !tree->misplaced;
}

static bool enter_leaf(nvdb_tree *tree, pnanovdb_leaf_handle_t leaf)
{
    uint64_t size = PNANOVDB_GRID_TYPE_GET(tree->type, leaf_size);
    if (tree->type == PNANOVDB_GRID_TYPE_FPN) {
        const uint32_t log_bits = leaf_log_bits(tree, leaf);
        tree->misplaced = tree->misplaced || log_bits > 4;
        size += log_bits <= 4 ? (uint64_t)64 << log_bits : 0;
    }
    return enter_node(tree, leaf.address.byte_offset, size);
}

/* The cell at which entry n of a node begins; a node has 2^log entries per axis, x slowest. */
static void entry_cell(const int64_t node_cell[3], uint32_t n, uint32_t log, int64_t side,
                       int64_t out[3])
{
    const uint32_t mask = (1u << log) - 1u;
    out[0] = node_cell[0] + (int64_t)(n >> (2 * log)) * side;
    out[1] = node_cell[1] + (int64_t)(n >> log & mask) * side;
    out[2] = node_cell[2] + (int64_t)(n & mask) * side;
}

static void visit_lower(nvdb_tree *tree, pnanovdb_lower_handle_t lower, const int64_t node_cell[3],
                        visit_cells visit)
{
    if (!enter_node(tree, lower.address.byte_offset,
                    PNANOVDB_GRID_TYPE_GET(tree->type, lower_size))) {
        return;
    }
    for (uint32_t n = 0; n < PNANOVDB_LOWER_TABLE_COUNT && !tree->misplaced; n++) {
        const bool child = pnanovdb_lower_get_child_mask(tree->buf, lower, n);
        int64_t cell[3];
        if (!child && !pnanovdb_lower_get_value_mask(tree->buf, lower, n)) {
            continue;
        }
        entry_cell(node_cell, n, 4, LEAF_CELLS, cell);
        if (child) {
            const pnanovdb_leaf_handle_t leaf =
                pnanovdb_lower_get_child(tree->type, tree->buf, lower, n);
            if (enter_leaf(tree, leaf)) {
                visit(tree, cell, LEAF_CELLS, leaf.address.byte_offset | SOURCE_IS_LEAF);
            }
        } else {
            visit(tree, cell, LEAF_CELLS,
                  pnanovdb_lower_get_table_address(tree->type, tree->buf, lower, n).byte_offset);
        }
    }
}

static void visit_upper(nvdb_tree *tree, pnanovdb_upper_handle_t upper, const int64_t node_cell[3],
                        visit_cells visit)
{
    if (!enter_node(tree, upper.address.byte_offset,
                    PNANOVDB_GRID_TYPE_GET(tree->type, upper_size))) {
        return;
    }
    for (uint32_t n = 0; n < PNANOVDB_UPPER_TABLE_COUNT && !tree->misplaced; n++) {
        const bool child = pnanovdb_upper_get_child_mask(tree->buf, upper, n);
        int64_t cell[3];
        if (!child && !pnanovdb_upper_get_value_mask(tree->buf, upper, n)) {
            continue;
        }
        entry_cell(node_cell, n, 5, LOWER_CELLS, cell);
        if (child) {
            visit_lower(tree, pnanovdb_upper_get_child(tree->type, tree->buf, upper, n), cell,
                        visit);
        } else {
            visit(tree, cell, LOWER_CELLS,
                  pnanovdb_upper_get_table_address(tree->type, tree->buf, upper, n).byte_offset);
        }
    }
}

/* The key of a root tile holds the upper 20 bits of its coordinates, 21 bits apart
 * (pnanovdb_coord_to_key). */
static void key_cell(uint64_t key, int64_t out[3])
{
    for (int k = 0; k < 3; k++) {
        const uint32_t bits = (uint32_t)(key >> (42 - 21 * k) & 0xfffff) << 12;
        out[k] = (int64_t)(int32_t)bits / AIR_BRICK;
    }
}

static void visit_tree(nvdb_tree *tree, visit_cells visit)
{
    const uint32_t tile_count = pnanovdb_root_get_tile_count(tree->buf, tree->root);
    const uint64_t tile_size = PNANOVDB_GRID_TYPE_GET(tree->type, root_tile_size);
    tree->visited = 0;
    if (tile_count > tree->buf.size / tile_size) {
        tree->misplaced = true;
    }
    for (uint32_t n = 0; n < tile_count && !tree->misplaced && !tree->beyond_end; n++) {
        const pnanovdb_root_tile_handle_t tile = pnanovdb_root_get_tile(tree->type, tree->root, n);
        int64_t cell[3];
        key_cell(pnanovdb_root_tile_get_key(tree->buf, tile), cell);
        if (pnanovdb_root_tile_get_child(tree->buf, tile) != 0) {
            visit_upper(tree, pnanovdb_root_get_child(tree->type, tree->buf, tree->root, tile),
                        cell, visit);
        } else if (pnanovdb_root_tile_get_state(tree->buf, tile) != 0) {
            visit(tree, cell, UPPER_CELLS,
                  pnanovdb_root_tile_get_value_address(tree->type, tree->buf, tile).byte_offset);
        }
    }
}

static void extend_bounds(nvdb_tree *tree, const int64_t cell[3], int64_t side, uint64_t source)
{
    (void)source;
    for (int k = 0; k < 3; k++) {
        tree->low[k] = cell[k] < tree->low[k] ? cell[k] : tree->low[k];
        tree->high[k] = cell[k] + side > tree->high[k] ? cell[k] + side : tree->high[k];
    }
}

/* The source of a cell, 0 outside those in use. */
static uint64_t *cell_source(const nvdb_tree *tree, int64_t x, int64_t y, int64_t z)
{
    const int64_t i = x - tree->low[0], j = y - tree->low[1], k = z - tree->low[2];
    const int64_t nx = tree->high[0] - tree->low[0], ny = tree->high[1] - tree->low[1];
    if (i < 0 || j < 0 || k < 0 || i >= nx || j >= ny || z >= tree->high[2]) {
        return NULL;
    }
    return &tree->sources[(k * ny + j) * nx + i];
}

static void set_sources(nvdb_tree *tree, const int64_t cell[3], int64_t side, uint64_t source)
{
    for (int64_t z = 0; z < side; z++) {
        for (int64_t y = 0; y < side; y++) {
            for (int64_t x = 0; x < side; x++) {
                *cell_source(tree, cell[0] + x, cell[1] + y, cell[2] + z) = source;
            }
        }
    }
}

static bool background_is_zero(const nvdb_tree *tree)
{
    return tree->background[0] == 0.0f && tree->background[1] == 0.0f &&
           tree->background[2] == 0.0f;
}

/* A grid as air_grid_make asks for it: the tree, and the cell at which its bricks begin. */
typedef struct nvdb_bricks {
    const nvdb_tree *tree;
    int64_t first[3];
} nvdb_bricks;

/* One value of a cell whose source is not a leaf. */
static float read_tile(const nvdb_tree *tree, uint64_t source, size_t channel)
{
    return source == 0 ? tree->background[channel] : read_value(tree, source, channel);
}

/* Writes the samples of a brick that come from one cell: all 8 per axis, or with `next` the first
 * only. */
static void read_cell(const nvdb_tree *tree, uint64_t source, const int next[3], float *out)
{
    const pnanovdb_leaf_handle_t leaf = {{source & ~(uint64_t)SOURCE_IS_LEAF}};
    int begin[3], end[3];
    for (int k = 0; k < 3; k++) {
        begin[k] = next[k] ? AIR_BRICK : 0;
        end[k] = next[k] ? AIR_BRICK_SIDE : AIR_BRICK;
    }
    for (int z = begin[2]; z < end[2]; z++) {
        for (int y = begin[1]; y < end[1]; y++) {
            for (int x = begin[0]; x < end[0]; x++) {
                float *value =
                    out + (size_t)((z * AIR_BRICK_SIDE + y) * AIR_BRICK_SIDE + x) * tree->channels;
                const pnanovdb_coord_t ijk = {x % AIR_BRICK, y % AIR_BRICK, z % AIR_BRICK};
                for (size_t c = 0; c < tree->channels; c++) {
                    value[c] = source & SOURCE_IS_LEAF ? read_leaf(tree, leaf, ijk, c)
                                                       : read_tile(tree, source, c);
                }
            }
        }
    }
}

static air_brick_kind read_nvdb_brick(void *user, const int32_t base[3], float *out)
{
    const nvdb_bricks *bricks = user;
    const nvdb_tree *tree = bricks->tree;
    uint64_t sources[8];
    bool same = true;
    for (int n = 0; n < 8; n++) {
        const uint64_t *source = cell_source(tree, bricks->first[0] + base[0] / AIR_BRICK + (n & 1),
                                             bricks->first[1] + base[1] / AIR_BRICK + (n >> 1 & 1),
                                             bricks->first[2] + base[2] / AIR_BRICK + (n >> 2));
        sources[n] = source != NULL ? *source : 0;
        same = same && sources[n] == sources[0];
    }
    if (same && sources[0] == 0 && background_is_zero(tree)) {
        return AIR_BRICK_EMPTY;
    }
    if (same && !(sources[0] & SOURCE_IS_LEAF)) {
        for (size_t c = 0; c < tree->channels; c++) {
            out[c] = read_tile(tree, sources[0], c);
        }
        return AIR_BRICK_UNIFORM;
    }
    for (int n = 0; n < 8; n++) {
        const int next[3] = {n & 1, n >> 1 & 1, n >> 2};
        read_cell(tree, sources[n], next, out);
    }
    return AIR_BRICK_VARIED;
}

/* The map of the grid file, moved to the first sample. */
static void read_map(const nvdb_tree *tree, const int64_t origin[3], float out[12])
{
    const pnanovdb_grid_handle_t grid = {{0}};
    const pnanovdb_map_handle_t map = pnanovdb_grid_get_map(tree->buf, grid);
    for (uint32_t r = 0; r < 3; r++) {
        double offset = pnanovdb_map_get_vecd(tree->buf, map, r);
        for (uint32_t c = 0; c < 3; c++) {
            const double m = pnanovdb_map_get_matd(tree->buf, map, 3 * r + c);
            out[4 * r + c] = (float)m;
            offset += m * (double)origin[c];
        }
        out[4 * r + 3] = (float)offset;
    }
}

static air_status fail_damaged(const nvdb_tree *tree, const air_nvdb_entry *entry, const char *what)
{
    return air_fail(tree->context, AIR_ERROR_FORMAT,
                    "%s: byte %" PRIu64 ": grid \"%s\" is damaged: %s", tree->path, entry->offset,
                    entry->name, what);
}

static air_status open_tree(nvdb_tree *tree, const air_nvdb_entry *entry)
{
    const pnanovdb_grid_handle_t grid = {{0}};
    const uint64_t magic = pnanovdb_grid_get_magic(tree->buf, grid);
    const uint32_t version = pnanovdb_grid_get_version(tree->buf, grid);
    if (magic != PNANOVDB_MAGIC_NUMBER && magic != MAGIC_GRID) {
        return fail_damaged(tree, entry, "expected the magic number of a NanoVDB grid");
    }
    if (pnanovdb_version_get_major(version) != AIR_NVDB_MAJOR_VERSION ||
        pnanovdb_grid_get_grid_type(tree->buf, grid) != entry->type) {
        return fail_damaged(tree, entry, "version and type differ from the file's");
    }
    if (pnanovdb_grid_get_grid_class(tree->buf, grid) == PNANOVDB_GRID_CLASS_LEVEL_SET) {
        return air_fail(
            tree->context, AIR_ERROR_UNSUPPORTED,
            "%s: grid \"%s\" is a level set, expected a fog volume (sdfToFogVolume converts it)",
            tree->path, entry->name);
    }
    tree->root = pnanovdb_tree_get_root(tree->buf, pnanovdb_grid_get_tree(tree->buf, grid));
    for (size_t c = 0; c < tree->channels; c++) {
        tree->background[c] =
            read_value(tree,
                       tree->root.address.byte_offset +
                           PNANOVDB_GRID_TYPE_GET(tree->type, root_off_background),
                       c);
    }
    visit_tree(tree, extend_bounds);
    if (tree->beyond_end || tree->misplaced) {
        return fail_damaged(tree, entry, "a node lies outside its bytes");
    }
    if (tree->low[0] >= tree->high[0]) {
        return air_fail(tree->context, AIR_ERROR_FORMAT, "%s: grid \"%s\" has no active voxels",
                        tree->path, entry->name);
    }
    if (!background_is_zero(tree)) {
        air_warn(tree->context,
                 "%s: grid \"%s\" has the background %g; it is taken as 0 outside the stored nodes",
                 tree->path, entry->name, (double)tree->background[0]);
    }
    return AIR_OK;
}

/* Makes the grid of an open tree. Where the background is 0, one cell before the first and one
 * sample behind the last let the outermost values fall off to it as they do in OpenVDB. */
static air_status make_grid(nvdb_tree *tree, const air_nvdb_entry *entry, air_grid **out_grid)
{
    const int64_t border = background_is_zero(tree) ? 1 : 0;
    nvdb_bricks bricks = {.tree = tree};
    air_grid_source source = {.what = tree->path,
                              .channels = tree->channels,
                              .user = &bricks,
                              .read_brick = read_nvdb_brick};
    size_t cell_count = 1;
    for (int k = 0; k < 3; k++) {
        bricks.first[k] = tree->low[k] - border;
        source.origin[k] = bricks.first[k] * AIR_BRICK;
        source.size[k] = (size_t)((tree->high[k] - bricks.first[k]) * AIR_BRICK + border);
        cell_count *= (size_t)(tree->high[k] - tree->low[k]);
    }
    air_status status =
        air_grid_check_size(tree->context, tree->path, source.size, source.channels);
    if (status != AIR_OK) {
        return status;
    }
    read_map(tree, source.origin, source.index_to_local);
    tree->sources = air_allocate(tree->context, cell_count, sizeof *tree->sources);
    if (tree->sources == NULL) {
        return air_fail_memory(tree->context, tree->path);
    }
    visit_tree(tree, set_sources);
    air_grid *grid = NULL;
    status = air_grid_make(tree->context, &source, &grid);
    if (status == AIR_OK && tree->beyond_end) {
        air_grid_destroy(grid);
        return fail_damaged(tree, entry, "values lie outside its bytes");
    }
    if (status == AIR_OK) {
        *out_grid = grid;
    }
    return status;
}

air_status air_grid_load_nvdb(air_context *context, const char *path, const char *name,
                              air_grid **out_grid)
{
    void *data = NULL;
    size_t size = 0;
    uint8_t *bytes = NULL;
    air_nvdb_entry entry;
    air_status status = air_file_read(context, path, &data, &size);
    if (status != AIR_OK) {
        return status;
    }
    nvdb_tree tree = {.context = context,
                      .path = path,
                      .low = {INT64_MAX, INT64_MAX, INT64_MAX},
                      .high = {INT64_MIN, INT64_MIN, INT64_MIN}};
    status = air_nvdb_find(context, path, data, size, name, supported_type, &entry);
    if (status == AIR_OK) {
        status = air_nvdb_unpack(context, path, data, &entry, &bytes);
    }
    if (status != AIR_OK) {
        goto cleanup;
    }
    tree.type = entry.type;
    tree.channels = entry.type == PNANOVDB_GRID_TYPE_VEC3F ? 3 : 1;
    tree.buf = (pnanovdb_buf_t){bytes, entry.grid_size, &tree.beyond_end};
    status = open_tree(&tree, &entry);
    if (status == AIR_OK) {
        status = make_grid(&tree, &entry, out_grid);
    }

cleanup:
    air_free(context, tree.sources);
    air_free(context, bytes);
    air_free(context, data);
    return status;
}
