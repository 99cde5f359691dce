/* export_json.c: the pieces that glTF's JSON is put together from. */
#include <string.h>

#include "scene/export/export.h"

void air_export_put(air_export *self, json_t *object, const char *key, json_t *value)
{
    if (json_object_set_new(object, key, value) != 0)
        self->failed = true;
}

void air_export_push(air_export *self, json_t *array, json_t *value)
{
    if (json_array_append_new(array, value) != 0)
        self->failed = true;
}

json_t *air_export_object(air_export *self, json_t *object, const char *key)
{
    if (json_object_get(object, key) == NULL)
        air_export_put(self, object, key, json_object());
    return json_object_get(object, key);
}

json_t *air_export_list(air_export *self, json_t *object, const char *key)
{
    if (json_object_get(object, key) == NULL)
        air_export_put(self, object, key, json_array());
    return json_object_get(object, key);
}

size_t air_export_append(air_export *self, const char *list, json_t *item)
{
    json_t *array = air_export_list(self, self->root, list);
    air_export_push(self, array, item);
    const size_t count = json_array_size(array);
    return count > 0 ? count - 1 : 0;
}

json_t *air_export_floats(air_export *self, const float *values, size_t count)
{
    json_t *array = json_array();
    for (size_t i = 0; i < count; ++i)
        air_export_push(self, array, json_real((double)values[i]));
    return array;
}

json_t *air_export_color(air_export *self, const float values[3])
{
    const bool grey = values[0] == values[1] && values[1] == values[2];
    return grey ? json_real((double)values[0]) : air_export_floats(self, values, 3);
}

json_t *air_export_rows(air_export *self, const float map[12])
{
    json_t *rows = json_array();
    for (size_t i = 0; i < 3; ++i)
        air_export_push(self, rows, air_export_floats(self, map + 4 * i, 4));
    return rows;
}

json_t *air_export_string(air_export *self, const char *text)
{
    json_t *string = json_string(text);
    if (string != NULL)
        return string;
    char *ascii = air_string_copy(self->context, text);
    for (char *c = ascii; c != NULL && *c != '\0'; ++c)
        if ((unsigned char)*c >= 0x80)
            *c = '?';
    string = ascii != NULL ? json_string(ascii) : NULL;
    air_free(self->context, ascii);
    return string;
}

void air_export_name(air_export *self, json_t *object, const char *name)
{
    if (name[0] != '\0')
        air_export_put(self, object, "name", air_export_string(self, name));
}

static void use_extension(air_export *self, const char *name)
{
    json_t *used = air_export_list(self, self->root, "extensionsUsed");
    for (size_t i = 0; i < json_array_size(used); ++i)
        if (strcmp(json_string_value(json_array_get(used, i)), name) == 0)
            return;
    air_export_push(self, used, json_string(name));
}

json_t *air_export_extension(air_export *self, json_t *object, const char *name)
{
    use_extension(self, name);
    return air_export_object(self, air_export_object(self, object, "extensions"), name);
}

json_t *air_export_node_object(air_export *self, json_t *node)
{
    return air_export_object(self, air_export_object(self, node, "extras"), "airlight");
}

bool air_export_is_identity(const float map[12])
{
    for (size_t i = 0; i < 12; ++i)
        if (map[i] != (i % 5 == 0 ? 1.0f : 0.0f))
            return false;
    return true;
}

void air_export_matrix(air_export *self, json_t *node, const float map[12])
{
    float columns[16] = {0.0f};
    if (air_export_is_identity(map))
        return;
    for (size_t row = 0; row < 3; ++row)
        for (size_t column = 0; column < 4; ++column)
            columns[4 * column + row] = map[4 * row + column];
    columns[15] = 1.0f;
    air_export_put(self, node, "matrix", air_export_floats(self, columns, 16));
}

void air_export_node(air_export *self, json_t *node)
{
    json_t *scene = json_array_get(json_object_get(self->root, "scenes"), 0);
    const size_t index = air_export_append(self, "nodes", node);
    air_export_push(self, air_export_list(self, scene, "nodes"), json_integer((json_int_t)index));
}
