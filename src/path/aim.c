#include "path/aim.h"

#include "core/warp.h"

air_aim air_aim_make(const air_media *media, air_vec3 from)
{
    air_aim aim = {.count = 0};
    for (size_t i = 0; i < media->count && aim.count < AIR_AIM_MOST; i++) {
        const air_vec3 low = vec3_load(media->media[i].bounds_min);
        const air_vec3 high = vec3_load(media->media[i].bounds_max);
        const air_vec3 way = vec3_sub(vec3_scale(vec3_add(low, high), 0.5f), from);
        const float radius = 0.5f * vec3_length(vec3_sub(high, low)), distance = vec3_length(way);
        if (distance > radius && distance < INFINITY) { /* false for bounds without end */
            const float sine = radius / distance, cosine = sqrtf((1.0f - sine) * (1.0f + sine));
            aim.cones[aim.count].axis = vec3_scale(way, 1.0f / distance);
            aim.cones[aim.count++].opening = sine * sine / (1.0f + cosine);
        }
    }
    aim.share = aim.count > 0 ? 0.5f : 0.0f;
    return aim;
}

air_vec3 air_aim_sample(const air_aim *aim, const float u[3])
{
    const size_t drawn = (size_t)(u[0] * (float)aim->count);
    const size_t i = drawn < aim->count ? drawn : aim->count - 1;
    const air_frame frame = frame_from_normal(aim->cones[i].axis);
    return frame_to_world(&frame, sample_cone(u[1], u[2], aim->cones[i].opening));
}

float air_aim_sample_pdf(const air_aim *aim, air_vec3 dir)
{
    float pdf = 0.0f;
    for (size_t i = 0; i < aim->count; i++) {
        if (vec3_dot(dir, aim->cones[i].axis) >= 1.0f - aim->cones[i].opening) {
            pdf += sample_cone_pdf(aim->cones[i].opening) / (float)aim->count;
        }
    }
    return pdf;
}
