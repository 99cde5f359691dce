/* spectrum.h: spectra as linear RGB (Rec. 709), as Mitsuba's rgb variants make it of them.
 *
 * A spectrum is given by its values at `count` wavelengths in nm that do not fall, linear between
 * them and 0 outside. It is integrated against the CIE 1931 2-degree observer; colours out of gamut
 * are cut to it. */
#ifndef AIR_SCENE_IMPORT_SPECTRUM_H
#define AIR_SCENE_IMPORT_SPECTRUM_H

#include <stdbool.h>
#include <stddef.h>

/* Of a surface, in daylight: what reflects 1 at all wavelengths is white under CIE D65. In [0,1].
 */
void air_spectrum_reflectance_rgb(const float *nm, const float *values, size_t count, float out[3]);

/* Of a light, per nm: what is 1 at all wavelengths has the luminance 1 (and is warmer than white).
 * Values are W/(m^2 sr nm) as a rule; 683 lm/W times 106.857 nm is then the factor to cd/m^2. */
void air_spectrum_emission_rgb(const float *nm, const float *values, size_t count, float out[3]);

/* `scale` times the emission of a black body, W/(m^2 sr nm), by Planck's law. kelvin > 0. */
void air_blackbody_rgb(float kelvin, float scale, float out[3]);

/* The complex index of refraction eta - i absorption of a material by its chemical name ("Au",
 * "TiO2", "a-C"; with or without "_palik"), averaged as emission is, as Mitsuba does. "none" is a
 * perfect mirror. False if the name is not known. */
bool air_metal_find(const char *name, float out_eta[3], float out_absorption[3]);

#endif
