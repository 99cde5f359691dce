/* number.h: numbers as people write them on a command line. */
#ifndef AIR_SCENE_IMPORT_NUMBER_H
#define AIR_SCENE_IMPORT_NUMBER_H

#include <stdbool.h>
#include <stddef.h>

/* Reads the whole of text[0..length), blanks around it aside, as a finite decimal number: "12",
 * "-.5", "+3.", "1e-3". The point is a point in every locale. */
bool air_number_parse(const char *text, size_t length, double *out);

#endif
