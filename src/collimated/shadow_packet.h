/* shadow_packet.h: the way of several rays together through the cells of a shadow tree: each step
 * is taken for all of them at once, one per lane, and so is the test of a triangle. Rays of one
 * packet run the same way through the plane, so that all meet a cell's children in the same order.
 * Each ray finds what it would find alone, to the bit. Included by one file per instruction set. */
#ifndef AIR_COLLIMATED_SHADOW_PACKET_H
#define AIR_COLLIMATED_SHADOW_PACKET_H

#include <immintrin.h>
#include <math.h>
#include <string.h>

#include "collimated/shadow_tree.h"

/* ---- as many floats as the instruction set has lanes ---- */

#if defined(__AVX512F__) && defined(__AVX512DQ__)

enum { RAY_LANES = 16 };
typedef __m512 rays;
typedef __mmask16 ray_mask;
static inline rays rays_all(float x) { return _mm512_set1_ps(x); }
static inline rays rays_min(rays a, rays b) { return _mm512_min_ps(a, b); }
static inline rays rays_max(rays a, rays b) { return _mm512_max_ps(a, b); }
static inline ray_mask rays_less(rays a, rays b) { return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ); }
static inline ray_mask mask_and(ray_mask a, ray_mask b) { return a & b; }
static inline ray_mask mask_or(ray_mask a, ray_mask b) { return a | b; }
static inline ray_mask mask_xor(ray_mask a, ray_mask b) { return a ^ b; }
static inline ray_mask mask_and_not(ray_mask a, ray_mask b) { return (ray_mask)(a & ~b); }
static inline unsigned mask_bits(ray_mask a) { return a; }
static inline ray_mask mask_of_bits(unsigned bits) { return (ray_mask)bits; }
static inline rays rays_select(ray_mask mask, rays a, rays b)
{
    return _mm512_mask_blend_ps(mask, b, a);
}

#elif defined(__AVX2__)

enum { RAY_LANES = 8 };
typedef __m256 rays;
typedef __m256 ray_mask;
static inline rays rays_all(float x) { return _mm256_set1_ps(x); }
static inline rays rays_min(rays a, rays b) { return _mm256_min_ps(a, b); }
static inline rays rays_max(rays a, rays b) { return _mm256_max_ps(a, b); }
static inline ray_mask rays_less(rays a, rays b) { return _mm256_cmp_ps(a, b, _CMP_LT_OQ); }
static inline ray_mask mask_and(ray_mask a, ray_mask b) { return _mm256_and_ps(a, b); }
static inline ray_mask mask_or(ray_mask a, ray_mask b) { return _mm256_or_ps(a, b); }
static inline ray_mask mask_xor(ray_mask a, ray_mask b) { return _mm256_xor_ps(a, b); }
static inline ray_mask mask_and_not(ray_mask a, ray_mask b) { return _mm256_andnot_ps(b, a); }
static inline unsigned mask_bits(ray_mask a) { return (unsigned)_mm256_movemask_ps(a); }
static inline ray_mask mask_of_bits(unsigned bits)
{
    const __m256i each = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    const __m256i set = _mm256_and_si256(_mm256_set1_epi32((int)bits), each);
    return _mm256_castsi256_ps(_mm256_cmpeq_epi32(set, each));
}
static inline rays rays_select(ray_mask mask, rays a, rays b)
{
    return _mm256_blendv_ps(b, a, mask);
}

#else

enum { RAY_LANES = 4 };
typedef __m128 rays;
typedef __m128 ray_mask;
static inline rays rays_all(float x) { return _mm_set1_ps(x); }
static inline rays rays_min(rays a, rays b) { return _mm_min_ps(a, b); }
static inline rays rays_max(rays a, rays b) { return _mm_max_ps(a, b); }
static inline ray_mask rays_less(rays a, rays b) { return _mm_cmplt_ps(a, b); }
static inline ray_mask mask_and(ray_mask a, ray_mask b) { return _mm_and_ps(a, b); }
static inline ray_mask mask_or(ray_mask a, ray_mask b) { return _mm_or_ps(a, b); }
static inline ray_mask mask_xor(ray_mask a, ray_mask b) { return _mm_xor_ps(a, b); }
static inline ray_mask mask_and_not(ray_mask a, ray_mask b) { return _mm_andnot_ps(b, a); }
static inline unsigned mask_bits(ray_mask a) { return (unsigned)_mm_movemask_ps(a); }
static inline ray_mask mask_of_bits(unsigned bits)
{
    const __m128i each = _mm_setr_epi32(1, 2, 4, 8);
    const __m128i set = _mm_and_si128(_mm_set1_epi32((int)bits), each);
    return _mm_castsi128_ps(_mm_cmpeq_epi32(set, each));
}
static inline rays rays_select(ray_mask mask, rays a, rays b) { return _mm_blendv_ps(b, a, mask); }

