#include <math.h>

#include "scene/import/mitsuba/mitsuba.h"

static air_status read_filter(const air_mitsuba *mitsuba, air_xml *at, air_film_hint *film)
{
    static const char *const types[] = {"box", "tent", "gaussian", "mitchell"};
    float stddev = 0.5f, third = 1.0f / 3.0f;
    film->filter = at == NULL || air_mitsuba_is(at, "gaussian") ? AIR_FILTER_GAUSSIAN
                   : air_mitsuba_is(at, "box")                  ? AIR_FILTER_BOX
                   : air_mitsuba_is(at, "tent")                 ? AIR_FILTER_TENT
                                                                : AIR_FILTER_MITCHELL;
    film->filter_radius = air_filter_radius_default(film->filter);
    if (at == NULL)
        return AIR_OK;
    at->asked = true;
    if (film->filter == AIR_FILTER_BOX || film->filter == AIR_FILTER_TENT)
        return air_mitsuba_float(mitsuba, at, "radius", &film->filter_radius);
    if (film->filter == AIR_FILTER_GAUSSIAN) {
        const air_status status = air_mitsuba_float(mitsuba, at, "stddev", &stddev);
        film->filter_radius = 3.0f * stddev; /* airlight's end at 3, Mitsuba's at 4 of them */
        return status;
    }
    if (!air_mitsuba_is(at, "mitchell"))
        return air_mitsuba_unknown_type(mitsuba, at, types, 4, "mitchell is taken");
    float b = third, c = third;
    air_status status = air_mitsuba_float(mitsuba, at, "B", &b);
    if (status == AIR_OK)
        status = air_mitsuba_float(mitsuba, at, "C", &c);
    if (status == AIR_OK && (fabsf(b - third) > 1e-3f || fabsf(c - third) > 1e-3f))
        status = air_mitsuba_warn(mitsuba, at, "B and C of 1/3 are taken, whatever it says");
    return status;
}

static air_status read_size(const air_mitsuba *mitsuba, air_xml *at, air_film_hint *film)
{
    static const char *const ignored[] = {"pixel_format",
                                          "component_format",
                                          "file_format",
                                          "banner",
                                          "gamma",
                                          "exposure",
                                          "attach_log",
                                          "high_quality_edges",
                                          "sample_border",
                                          "compensate",
                                          "tonemap_method",
                                          "filename",
                                          "label",
                                          "key",
                                          "burn"};
    long width = 768, height = 576, x = 0, y = 0;
    at->asked = true;
    air_mitsuba_ignore(at, ignored, sizeof ignored / sizeof *ignored);
    air_status status = air_mitsuba_integer_within(mitsuba, at, "width", 1, 65535, &width);
    if (status == AIR_OK)
        status = air_mitsuba_integer_within(mitsuba, at, "height", 1, 65535, &height);
    if (status == AIR_OK)
        status = air_mitsuba_integer_within(mitsuba, at, "crop_offset_x", 0, width - 1, &x);
    if (status == AIR_OK)
        status = air_mitsuba_integer_within(mitsuba, at, "crop_offset_y", 0, height - 1, &y);
    long crop_width = width - x, crop_height = height - y;
    if (status == AIR_OK)
        status = air_mitsuba_integer_within(mitsuba, at, "crop_width", 1, width - x, &crop_width);
    if (status == AIR_OK)
        status =
            air_mitsuba_integer_within(mitsuba, at, "crop_height", 1, height - y, &crop_height);
    film->width = (size_t)width;
    film->height = (size_t)height;
    film->crop[0] = (size_t)x;
    film->crop[1] = (size_t)y;
    film->crop[2] = (size_t)(x + crop_width);
    film->crop[3] = (size_t)(y + crop_height);
    return status;
}

air_status air_mitsuba_read_film(const air_mitsuba *mitsuba, const air_xml *sensor,
                                 air_film_hint *film)
{
    static const char *const ignored[] = {"seed", "scramble", "dimension", "depth"};
    air_xml *at = NULL, *filter = NULL, *sampler = NULL;
    long samples = 4;
    *film = (air_film_hint){
        .known = true, .width = 768, .height = 576, .crop = {0, 0, 768, 576}, .samples = 4};
    air_status status = air_mitsuba_child(mitsuba, sensor, "film", NULL, &at);
    if (status == AIR_OK && at != NULL)
        status = read_size(mitsuba, at, film);
    if (status == AIR_OK && at != NULL)
        status = air_mitsuba_child(mitsuba, at, "rfilter", NULL, &filter);
    if (status == AIR_OK)
        status = read_filter(mitsuba, filter, film);
    if (status == AIR_OK && !(film->filter_radius > 0.0f && film->filter_radius <= 16.0f))
        status = air_mitsuba_fail(mitsuba, filter, AIR_ERROR_FORMAT,
                                  "expected a filter that is wider than 0 and at most 16 pixels");
    if (status == AIR_OK)
        status = air_mitsuba_child(mitsuba, sensor, "sampler", NULL, &sampler);
    if (status == AIR_OK && sampler != NULL) {
        sampler->asked = true;
        air_mitsuba_ignore(sampler, ignored, sizeof ignored / sizeof *ignored);
        status = air_mitsuba_integer(mitsuba, sampler, "sample_count", &samples);
    }
    if (status == AIR_OK && samples < 1)
        status = air_mitsuba_fail(mitsuba, sampler, AIR_ERROR_FORMAT,
                                  "expected at least one sample, found %ld", samples);
    film->samples = (uint32_t)samples;
    return status;
}
