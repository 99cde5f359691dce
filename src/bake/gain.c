#include "bake/gain.h"

#include "core/harmonics.h"
#include "path/receiver.h"
#include "scene/material.h"

/* Light of radiance over density from one direction. */
static void add_light(air_gain *gain, const air_path_receiver *receiver, air_light_layer layer,
                      air_vec3 dir, air_vec3 value, size_t count, air_vec3 *irradiance)
{
    if (vec3_is_zero(value)) {
        return;
    }
    const float cosine = receiver->sphere ? 1.0f : float_max(vec3_dot(receiver->normal, dir), 0.0f);
    *irradiance = vec3_madd(*irradiance, cosine, value);
    if (count > 0) {
        const float at[3] = {dir.x, dir.y, dir.z};
        float y[AIR_PROBE_COEFFICIENTS];
        air_sh_evaluate_3(at, y);
        for (size_t i = 0; i < count; i++) {
            double *sum = gain->harmonics[layer][i];
            sum[0] += (double)(value.x * y[i]);
            sum[1] += (double)(value.y * y[i]);
            sum[2] += (double)(value.z * y[i]);
        }
    }
}

static void add_layer(air_gain *gain, air_light_layer layer, air_vec3 irradiance)
{
    const double luminance = (double)vec3_luminance(irradiance);
    gain->layers[layer][0] += (double)irradiance.x;
    gain->layers[layer][1] += (double)irradiance.y;
    gain->layers[layer][2] += (double)irradiance.z;
    gain->squares[layer] += luminance * luminance;
}

/* ---- irradiance of axes ---- */

static air_vec3 corner(size_t i)
{
    /* (0, +-1, +-phi) and its rotations, phi the golden ratio, of unit length */
    const float a = 0.52573111f, b = 0.85065081f;
    const float s = i & 1u ? -a : a, t = i & 2u ? -b : b;
    return i / 4 == 0 ? vec3(0.0f, s, t) : i / 4 == 1 ? vec3(t, 0.0f, s) : vec3(s, t, 0.0f);
}

enum { CORNERS = 12 };

void air_gain_set_axes(air_path_receiver *receiver, size_t coefficients,
                       air_vec3 axes[AIR_GAIN_AXES])
{
    receiver->axes = axes;
    receiver->axis_count = 0;
    if (!receiver->sphere) {
        axes[receiver->axis_count++] = receiver->normal;
    }
    for (size_t i = 0; coefficients > 0 && i < CORNERS; i++) {
        axes[receiver->axis_count++] = corner(i);
    }
}

/* Adds light that is known by the irradiance on the axes only. Band l of irradiance is A_l n_l
 * times that of radiance; A_l n_l = pi, 2 pi / 3, pi / 4. */
static void add_axes(air_gain *gain, const air_path_receiver *receiver, const air_vec3 *values,
                     size_t count, air_vec3 *irradiance)
{
    const float inverse[3] = {1.0f / AIR_PI_F, 1.5f / AIR_PI_F, 4.0f / AIR_PI_F};
    const size_t own = receiver->sphere ? 0 : 1;
    if (own > 0) {
        *irradiance = vec3_add(*irradiance, values[0]);
    }
    for (size_t k = 0; count > 0 && k < CORNERS; k++) {
        const air_vec3 axis = receiver->axes[own + k], value = values[own + k];
        const float at[3] = {axis.x, axis.y, axis.z};
        float y[AIR_PROBE_COEFFICIENTS];
        air_sh_evaluate_3(at, y);
        for (size_t i = 0; i < count; i++) {
            const float weight =
                y[i] * (4.0f * AIR_PI_F / CORNERS) * inverse[air_sh_band_3((int)i)];
            double *sum = gain->harmonics[AIR_LAYER_MEDIA][i];
            sum[0] += (double)(value.x * weight);
            sum[1] += (double)(value.y * weight);
            sum[2] += (double)(value.z * weight);
        }
        if (own == 0) {
            /* fluence is four times the mean of irradiance over all normals */
            *irradiance = vec3_madd(*irradiance, 4.0f / CORNERS, value);
        }
    }
}

static float over(float a, float b) { return b > 1e-12f ? a / b : 0.0f; }

