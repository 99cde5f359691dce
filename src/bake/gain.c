#include "bake/gain.h"

#include "core/harmonics.h"
#include "path/receiver.h"

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
    if (lane->left) {
        const float weight = 1.0f / air_receiver_sample_pdf(receiver, lane->dir);
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
    return !snapshot->materials[mesh->material].double_sided &&
           (mesh->flip ? along < 0.0f : along > 0.0f);
}
