/* rule.c: how finely the light's directions are told apart. */
#include <math.h>

#include "core/phase.h"
#include "render/ordinates/state.h"

/* What is left of a phase function when its peak counts as no event is smoother the more bands
 * there are, and light that was turned a little often is only then where it belongs: a cloud with a
 * mean cosine of 0.96 is 7 % too dark with 4 bands, 4 % with 6, 0.6 % too bright with 7
 * (bench/ordinates_figures.py --bands 4). */
enum { BANDS = 4, SHARP_BANDS = 7, SHARP_BAND = 6 };
static const double sharp_cosine = 0.9;

/* Is some phase function as sharp as one of Henyey and Greenstein with that mean cosine? */
static bool any_sharp(const air_media *media)
{
    bool sharp = false;
    for (size_t i = 0; i < media->count; i++) {
        const air_medium *const medium = &media->media[i];
        const double mean = phase_legendre(medium->phase, SHARP_BAND);
        sharp = sharp || (!vec3_is_zero(medium->sigma_s) && mean > pow(sharp_cosine, SHARP_BAND));
    }
    return sharp;
}

/* No more than the angles asked for can tell apart. */
static int bands_of(const air_media *media, const air_ordinates_settings *s)
{
    int bands = any_sharp(media) ? SHARP_BANDS : BANDS;
    bands = s->polar > 0 && s->polar < bands ? s->polar : bands;
    return s->azimuths > 0 && s->azimuths / 2 < bands ? s->azimuths / 2 : bands;
}

void ord_rule_choose(air_with_ordinates *with)
{
    const air_ordinates_settings *const s = with->settings;
    air_dom_params *const rule = &with->rule;
    air_dom_params_default(rule);
    rule->bands = s->bands > 0 ? s->bands : bands_of(&with->snapshot->media, s);
    rule->polar = s->polar > 0 ? s->polar : (rule->bands + 1) / 2 * 2;
    rule->azimuths = s->azimuths > 0 ? s->azimuths : (2 * rule->bands + 3) / 4 * 4;
}
