#include <math.h>
#include <string.h>

#include "core/vec.h"
#include "scene/import/mitsuba/mitsuba.h"

/* 3 rows of 4, in double: long chains of operations are rounded once. */
static const double identity[12] = {1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0};

static void set_diagonal(const double scale[3], double out[12])
{
    memcpy(out, identity, sizeof identity);
    for (size_t i = 0; i < 3; ++i)
        out[5 * i] = scale[i];
}

/* out = a after out */
static void apply(const double a[12], double out[12])
{
    double product[12];
    for (size_t row = 0; row < 3; ++row)
        for (size_t column = 0; column < 4; ++column)
            product[4 * row + column] =
                a[4 * row] * out[column] + a[4 * row + 1] * out[4 + column] +
                a[4 * row + 2] * out[8 + column] + (column == 3 ? a[4 * row + 3] : 0.0);
    memcpy(out, product, sizeof product);
}

static bool normalize(double v[3])
{
    const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (size_t i = 0; i < 3; ++i)
        v[i] /= length;
    return length > 1e-30 && isfinite(length);
}

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* [Rodrigues1840]: v cos + (a x v) sin + a (a . v) (1 - cos) */
static air_status rotate(const air_mitsuba *mitsuba, const air_xml *at, double out[12])
{
    double axis[3] = {0.0, 0.0, 0.0}, angle = 0.0;
    size_t count = 0;
    air_status status = air_mitsuba_read_vector(mitsuba, at, axis);
    if (status == AIR_OK)
        status = air_mitsuba_numbers(mitsuba, at, "angle", 1, &angle, &count);
    if (status != AIR_OK)
        return status;
    if (!normalize(axis))
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT, "expected an axis that is not 0");
    const double s = sin(angle * (AIR_PI / 180.0)), c = cos(angle * (AIR_PI / 180.0));
    for (size_t column = 0; column < 3; ++column) {
        double unit[3] = {0.0, 0.0, 0.0}, across[3];
        unit[column] = 1.0;
        cross(axis, unit, across);
        for (size_t row = 0; row < 3; ++row)
            out[4 * row + column] =
                unit[row] * c + across[row] * s + axis[row] * axis[column] * (1.0 - c);
    }
    return AIR_OK;
}

static air_status read_triple(const air_mitsuba *mitsuba, const air_xml *at, const char *attribute,
                              double out[3])
{
    size_t count = 0;
    const air_status status = air_mitsuba_numbers(mitsuba, at, attribute, 3, out, &count);
    if (status == AIR_OK && count != 3)
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                "expected three numbers as %s, found %zu", attribute, count);
    return status;
}

/* +Z goes to the target, +Y up, and so +X to the left. */
static air_status look_at(const air_mitsuba *mitsuba, const air_xml *at, double out[12])
{
    double origin[3], target[3], up[3] = {0.0, 0.0, 0.0}, left[3], dir[3];
    air_status status = read_triple(mitsuba, at, "origin", origin);
    if (status == AIR_OK)
        status = read_triple(mitsuba, at, "target", target);
    if (status == AIR_OK && air_xml_attribute_of(at, "up") != NULL)
        status = read_triple(mitsuba, at, "up", up);
    if (status != AIR_OK)
        return status;
    for (size_t i = 0; i < 3; ++i)
        dir[i] = target[i] - origin[i];
    if (!normalize(dir))
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                "expected a target that is not the origin");
    if (up[0] == 0.0 && up[1] == 0.0 && up[2] == 0.0)
        up[fabs(dir[1]) < 0.9 ? 1 : 2] = 1.0;
    cross(up, dir, left);
    if (!normalize(left))
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                "expected up not to be parallel to the direction of view");
    cross(dir, left, up);
    for (size_t i = 0; i < 3; ++i) {
        out[4 * i] = left[i];
        out[4 * i + 1] = up[i];
        out[4 * i + 2] = dir[i];
        out[4 * i + 3] = origin[i];
    }
    return AIR_OK;
}

static air_status matrix(const air_mitsuba *mitsuba, const air_xml *at, double out[12])
{
    double m[16];
    size_t count = 0;
    const air_status status = air_mitsuba_numbers(mitsuba, at, "value", 16, m, &count);
    if (status != AIR_OK)
        return status;
    if (count != 16 && count != 9)
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                "expected 16 numbers or 9 as value, found %zu", count);
    if (count == 16 && (m[12] != 0.0 || m[13] != 0.0 || m[14] != 0.0 || m[15] != 1.0))
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_UNSUPPORTED,
                                "expected 0 0 0 1 as the last row of the matrix");
    const size_t width = count == 16 ? 4 : 3;
    for (size_t row = 0; row < 3; ++row)
        memcpy(out + 4 * row, m + width * row, width * sizeof *m);
    return AIR_OK;
}

static air_status operation(const air_mitsuba *mitsuba, const air_xml *at, double out[12])
{
    static const char *const names[] = {"translate", "rotate", "scale", "lookat", "matrix"};
    double v[3] = {0.0, 0.0, 0.0}, ones[3] = {1.0, 1.0, 1.0};
    air_status status = AIR_OK;
    memcpy(out, identity, sizeof identity);
    if (strcmp(at->tag, "translate") == 0) {
        status = air_mitsuba_read_vector(mitsuba, at, v);
        for (size_t i = 0; i < 3; ++i)
            out[4 * i + 3] = v[i];
        return status;
    }
    if (strcmp(at->tag, "scale") == 0) {
        status = air_mitsuba_read_vector(mitsuba, at, ones);
        set_diagonal(ones, out);
        return status;
    }
    if (strcmp(at->tag, "rotate") == 0)
        return rotate(mitsuba, at, out);
    if (strcmp(at->tag, "lookat") == 0)
        return look_at(mitsuba, at, out);
    if (strcmp(at->tag, "matrix") == 0)
        return matrix(mitsuba, at, out);
    const char *nearest = air_nearest_name(at->tag, names, 5);
    return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                            "expected translate, rotate, scale, lookat or matrix%s%s%s",
                            nearest != NULL ? "; did you mean <" : "",
                            nearest != NULL ? nearest : "", nearest != NULL ? ">?" : "");
}

air_status air_mitsuba_transform(const air_mitsuba *mitsuba, const air_xml *at, const char *name,
                                 float value[12])
{
    const air_xml *found = air_mitsuba_parameter(at, name);
    double m[12], step[12];
    air_status status = AIR_OK;
    if (found == NULL)
        return AIR_OK;
    if (strcmp(found->tag, "animation") == 0)
        return air_mitsuba_fail(mitsuba, found, AIR_ERROR_UNSUPPORTED,
                                "motion is not supported, expected <transform>");
    if (strcmp(found->tag, "transform") != 0)
        return air_mitsuba_fail(mitsuba, found, AIR_ERROR_FORMAT, "expected <transform>");
    memcpy(m, identity, sizeof identity);
    for (const air_xml *i = found->child; i != NULL && status == AIR_OK; i = i->next) {
        status = operation(mitsuba, i, step);
        if (status == AIR_OK)
            apply(step, m);
    }
    for (size_t i = 0; i < 12 && status == AIR_OK; ++i) {
        if (!(fabs(m[i]) < 1e30))
            return air_mitsuba_fail(mitsuba, found, AIR_ERROR_FORMAT,
                                    "the transformation is not finite");
        value[i] = (float)m[i];
    }
    return status;
}
