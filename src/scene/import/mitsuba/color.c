#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "image/srgb.h"
#include "scene/import/mitsuba/mitsuba.h"
#include "scene/import/number.h"
#include "scene/import/spectrum.h"

/* Values at wavelengths, as a <spectrum> lists them. */
typedef struct air_mitsuba_spectrum {
    float *nm, *values;
    size_t count, capacity;
} air_mitsuba_spectrum;

bool air_mitsuba_is_color(const air_xml *at)
{
    static const char *const tags[] = {"float", "integer", "rgb", "srgb", "spectrum", "blackbody"};
    for (size_t i = 0; i < sizeof tags / sizeof *tags; ++i)
        if (strcmp(at->tag, tags[i]) == 0)
            return true;
    return false;
}

static void set_grey(double value, float out[3]) { out[0] = out[1] = out[2] = (float)value; }

/* "#rrggbb", or one number or three. */
static air_status read_rgb(const air_mitsuba *mitsuba, const air_xml *at, bool srgb, float out[3])
{
    const char *text = air_xml_attribute_of(at, "value");
    double numbers[3];
    size_t count = 0;
    char *end = NULL;
    if (text != NULL && text[0] == '#') {
        const unsigned long code = strtoul(text + 1, &end, 16);
        if (strlen(text) != 7 || *end != '\0')
            return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                    "expected #rrggbb, found \"%.40s\"", text);
        for (size_t i = 0; i < 3; ++i)
            out[i] = (float)(code >> (16 - 8 * i) & 0xff) / 255.0f;
    } else {
        const air_status status = air_mitsuba_numbers(mitsuba, at, "value", 3, numbers, &count);
        if (status != AIR_OK)
            return status;
        if (count == 2)
            return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                    "expected one number or three, found two");
        for (size_t i = 0; i < 3; ++i)
            out[i] = (float)numbers[count == 1 ? 0 : i];
    }
    for (size_t i = 0; i < 3 && srgb; ++i)
        out[i] = srgb_decode(out[i]);
    return AIR_OK;
}

/* ---- spectra ---- */

static bool add_value(air_context *context, air_mitsuba_spectrum *spectrum, double nm, double value)
{
    if (spectrum->count == spectrum->capacity) {
        const size_t capacity = 2 * spectrum->capacity + 64;
        float *wavelengths = air_reallocate(context, spectrum->nm, capacity, sizeof *spectrum->nm);
        if (wavelengths == NULL)
            return false;
        spectrum->nm = wavelengths;
        float *values = air_reallocate(context, spectrum->values, capacity, sizeof *values);
        if (values == NULL)
            return false;
        spectrum->values = values;
        spectrum->capacity = capacity;
    }
    spectrum->nm[spectrum->count] = (float)nm;
    spectrum->values[spectrum->count++] = (float)value;
    return true;
}

/* Pairs of numbers between blanks, commas and colons; # begins a comment. */
static air_status read_pairs(const air_mitsuba *mitsuba, const air_xml *at, const char *text,
                             air_mitsuba_spectrum *spectrum)
{
    static const char *const separators = " ,:;\t\r\n";
    double pair[2] = {0.0, 0.0};
    size_t half = 0;
    for (text += strspn(text, separators); *text != '\0'; text += strspn(text, separators)) {
        if (*text == '#') {
            text += strcspn(text, "\n");
            continue;
        }
        const size_t length = strcspn(text, separators);
        if (!air_number_parse(text, length, &pair[half]) || fabs(pair[half]) > 3e38)
            return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                    "expected wavelengths in nm and values, found \"%.*s\"",
                                    (int)(length < 60 ? length : 60), text);
        if (half == 1 && spectrum->count > 0 &&
            !(pair[0] > (double)spectrum->nm[spectrum->count - 1]))
            return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                    "expected increasing wavelengths, found %g after %g", pair[0],
                                    (double)spectrum->nm[spectrum->count - 1]);
        if (half == 1 && !add_value(mitsuba->context, spectrum, pair[0], pair[1]))
            return air_fail_memory(mitsuba->context, at->file);
        half = 1 - half;
        text += length;
    }
    if (half == 1 || spectrum->count == 0)
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                "expected pairs of a wavelength in nm and a value");
    return AIR_OK;
}

/* Coefficients of media, which may be above 1, are averaged as reflectances, which may not. */
static void average(const air_mitsuba_spectrum *spectrum, float out[3])
{
    float most = 1.0f;
    for (size_t i = 0; i < spectrum->count; ++i)
        most = fmaxf(most, spectrum->values[i]);
    for (size_t i = 0; i < spectrum->count; ++i)
        spectrum->values[i] /= most;
    air_spectrum_reflectance_rgb(spectrum->nm, spectrum->values, spectrum->count, out);
    for (size_t i = 0; i < 3; ++i)
        out[i] *= most;
}

static air_status read_listed(const air_mitsuba *mitsuba, const air_xml *at, const char *text,
                              air_mitsuba_quantity quantity, float out[3])
{
    air_mitsuba_spectrum spectrum = {0};
    const air_status status = read_pairs(mitsuba, at, text, &spectrum);
    if (status == AIR_OK && quantity == AIR_MITSUBA_EMISSION)
        air_spectrum_emission_rgb(spectrum.nm, spectrum.values, spectrum.count, out);
    else if (status == AIR_OK)
        average(&spectrum, out);
    air_free(mitsuba->context, spectrum.nm);
    air_free(mitsuba->context, spectrum.values);
    return status;
}

