/* number.h: decimal numbers in text, with a point whatever the locale. */
#ifndef AIR_SCENE_IMPORT_NUMBER_H
#define AIR_SCENE_IMPORT_NUMBER_H

#include <stdbool.h>
#include <stddef.h>

/* Reads the decimal number that [text, end) begins with: "12", "-.5", "+3.", "1e-3". Returns where
 * it ends, NULL where none begins. Correctly rounded up to 15 digits and powers of ten of at most
 * 22; beyond, 1e-15 off at most. What is too large becomes infinite. */
const char *air_number_scan(const char *text, const char *end, double *out);

/* Reads the whole of text[0..length), blanks around it aside, as a finite decimal number. */
bool air_number_parse(const char *text, size_t length, double *out);

#endif
