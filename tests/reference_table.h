/* reference_table.h: reads tables of reference values: cells separated by commas under a header
 * that names the columns. Lines that begin with # are comments. */
#ifndef AIR_TESTS_REFERENCE_TABLE_H
#define AIR_TESTS_REFERENCE_TABLE_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TABLE_COLUMNS = 64, TABLE_LINE = 4096, TABLE_NAME = 32 };

typedef struct reference_table {
    const char *path;
    FILE *file;
    size_t line, columns, count; /* count: cells of this line */
    char names[TABLE_COLUMNS][TABLE_NAME];
    char text[TABLE_LINE];
    const char *cells[TABLE_COLUMNS];
} reference_table;

static inline bool table_complain(const reference_table *self, const char *expected,
                                  const char *what)
{
    fprintf(stderr, "%s:%zu: expected %s%s\n", self->path, self->line, expected, what);
    return false;
}

/* Splits the next line into cells. False at the end of the file. */
static inline bool table_split_line(reference_table *self)
{
    do {
        if (fgets(self->text, TABLE_LINE, self->file) == NULL) {
            return false;
        }
        self->line++;
    } while (self->text[0] == '#');
    self->text[strcspn(self->text, "\r\n")] = '\0';
    self->count = 0;
    for (char *at = self->text; at != NULL && self->count < TABLE_COLUMNS;) {
        self->cells[self->count++] = at;
        at = strchr(at, ',');
        if (at != NULL) {
            *at++ = '\0';
        }
    }
    return true;
}

/* Opens a table and reads its header; the file stays NULL where there is none. */
static inline bool table_open(reference_table *self, const char *path)
{
    memset(self, 0, sizeof *self);
    self->path = path;
    self->file = fopen(path, "r");
    if (self->file == NULL) {
        return false;
    }
    if (!table_split_line(self)) {
        self->line = 1;
        return table_complain(self, "a header", "");
    }
    self->columns = self->count;
    for (size_t i = 0; i < self->columns; i++) {
        snprintf(self->names[i], TABLE_NAME, "%s", self->cells[i]);
    }
    return true;
}

static inline void table_close(reference_table *self)
{
    if (self->file != NULL) {
        (void)fclose(self->file);
        self->file = NULL;
    }
}

/* The next row. False at the end, and where a row is not as wide as the header (*ok too). */
static inline bool table_next(reference_table *self, bool *ok)
{
    if (!*ok || !table_split_line(self)) {
        return false;
    }
    *ok =
        self->count == self->columns || table_complain(self, "as many cells as the header has", "");
    return *ok;
}

/* A column's number, -1 where there is none of that name. */
static inline ptrdiff_t table_find(const reference_table *self, const char *name)
{
    for (size_t i = 0; i < self->columns; i++) {
        if (strcmp(self->names[i], name) == 0) {
            return (ptrdiff_t)i;
        }
    }
    return -1;
}

/* This row's cell of a column, NULL (said) where there is no such column. */
static inline const char *table_cell(const reference_table *self, const char *name)
{
    const ptrdiff_t column = table_find(self, name);
    if (column < 0) {
        (void)table_complain(self, "a column ", name);
        return NULL;
    }
    return self->cells[column];
}

/* Infinity is a number. */
static inline bool table_number(const reference_table *self, const char *name, double *out)
{
    char *end;
    const char *const text = table_cell(self, name);
    if (text == NULL) {
        return false;
    }
    *out = strtod(text, &end);
    return (end != text && *end == '\0' && !isnan(*out)) ||
           table_complain(self, "a number in column ", name);
}

static inline bool table_text(const reference_table *self, const char *name, char out[TABLE_NAME])
{
    const char *const text = table_cell(self, name);
    if (text != NULL) {
        snprintf(out, TABLE_NAME, "%s", text);
    }
    return text != NULL;
}

#endif