#endif

static inline float lane_of(const rays *v, int lane)
{
    float out;
    memcpy(&out, (const char *)v + 4 * lane, sizeof out);
    return out;
}

/* ---- packets ---- */

/* The rays' fields side by side; lanes without a ray are empty from the start. */
typedef struct shadow_packet {
    rays x, y, z;
    rays wx, wy;
    rays s, c;
    rays inverse_s, inverse_c;
    rays qx, qy;
    rays inverse_qx, inverse_qy;
    rays begin, end;
    bool right, up;  /* of all */
    ray_mask rising; /* c >= 0 */
    ray_mask steep;  /* nearly parallel to the light */
    /* What was found last along each ray: it mostly grows. Empty while its begin is above its end.
     */
    rays tail_begin, tail_end;
    shadow_list *lists; /* [lane] */
} shadow_packet;

static inline void shadow_packet_flush(shadow_packet *packet, unsigned which)
{
    for (; which != 0; which &= which - 1) {
        const int lane = __builtin_ctz(which);
        const float begin = lane_of(&packet->tail_begin, lane);
        const float end = lane_of(&packet->tail_end, lane);
        if (begin <= end) {
            shadow_list_add(&packet->lists[lane], begin, end);
        }
    }
}

static inline void shadow_packet_add(shadow_packet *packet, rays begin, rays end, ray_mask which)
{
    /* touching: begin <= tail_end and tail_begin <= end */
    const ray_mask apart = mask_and(
        which, mask_or(rays_less(packet->tail_end, begin), rays_less(end, packet->tail_begin)));
    if (mask_bits(apart) != 0) {
        shadow_packet_flush(packet, mask_bits(apart));
        packet->tail_begin = rays_select(apart, begin, packet->tail_begin);
        packet->tail_end = rays_select(apart, end, packet->tail_end);
    }
    packet->tail_begin =
        rays_select(which, rays_min(packet->tail_begin, begin), packet->tail_begin);
    packet->tail_end = rays_select(which, rays_max(packet->tail_end, end), packet->tail_end);
}

/* ---- a triangle before the rays, as shadow_walk.c does it for one ---- */

typedef struct ray_corner {
    rays side, along, above, height;
} ray_corner;

static inline ray_corner rays_see_corner(const shadow_packet *packet,
                                         const shadow_triangle *triangle, int k)
{
    const rays x = rays_all(triangle->x[k]) - packet->x;
    const rays y = rays_all(triangle->y[k]) - packet->y;
    ray_corner out;
    out.height = rays_all(triangle->z[k]) - packet->z;
    out.side = x * packet->wy - y * packet->wx;
    out.along = x * packet->wx + y * packet->wy;
    out.above = out.height * packet->s - out.along * packet->c;
    return out;
}

static inline ray_corner rays_select_corner(ray_mask mask, const ray_corner *yes,
                                            const ray_corner *no)
{
    return (ray_corner){
        rays_select(mask, yes->side, no->side), rays_select(mask, yes->along, no->along),
        rays_select(mask, yes->above, no->above), rays_select(mask, yes->height, no->height)};
}

static inline ray_corner rays_meet_plane(const ray_corner *a, const ray_corner *b)
{
    const rays d = b->side - a->side;
    return (ray_corner){.along = (a->along * b->side - b->along * a->side) / d,
                        .above = (a->above * b->side - b->above * a->side) / d};
}

static inline rays rays_meet_height(const ray_corner *a, const ray_corner *b)
{
    return (a->height * b->side - b->height * a->side) / (b->side - a->side);
}

