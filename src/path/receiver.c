#include "path/receiver.h"

#include "core/warp.h"

float air_receiver_sample_pdf(const air_path_receiver *receiver, air_vec3 dir)
{
    if (receiver->sphere) {
        return sample_sphere_pdf();
    }
    const float cosine = vec3_dot(receiver->normal, dir);
    if (cosine <= 0.0f || vec3_dot(receiver->geometric, dir) <= 0.0f) {
        return 0.0f;
    }
    return (1.0f - receiver->uniform) * sample_cosine_hemisphere_pdf(cosine) +
           receiver->uniform * (0.5f / AIR_PI_F);
}

/* z even in [0, 1] instead of its square root: the hemisphere uniform in solid angle. */
static air_vec3 uniform_hemisphere(float u1, float u2)
{
    const air_vec3 d = sample_disk_concentric(u1, u2);
    const float r2 = d.x * d.x + d.y * d.y;
    const float stretch = sqrtf(float_max(0.0f, 2.0f - r2));
    return vec3(d.x * stretch, d.y * stretch, 1.0f - r2);
}

bool air_receiver_sample(const air_path_receiver *receiver, air_f32x4 u, air_vec3 *out_dir,
                         float *out_pdf)
{
    if (receiver->sphere) {
        *out_dir = sample_sphere(u[0], u[1]);
    } else {
        const air_frame frame = frame_from_normal(receiver->normal);
        *out_dir =
            frame_to_world(&frame, u[2] < receiver->uniform ? uniform_hemisphere(u[0], u[1])
                                                            : sample_cosine_hemisphere(u[0], u[1]));
    }
    *out_pdf = air_receiver_sample_pdf(receiver, *out_dir);
    return *out_pdf > 0.0f;
}