/* Light that media scattered next to the receiver, from responses (air_path_respond). */
static void add_responses(air_gain *gain, const air_path_lane *lane, float weight, size_t count,
                          air_vec3 *irradiance)
{
    const air_path_receiver *receiver = lane->receiver;
    air_vec3 values[AIR_RECEIVER_AXES];
    if (lane->lit_share > 0.0f) {
        for (size_t k = 0; k < receiver->axis_count; k++) {
            values[k] = vec3_scale(lane->lit[k], lane->lit_share);
        }
        add_axes(gain, receiver, values, count, irradiance);
    }
    if (lane->left && !vec3_is_zero(lane->first)) {
        const air_vec3 at_end = vec3_add(lane->terms[AIR_TERM_S_PLUS], lane->terms[AIR_TERM_M2]);
        const air_vec3 radiance =
            vec3(over(at_end.x, lane->first.x) * weight, over(at_end.y, lane->first.y) * weight,
                 over(at_end.z, lane->first.z) * weight);
        for (size_t k = 0; k < receiver->axis_count; k++) {
            values[k] = vec3_mul(lane->patch[k], radiance);
        }
        add_axes(gain, receiver, values, count, irradiance);
    }
}

void air_gain_add(air_gain *gain, const air_path_lane *lane, size_t count)
{
    const air_path_receiver *receiver = lane->receiver;
    const air_vec3 *terms = lane->terms;
    air_vec3 sums[AIR_LAYER_COUNT] = {{0.0f, 0.0f, 0.0f}};
    gain->samples += 1.0;
    add_light(gain, receiver, AIR_LAYER_DIRECT, lane->connected_dir, lane->connected, count,
              &sums[AIR_LAYER_DIRECT]);
    add_light(gain, receiver, AIR_LAYER_MEDIA, lane->through_dir, lane->through, count,
              &sums[AIR_LAYER_MEDIA]);
    const float along = lane->left ? 1.0f / air_receiver_sample_pdf(receiver, lane->dir) : 0.0f;
    if (receiver->axis_count > 0) {
        add_responses(gain, lane, along, count, &sums[AIR_LAYER_MEDIA]);
    }
    if (lane->left) {
        const float weight = along;
        const air_vec3 media = vec3_add(terms[AIR_TERM_M1], terms[AIR_TERM_M2]);
        add_light(gain, receiver, AIR_LAYER_DIRECT, lane->dir,
                  vec3_scale(terms[AIR_TERM_S0], weight), count, &sums[AIR_LAYER_DIRECT]);
        add_light(gain, receiver, AIR_LAYER_INDIRECT, lane->dir,
                  vec3_scale(terms[AIR_TERM_S_PLUS], weight), count, &sums[AIR_LAYER_INDIRECT]);
        add_light(gain, receiver, AIR_LAYER_MEDIA, lane->dir, vec3_scale(media, weight), count,
                  &sums[AIR_LAYER_MEDIA]);
    }
    for (int layer = 0; layer < AIR_LAYER_COUNT; layer++) {
        add_layer(gain, (air_light_layer)layer, sums[layer]);
    }
}

void air_gain_merge(air_gain *gain, const air_gain *other, size_t count)
{
    gain->samples += other->samples;
    for (int layer = 0; layer < AIR_LAYER_COUNT; layer++) {
        gain->squares[layer] += other->squares[layer];
        for (int c = 0; c < 3; c++) {
            gain->layers[layer][c] += other->layers[layer][c];
            for (size_t i = 0; i < count; i++) {
                gain->harmonics[layer][i][c] += other->harmonics[layer][i][c];
            }
        }
    }
}

bool air_gain_is_buried(const air_snapshot *snapshot, const air_path_lane *lane)
{
    if (!lane->left || lane->hit.mesh == (uint32_t)AIR_NO_HIT) {
        return false;
    }
    const air_mesh *mesh = snapshot->meshes[lane->hit.mesh];
    const float along = vec3_dot(vec3_load(lane->hit.normal), lane->dir);
    const air_material *material = &snapshot->materials[mesh->material];
    return !material->double_sided && !air_material_lets_through(material) &&
           material->alpha_mode == AIR_ALPHA_OPAQUE && (mesh->flip ? along < 0.0f : along > 0.0f);
}