static inline void shadow_test_rays(shadow_packet *packet, const shadow_triangle *triangle,
                                    rays begin, rays end, ray_mask live)
{
    const rays zero = rays_all(0.0f);
    const ray_corner c0 = rays_see_corner(packet, triangle, 0);
    const ray_corner c1 = rays_see_corner(packet, triangle, 1);
    const ray_corner c2 = rays_see_corner(packet, triangle, 2);
    const ray_mask s0 = rays_less(c0.side, zero), s1 = rays_less(c1.side, zero);
    const ray_mask s2 = rays_less(c2.side, zero);
    const ray_mask not2 = mask_xor(s0, s1), not1 = mask_xor(s0, s2);
    ray_mask hit = mask_and(live, mask_or(not2, not1));
    if (mask_bits(hit) == 0) {
        return;
    }
    /* i is alone on its side; the order of j and k is that of shadow_walk.c */
    const ray_mask lone0 = mask_and(not1, not2), lone1 = mask_and_not(not2, not1);
    ray_corner i = rays_select_corner(lone1, &c1, &c2);
    i = rays_select_corner(lone0, &c0, &i);
    const ray_corner j = rays_select_corner(lone0, &c1, &c0);
    const ray_corner k = rays_select_corner(not2, &c2, &c1);
    const ray_corner p = rays_meet_plane(&i, &j), q = rays_meet_plane(&i, &k);
    const ray_mask p_above = rays_less(zero, p.above), q_above = rays_less(zero, q.above);
    hit = mask_and(hit, mask_or(p_above, q_above));
    if (mask_bits(hit) == 0) {
        return;
    }
    const rays f = p.above / (p.above - q.above);
    const rays along = p.along + f * (q.along - p.along);
    rays t_cross = along * packet->inverse_s;
    if (mask_bits(mask_and(packet->steep, hit)) != 0) {
        const rays p_height = rays_meet_height(&i, &j), q_height = rays_meet_height(&i, &k);
        t_cross = rays_select(
            packet->steep, along * packet->s + (p_height + f * (q_height - p_height)) * packet->c,
            t_cross);
    }
    const rays t_p = rays_select(p_above, p.along * packet->inverse_s, t_cross);
    const rays t_q = rays_select(q_above, q.along * packet->inverse_s, t_cross);
    const ray_mask order = rays_less(t_p, t_q);
    const rays low = rays_select(order, t_p, t_q), high = rays_select(order, t_q, t_p);
    const rays t0 = rays_select(rays_less(begin, low), low, begin);
    const rays t1 = rays_select(rays_less(high, end), high, end);
    hit = mask_and(hit, rays_less(t0, t1));
    if (mask_bits(hit) != 0) {
        shadow_packet_add(packet, t0, t1, hit);
    }
}

/* ---- the walk ---- */

/* The parts of the rays in a cell, waiting for their turn; those of rays not in live mean nothing.
 */
typedef struct shadow_packet_visit {
    rays begin, end;
    float x, y, half;
    int32_t node;
    ray_mask live;
} shadow_packet_visit;

/* Puts a child on the stack where some ray passes it. */
static inline shadow_packet_visit *shadow_packet_push(const shadow_packet_visit *parent,
                                                      int32_t first, unsigned k, rays begin,
                                                      rays end, shadow_packet_visit *top)
{
    const ray_mask live = mask_and(parent->live, rays_less(begin, end));
    if (mask_bits(live) != 0) {
        const float quarter = 0.5f * parent->half;
        top->begin = begin;
        top->end = end;
        top->x = parent->x + ((k & 1u) != 0 ? quarter : -quarter);
        top->y = parent->y + ((k & 2u) != 0 ? quarter : -quarter);
        top->half = quarter;
        top->node = first + (int32_t)k;
        top->live = live;
        top++;
    }
    return top;
}

/* The near child comes first, the far one last; of the two at the sides no ray meets both. */
static inline shadow_packet_visit *shadow_packet_divide(const shadow_packet *packet,
                                                        const shadow_packet_visit *visit,
                                                        int32_t first, shadow_packet_visit *top)
{
    const rays tx = (rays_all(visit->x) - packet->qx) * packet->inverse_qx;
    const rays ty = (rays_all(visit->y) - packet->qy) * packet->inverse_qy;
    const rays after_x = rays_max(tx, visit->begin), before_x = rays_min(tx, visit->end);
    const rays after_y = rays_max(ty, visit->begin), before_y = rays_min(ty, visit->end);
    const unsigned near = (packet->right ? 0u : 1u) | (packet->up ? 0u : 2u);
    top = shadow_packet_push(visit, first, near ^ 3u, rays_max(after_x, ty), visit->end, top);
    top = shadow_packet_push(visit, first, near ^ 2u, after_y, before_x, top);
    top = shadow_packet_push(visit, first, near ^ 1u, after_x, before_y, top);
    return shadow_packet_push(visit, first, near, visit->begin, rays_min(before_x, ty), top);
}

