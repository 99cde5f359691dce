#include "scene/import/number.h"

#include <math.h>
#include <stdint.h>

static bool is_digit(char c) { return c >= '0' && c <= '9'; }

/* Powers of ten up to the 22nd are exact, and so is a product or quotient with one but for its
 * rounding [Clinger1990]. */
static double scale_by_ten(double value, int64_t exponent)
{
    static const double powers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                    1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                    1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    for (; exponent > 22 && isfinite(value); exponent -= 22)
        value *= powers[22];
    for (; exponent < -22 && value != 0.0; exponent += 22)
        value /= powers[22];
    if (exponent < -22 || exponent > 22)
        return value;
    return exponent < 0 ? value / powers[-exponent] : value * powers[exponent];
}

/* Digits up to the first other character. Those that *mantissa has no room for, behind 19, are
 * counted in *dropped. */
static const char *scan_digits(const char *text, const char *end, uint64_t *mantissa,
                               int64_t *dropped)
{
    for (; text < end && is_digit(*text); ++text) {
        if (*mantissa < UINT64_C(1000000000000000000))
            *mantissa = 10 * *mantissa + (uint64_t)(*text - '0');
        else
            ++*dropped;
    }
    return text;
}

/* "e-3": an exponent, or nothing where no digit follows. */
static const char *scan_exponent(const char *text, const char *end, int64_t *exponent)
{
    const char *at = text;
    if (at == end || (*at != 'e' && *at != 'E'))
        return text;
    ++at;
    const bool negative = at < end && *at == '-';
    if (at < end && (*at == '-' || *at == '+'))
        ++at;
    if (at == end || !is_digit(*at))
        return text;
    int64_t value = 0;
    for (; at < end && is_digit(*at); ++at)
        value = value < 1000000000000 ? 10 * value + (*at - '0') : value;
    *exponent += negative ? -value : value;
    return at;
}

const char *air_number_scan(const char *text, const char *end, double *out)
{
    const bool negative = text < end && *text == '-';
    if (text < end && (*text == '-' || *text == '+'))
        ++text;
    uint64_t mantissa = 0;
    int64_t exponent = 0;
    const char *const whole = text;
    const char *at = scan_digits(text, end, &mantissa, &exponent);
    bool digits = at > whole;
    if (at < end && *at == '.') {
        const char *const fraction = at + 1;
        at = scan_digits(fraction, end, &mantissa, &exponent);
        digits = digits || at > fraction;
        exponent -= at - fraction;
    }
    if (!digits)
        return NULL;
    at = scan_exponent(at, end, &exponent);
    const double value = mantissa == 0 ? 0.0 : scale_by_ten((double)mantissa, exponent);
    *out = negative ? -value : value;
    return at;
}

bool air_number_parse(const char *text, size_t length, double *out)
{
    const char *end = text + length;
    double value = 0.0;
    while (text < end && *text == ' ')
        ++text;
    while (end > text && end[-1] == ' ')
        --end;
    if (air_number_scan(text, end, &value) != end || !isfinite(value))
        return false;
    *out = value;
    return true;
}