static air_status read_file(const air_mitsuba *mitsuba, const air_xml *at, const char *name,
                            air_mitsuba_quantity quantity, float out[3])
{
    char *path = NULL;
    void *data = NULL;
    size_t size = 0;
    air_status status = air_mitsuba_file(mitsuba, at, name, &path);
    if (status == AIR_OK)
        status = air_file_read(mitsuba->context, path, &data, &size);
    if (status == AIR_OK)
        status = read_listed(mitsuba, at, data, quantity, out);
    air_free(mitsuba->context, data);
    air_free(mitsuba->context, path);
    return status;
}

/* A temperature in kelvin, "6500" or "6500K". */
static air_status read_blackbody(const air_mitsuba *mitsuba, const air_xml *at, float out[3])
{
    const char *text = air_xml_attribute_of(at, "temperature");
    double kelvin = 0.0, scale = 1.0;
    size_t count = 0, length = text != NULL ? strlen(text) : 0;
    if (length > 0 && (text[length - 1] == 'K' || text[length - 1] == 'k'))
        --length;
    if (text == NULL || !air_number_parse(text, length, &kelvin) || !(kelvin > 0.0 && kelvin < 1e8))
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                "expected a temperature in kelvin as temperature");
    if (air_xml_attribute_of(at, "scale") != NULL) {
        const air_status status = air_mitsuba_numbers(mitsuba, at, "scale", 1, &scale, &count);
        if (status != AIR_OK)
            return status;
    }
    air_blackbody_rgb((float)kelvin, (float)scale, out);
    return AIR_OK;
}

/* <spectrum type="...">, of version 3. */
static air_status read_plugin(const air_mitsuba *mitsuba, const air_xml *at, float out[3])
{
    static const char *const types[] = {"uniform", "d65", "blackbody"};
    float value = 1.0f, scale = 1.0f;
    at->parent->asked = true;
    air_status status = AIR_OK;
    if (air_mitsuba_is(at, "blackbody")) {
        status = air_mitsuba_float(mitsuba, at, "temperature", &value);
        if (status == AIR_OK)
            status = air_mitsuba_float(mitsuba, at, "scale", &scale);
        if (status == AIR_OK && !(value > 1.0f))
            status = air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                      "expected a temperature in kelvin as temperature");
        if (status == AIR_OK)
            air_blackbody_rgb(value, scale, out);
        return status;
    }
    if (!air_mitsuba_is(at, "uniform") && !air_mitsuba_is(at, "d65"))
        status = air_mitsuba_unknown_type(mitsuba, at, types, 3, "a uniform spectrum is taken");
    if (status == AIR_OK)
        status = air_mitsuba_float(mitsuba, at, "value", &value);
    if (status == AIR_OK)
        status = air_mitsuba_float(mitsuba, at, "scale", &scale);
    if (status == AIR_OK)
        set_grey((double)value * (double)scale, out);
    return status;
}

static air_status read_spectrum(const air_mitsuba *mitsuba, const air_xml *at,
                                air_mitsuba_quantity quantity, float out[3])
{
    const char *text = air_xml_attribute_of(at, "value");
    const char *name = air_xml_attribute_of(at, "filename");
    if (air_xml_attribute_of(at, "type") != NULL)
        return read_plugin(mitsuba, at, out);
    if ((text == NULL) == (name == NULL))
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                "expected one of the attributes value and filename");
    if (name != NULL)
        return read_file(mitsuba, at, name, quantity, out);
    return strchr(text, ':') == NULL ? read_rgb(mitsuba, at, false, out)
                                     : read_listed(mitsuba, at, text, quantity, out);
}

air_status air_mitsuba_read_color(const air_mitsuba *mitsuba, const air_xml *at,
                                  air_mitsuba_quantity quantity, float out[3])
{
    double number = 0.0;
    size_t count = 0;
    if (strcmp(at->tag, "rgb") == 0 || strcmp(at->tag, "srgb") == 0)
        return read_rgb(mitsuba, at, at->tag[0] == 's', out);
    if (strcmp(at->tag, "spectrum") == 0)
        return read_spectrum(mitsuba, at, quantity, out);
    if (strcmp(at->tag, "blackbody") == 0)
        return read_blackbody(mitsuba, at, out);
    if (!air_mitsuba_is_color(at))
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                "expected a colour: <rgb>, <srgb>, <spectrum>, <blackbody> or "
                                "<float>");
    const air_status status = air_mitsuba_numbers(mitsuba, at, "value", 1, &number, &count);
    if (status == AIR_OK)
        set_grey(number, out);
    return status;
}

air_status air_mitsuba_color(const air_mitsuba *mitsuba, const air_xml *at, const char *name,
                             air_mitsuba_quantity quantity, float value[3])
{
    const air_xml *found = NULL;
    const air_status status = air_mitsuba_plain(mitsuba, at, name, &found);
    return found != NULL ? air_mitsuba_read_color(mitsuba, found, quantity, value) : status;
}