/* As shadow_visit_leaf. */
static inline void shadow_packet_leaf(const air_shadow_tree *tree, const shadow_node *node,
                                      shadow_packet *packet, const shadow_packet_visit *visit)
{
    const rays begin = visit->begin, end = visit->end;
    const rays to_low = (rays_all(node->low) - packet->z) * packet->inverse_c;
    const rays to_high = (rays_all(node->high) - packet->z) * packet->inverse_c;
    const rays from = rays_select(packet->rising, to_low, to_high);
    const rays to = rays_select(packet->rising, to_high, to_low);
    const rays inner_begin = rays_max(begin, rays_min(from, end));
    const rays inner_end = rays_min(end, rays_max(to, begin));
    const ray_mask first =
        mask_and(mask_and(visit->live, packet->rising), rays_less(begin, inner_begin));
    const ray_mask last =
        mask_and(mask_and_not(visit->live, packet->rising), rays_less(inner_end, end));
    const ray_mask inner = mask_and(visit->live, rays_less(inner_begin, inner_end));
    if (mask_bits(first) != 0) {
        shadow_packet_add(packet, begin, inner_begin, first);
    }
    if (mask_bits(inner) != 0) {
        const shadow_triangle *triangles = tree->triangles + ~node->first;
        for (int32_t i = 0; i < node->triangle_count; i++) {
            shadow_test_rays(packet, &triangles[i], inner_begin, inner_end, inner);
        }
    }
    if (mask_bits(last) != 0) {
        shadow_packet_add(packet, inner_end, end, last);
    }
}

static inline void shadow_traverse_packet(const air_shadow_tree *tree, shadow_packet *packet)
{
    shadow_packet_visit stack[SHADOW_STACK];
    shadow_packet_visit *top = stack;
    *top++ = (shadow_packet_visit){
        packet->begin, packet->end, 0.5f, 0.5f, 0.5f, 0, rays_less(packet->begin, packet->end)};
    while (top > stack) {
        shadow_packet_visit visit = *--top;
        const shadow_node *node = &tree->nodes[visit.node];
        const rays z0 = packet->z + packet->c * visit.begin;
        const rays z1 = packet->z + packet->c * visit.end;
        const rays lower = rays_min(z0, z1), upper = rays_max(z0, z1);
        visit.live = mask_and(visit.live, rays_less(lower, rays_all(node->high)));
        const ray_mask open = rays_less(rays_all(node->low), upper);
        const ray_mask shadowed = mask_and_not(visit.live, open);
        if (mask_bits(shadowed) != 0) {
            shadow_packet_add(packet, visit.begin, visit.end, shadowed);
        }
        visit.live = mask_and(visit.live, open);
        if (mask_bits(visit.live) == 0) {
            continue;
        }
        if (node->first >= 0) {
            top = shadow_packet_divide(packet, &visit, node->first, top);
        } else {
            shadow_packet_leaf(tree, node, packet, &visit);
        }
    }
    shadow_packet_flush(packet, (1u << RAY_LANES) - 1u);
}

/* ---- making packets ---- */

enum { PACKET_FIELDS = 15 };

/* Walks those of count rays, at most RAY_LANES, whose bits are set; they run the same way. */
static inline void shadow_walk_alike(const air_shadow_tree *tree, const shadow_ray *of,
                                     size_t count, unsigned which, shadow_list *lists)
{
    float values[PACKET_FIELDS][RAY_LANES] = {{0}};
    for (size_t i = 0; i < count; i++) {
        const shadow_ray *r = &of[i];
        const bool in = (which >> i & 1u) != 0;
        const float of_ray[PACKET_FIELDS] = {r->x,
                                             r->y,
                                             r->z,
                                             r->wx,
                                             r->wy,
                                             r->s,
                                             r->c,
                                             r->inverse_s,
                                             r->inverse_c,
                                             r->qx,
                                             r->qy,
                                             r->inverse_qx,
                                             r->inverse_qy,
                                             in ? r->begin : 0.0f,
                                             in ? r->end : 0.0f};
        for (int k = 0; k < PACKET_FIELDS; k++) {
            values[k][i] = of_ray[k];
        }
    }
    shadow_packet packet;
    memcpy(&packet, values, sizeof values);
    packet.right = of[__builtin_ctz(which)].right;
    packet.up = of[__builtin_ctz(which)].up;
    packet.rising = mask_and_not(mask_of_bits(~0u), rays_less(packet.c, rays_all(0.0f)));
    packet.steep = rays_less(packet.s, rays_all(0.1f));
    packet.tail_begin = rays_all(INFINITY);
    packet.tail_end = rays_all(-INFINITY);
    packet.lists = lists;
    shadow_traverse_packet(tree, &packet);
}

static inline void shadow_walk_packets(const air_shadow_tree *tree, const shadow_ray *of,
                                       size_t count, shadow_list *lists)
{
    for (size_t i = 0; i < count; i += RAY_LANES) {
        const size_t n = count - i < RAY_LANES ? count - i : RAY_LANES;
        unsigned ways[4] = {0};
        for (size_t k = 0; k < n; k++) {
            ways[of[i + k].right + 2 * of[i + k].up] |= 1u << k;
        }
        for (int way = 0; way < 4; way++) {
            if (ways[way] != 0) {
                shadow_walk_alike(tree, of + i, n, ways[way], lists + i);
            }
        }
    }
}

#endif
