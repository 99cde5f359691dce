#include "sequence.h"

#include <math.h>

static const double rad_per_deg = 3.14159265358979323846 / 180.0;

/* Freezes the scene as it is. */
static air_status commit(cli_sequence *sequence)
{
    air_snapshot *snapshot = NULL;
    uint32_t dirty = 0;
    const air_status status = air_scene_commit(sequence->scene, &snapshot, &dirty);
    if (status == AIR_OK) {
        air_snapshot_release(sequence->snapshot);
        sequence->snapshot = snapshot;
        sequence->dirty |= dirty;
    }
    return status;
}

cli_exit cli_sequence_open(cli_host *host, const char *path, const cli_scene_options *options,
                           int64_t frame, cli_sequence *out)
{
    const cli_exit result = cli_scene_load(host, path, options, frame, &out->scene);
    return result == CLI_OK ? cli_host_exit(host, commit(out), path) : result;
}

void cli_sequence_close(cli_sequence *sequence)
{
    air_snapshot_release(sequence->snapshot);
    air_scene_destroy(sequence->scene);
    *sequence = (cli_sequence){0};
}

cli_exit cli_sequence_set_camera(cli_host *host, const cli_camera *camera, const cli_real *orbit,
                                 cli_sequence *sequence)
{
    sequence->camera = camera->handle;
    sequence->orbits = orbit->set;
    sequence->orbit_deg = orbit->value;
    const air_status status =
        air_snapshot_camera_desc(sequence->snapshot, camera->handle, &sequence->still);
    sequence->still.name = camera->name; /* the snapshot's does not last */
    return cli_host_exit(host, status, "the camera");
}

/* ---- turning the camera ---- */

static bool bounded(const float low[3], const float high[3])
{
    return low[0] <= high[0] && low[1] <= high[1] && low[2] <= high[2];
}

/* What the camera turns around. */
static cli_exit find_centre(cli_host *host, const air_snapshot *snapshot, double out_centre[3])
{
    air_scene_info info;
    air_snapshot_info(snapshot, &info);
    const bool media = bounded(info.media_min, info.media_max);
    const float *const low = media ? info.media_min : info.bounds_min;
    const float *const high = media ? info.media_max : info.bounds_max;
    if (!bounded(low, high)) {
        cli_say(&host->progress, AIR_MESSAGE_ERROR,
                "--orbit: expected a medium with bounds or a mesh in the scene to turn around");
        return CLI_FAILED;
    }
    for (size_t k = 0; k < 3; k++) {
        out_centre[k] = 0.5 * ((double)low[k] + (double)high[k]);
    }
    return CLI_OK;
}

/* Turns a map about the axis through the centre along +Y, counterclockwise as seen from above. */
static void turn(double angle_rad, const double centre[3], float to_world[12])
{
    const double c = cos(angle_rad), s = sin(angle_rad);
    for (size_t column = 0; column < 4; column++) {
        const double origin_x = column == 3 ? centre[0] : 0.0;
        const double origin_z = column == 3 ? centre[2] : 0.0;
        const double x = (double)to_world[column] - origin_x;
        const double z = (double)to_world[8 + column] - origin_z;
        to_world[column] = (float)(origin_x + c * x + s * z);
        to_world[8 + column] = (float)(origin_z - s * x + c * z);
    }
}

/* The snapshot is that of the frame with the camera where it was. */
static cli_exit turn_camera(cli_host *host, cli_sequence *sequence, int64_t frame)
{
    double centre[3];
    const cli_exit result = find_centre(host, sequence->snapshot, centre);
    if (result != CLI_OK) {
        return result;
    }
    const bool framed = sequence->camera == AIR_NONE;
    air_camera_desc desc = sequence->still;
    air_status status = AIR_OK;
    if (framed) {
        status = air_snapshot_camera_desc(sequence->snapshot, AIR_NONE, &desc);
    }
    const double angle_deg = fmod(sequence->orbit_deg * (double)frame, 360.0);
    turn(angle_deg * rad_per_deg, centre, desc.to_world);
    if (status == AIR_OK) {
        status = framed ? air_scene_add_camera(sequence->scene, &desc, &sequence->turned)
                        : air_scene_set_camera(sequence->scene, sequence->camera, &desc);
    }
    if (status == AIR_OK) {
        status = commit(sequence);
    }
    return cli_host_exit(host, status, "turning the camera");
}

cli_exit cli_sequence_move(cli_host *host, cli_sequence *sequence, int64_t frame)
{
    air_status status = AIR_OK;
    if (sequence->turned != AIR_NONE) {
        status = air_scene_remove(sequence->scene, sequence->turned);
        sequence->turned = AIR_NONE;
    }
    if (status == AIR_OK) {
        status = air_scene_set_frame(sequence->scene, frame);
    }
    if (status == AIR_OK) {
        status = commit(sequence);
    }
    if (status != AIR_OK || !sequence->orbits) {
        return cli_host_exit(host, status, "the next frame");
    }
    return turn_camera(host, sequence, frame);
}

air_handle cli_sequence_camera(const cli_sequence *sequence)
{
    return sequence->turned != AIR_NONE ? sequence->turned : sequence->camera;
}
