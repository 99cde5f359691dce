#include "scene/import/number.h"

#include <jansson.h>
#include <math.h>
#include <string.h>

/* A point becomes at most three characters. */
enum { AIR_NUMBER_LENGTH = 40, AIR_NUMBER_SIZE = 3 * AIR_NUMBER_LENGTH };

static bool is_digit(char c) { return c >= '0' && c <= '9'; }

/* JSON wants a digit before and behind the point and no plus sign. Returns the length, 0 if there
 * is no room. */
static size_t as_json(const char *text, size_t length, char out[AIR_NUMBER_SIZE])
{
    size_t end = 0;
    if (length > AIR_NUMBER_LENGTH)
        return 0;
    for (size_t i = text[0] == '+' ? 1 : 0; i < length; ++i) {
        const bool point = text[i] == '.';
        if (point && (i == 0 || !is_digit(text[i - 1])))
            out[end++] = '0';
        out[end++] = text[i];
        if (point && (i + 1 == length || !is_digit(text[i + 1])))
            out[end++] = '0';
    }
    return end;
}

bool air_number_parse(const char *text, size_t length, double *out)
{
    char buffer[AIR_NUMBER_SIZE];
    while (length > 0 && text[0] == ' ') {
        ++text;
        --length;
    }
    while (length > 0 && text[length - 1] == ' ')
        --length;
    const size_t size = length == 0 ? 0 : as_json(text, length, buffer);
    json_t *json = size == 0 ? NULL : json_loadb(buffer, size, JSON_DECODE_ANY, NULL);
    const bool ok = json_is_number(json) && isfinite(json_number_value(json));
    if (ok)
        *out = json_number_value(json);
    json_decref(json);
    return ok;
}
