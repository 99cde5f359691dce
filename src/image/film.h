/* film.h: raw sums of a picture, kept so that any split of the samples gives the same bytes.
 *
 * Samples are summed in blocks of 16 in index order; blocks are summed pairwise in the binary tree
 * that their indices span. A film therefore holds one node per aligned power-of-two run of blocks,
 * and two films that together cover a run merge to what one render of the run would have summed. */
#ifndef AIR_IMAGE_FILM_H
#define AIR_IMAGE_FILM_H

#include "airlight/render.h"
#include "core/host.h"

enum { AIR_FILM_BLOCK = 16, AIR_FILM_MAX_SLOTS = 32, AIR_FILM_NAME = 16, AIR_FILM_MAX_LEVELS = 32 };

typedef enum air_slot_kind {
    AIR_SLOT_TERM = 0,  /* 3 sums, part of beauty, a layer */
    AIR_SLOT_RATIO = 1, /* analytic, unoccluded, occluded, plain: 3 sums each; resolves to A/n * O/U
                           + P/n, part of beauty, a layer */
    AIR_SLOT_GUIDE = 2, /* sums, not part of beauty */
    AIR_SLOT_SQUARES = 3, /* 3 sums over replicates of the squared sum of beauty */
    AIR_SLOT_SHARE =
        4 /* as AIR_SLOT_RATIO, and a 13th sum, the number of samples of O and U:
before    these are divided, they are smoothed by what the guides see, the less the more they are */
} air_slot_kind;

static inline bool air_slot_is_ratio(air_slot_kind kind)
{
    return kind == AIR_SLOT_RATIO || kind == AIR_SLOT_SHARE;
}

typedef struct air_film_slot {
    air_slot_kind kind;
    char name[AIR_FILM_NAME];
    uint32_t components;
    uint32_t offset; /* among a pixel's doubles; set by air_film_create */
} air_film_slot;

typedef struct air_film_layout {
    air_film_slot slots[AIR_FILM_MAX_SLOTS];
    uint32_t slot_count;
    uint32_t stride; /* doubles per pixel */
} air_film_layout;

/* Appends a slot. components: 3 for terms and squares, 12 for ratios, 13 for shares. */
void air_film_layout_add(air_film_layout *layout, air_slot_kind kind, const char *name,
                         uint32_t components);

/* What the twelve sums of a ratio slot come to, before division by n: A O/U + P of one component.
 */
static inline double air_ratio_total(const double *sums, uint32_t component)
{
    const double *s = sums + component;
    return s[9] + (s[3] != 0.0 ? s[0] * (s[6] / s[3]) : 0.0);
}

typedef struct air_film_node {
    uint32_t begin, end; /* samples */
    double *sums;        /* pixel-major, stride doubles each */
} air_film_node;

typedef struct air_film_attribute {
    char *name, *value;
} air_film_attribute;

struct air_film {
    air_context *context;
    uint32_t width, height; /* of the whole picture */
    uint32_t crop[4];
    uint64_t seed;
    uint64_t settings;       /* hash of what must agree for films to be merged */
    uint32_t replicate_size; /* samples per replicate; 0: none */
    air_film_layout layout;
    air_film_node *nodes; /* sorted by begin, disjoint */
    size_t node_count, node_capacity;
    air_film_attribute *attributes;
    size_t attribute_count;
};

/* A film without samples; template gives everything but the nodes and attributes. */
air_status air_film_create(air_context *context, const air_film *description, air_film **out_film);

size_t air_film_pixel_count(const air_film *film);

/* The longest run that starts at begin, is aligned to its length and ends by `end`: the next node's
 * end. */
uint32_t air_film_node_end(uint32_t begin, uint32_t end);

/* Allocates sums for a node that is to be filled and then given to air_film_add. */
air_status air_film_node_create(const air_film *film, uint32_t begin, uint32_t end,
                                air_film_node *out);
/* Takes the node's sums and joins siblings; on failure the node stays the caller's. */
air_status air_film_add(air_film *film, air_film_node *node);

/* Adds up a pixel's blocks as the tree has them: push each block's sums in order, then read the
 * total. */
typedef struct air_block_stack {
    uint32_t stride;
    uint32_t levels[AIR_FILM_MAX_LEVELS]; /* log2 of the blocks in each entry */
    uint32_t count;
    double *sums; /* AIR_FILM_MAX_LEVELS * stride */
} air_block_stack;

void air_block_stack_push(air_block_stack *stack, const double *block);
void air_block_stack_total(air_block_stack *stack, double *out);

#endif
