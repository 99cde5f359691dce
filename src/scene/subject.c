#include "scene/subject.h"

#include <math.h>
#include <stdio.h>

#include "core/vec.h"

air_status air_subject_fail(const air_subject *subject, const char *format, ...)
{
    char sentence[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(sentence, sizeof sentence, format, arguments);
    va_end(arguments);
    if (subject->name == NULL || subject->name[0] == '\0')
        return air_fail(subject->context, AIR_ERROR_ARGUMENT, "unnamed %s: %s", subject->kind,
                        sentence);
    return air_fail(subject->context, AIR_ERROR_ARGUMENT, "%s \"%s\": %s", subject->kind,
                    subject->name, sentence);
}

air_status air_subject_check(const air_subject *subject, const char *field, const float *values,
                             size_t count, float low, float high)
{
    for (size_t i = 0; i < count; ++i) {
        if (isfinite(values[i]) && values[i] >= low && values[i] <= high)
            continue;
        char place[32] = "";
        if (count > 1)
            snprintf(place, sizeof place, "[%zu]", i);
        const double value = (double)values[i];
        if (isinf(high) && isinf(low))
            return air_subject_fail(subject, "%s%s is %g, but must be finite", field, place, value);
        if (isinf(high))
            return air_subject_fail(subject, "%s%s is %g, but must be finite and at least %g",
                                    field, place, value, (double)low);
        return air_subject_fail(subject, "%s%s is %g, but must be in [%g, %g]", field, place, value,
                                (double)low, (double)high);
    }
    return AIR_OK;
}

air_status air_subject_check_enum(const air_subject *subject, const char *field, int value,
                                  int count)
{
    if (value >= 0 && value < count)
        return AIR_OK;
    return air_subject_fail(subject, "%s is %d, but must be in 0..%d", field, value, count - 1);
}

air_status air_subject_check_map(const air_subject *subject, const char *field, const float map[12])
{
    float inverse[12];
    const air_status status = air_subject_check(subject, field, map, 12, -INFINITY, INFINITY);
    if (status != AIR_OK)
        return status;
    if (!affine_invert(map, inverse))
        return air_subject_fail(subject, "%s is singular: it flattens space", field);
    return AIR_OK;
}
