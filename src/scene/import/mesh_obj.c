/* mesh_obj.c: Wavefront OBJ [Wavefront1995]: vertices, their texture coordinates, normals and
 * colours, and faces; everything else says nothing about shape and is passed by.
 *
 * The text is read three times: to count, for values, for faces. So all arrays have their size
 * from the beginning, and a face may name vertices that come later. */
#include <assert.h>
#include <math.h>
#include <string.h>

#include "scene/import/mesh_decode.h"
#include "scene/import/mesh_polygon.h"
#include "scene/import/number.h"
#include "scene/import/obj_vertices.h"

/* ---- lines ---- */

typedef enum obj_keyword { OBJ_OTHER, OBJ_V, OBJ_VT, OBJ_VN, OBJ_F } obj_keyword;

typedef struct obj_line {
    const char *text, *end; /* what follows the keyword */
    size_t number;
    obj_keyword keyword;
} obj_line;

typedef struct obj_lines {
    const char *next, *end;
    size_t count; /* of lines that `next` is behind */
} obj_lines;

typedef struct obj_counts {
    size_t v, vt, vn, faces, corners;
    size_t most_corners; /* of one face */
    bool normals;        /* some corner has one */
} obj_counts;

typedef struct obj_reader {
    air_context *context;
    const char *path;
    const char *text, *end;
    obj_counts total, seen; /* in the file; above the line at hand */
    float *v, *vt, *vn;     /* normals of faces without any follow those of the file */
    float *colors;          /* 3 per v; NULL: none */
    size_t face_normals;
    air_obj_vertices vertices;
    air_mesh_polygon polygon;
    air_obj_corner *corners; /* of the face at hand */
} obj_reader;

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

/* A backslash that ends a line joins the next one to it. */
static const char *skip_blanks(const char *text, const char *end)
{
    while (text < end) {
        if (is_blank(*text) || *text == '\n')
            ++text;
        else if (*text == '\\' && end - text > 1 && (text[1] == '\n' || text[1] == '\r'))
            text += 2;
        else
            break;
    }
    return text;
}

/* Behind the last token, be it the end or a comment? */
static bool is_finished(const char *text, const char *end) { return text == end || *text == '#'; }

static obj_keyword read_keyword(const char *text, const char *end, size_t *length)
{
    static const struct {
        char text[3];
        obj_keyword keyword;
    } known[] = {{"v", OBJ_V}, {"f", OBJ_F}, {"vt", OBJ_VT}, {"vn", OBJ_VN}};
    for (size_t i = 0; i < sizeof known / sizeof *known; ++i) {
        *length = i < 2 ? 1 : 2;
        if ((size_t)(end - text) > *length && memcmp(text, known[i].text, *length) == 0 &&
            (is_blank(text[*length]) || text[*length] == '\\'))
            return known[i].keyword;
    }
    *length = 0;
    return OBJ_OTHER;
}

/* Where a line ends that begins at text: at a newline without a backslash before it. */
static const char *find_end(const char *text, const char *end, size_t *count)
{
    const char *from = text;
    for (;;) {
        const char *newline = memchr(from, '\n', (size_t)(end - from));
        ++*count;
        if (newline == NULL)
            return end;
        const char *last = newline;
        if (last > text && last[-1] == '\r')
            --last;
        if (last == text || last[-1] != '\\' || *text == '#')
            return newline;
        from = newline + 1;
    }
}

static bool next_line(obj_lines *lines, obj_line *out)
{
    if (lines->next == lines->end)
        return false;
    const char *text = lines->next;
    out->number = lines->count + 1;
    while (text < lines->end && is_blank(*text))
        ++text;
    out->end = find_end(text, lines->end, &lines->count);
    size_t length = 0;
    out->keyword = read_keyword(text, out->end, &length);
    out->text = text + length;
    lines->next = out->end < lines->end ? out->end + 1 : out->end;
    return true;
}

static obj_lines all_lines(const obj_reader *reader)
{
    return (obj_lines){reader->text, reader->end, 0};
}

static void count_value(obj_counts *counts, obj_keyword keyword)
{
    counts->v += keyword == OBJ_V;
    counts->vt += keyword == OBJ_VT;
    counts->vn += keyword == OBJ_VN;
}

/* ---- counting ---- */

static void count_corners(const obj_line *line, obj_counts *counts)
{
    size_t corners = 0;
    const char *at = skip_blanks(line->text, line->end);
    while (!is_finished(at, line->end)) {
        int slashes = 0;
        do {
            counts->normals = counts->normals || (slashes == 2 && *at != '/');
            slashes += *at++ == '/';
        } while (at < line->end && !is_blank(*at) && *at != '\\');
        ++corners;
        const char *behind = skip_blanks(at, line->end);
        at = behind > at || behind == line->end ? behind : behind + 1;
    }
    counts->corners += corners;
    counts->most_corners = corners > counts->most_corners ? corners : counts->most_corners;
    ++counts->faces;
}

static void count_all(obj_reader *reader)
{
    obj_lines lines = all_lines(reader);
    obj_line line;
    while (next_line(&lines, &line)) {
        if (line.keyword == OBJ_F)
            count_corners(&line, &reader->total);
        else
            count_value(&reader->total, line.keyword);
    }
}

static air_status allocate(obj_reader *reader, air_mesh_file *out)
{
    air_context *context = reader->context;
    const obj_counts *total = &reader->total;
    const size_t normals = total->vn + (total->normals ? total->faces : 0);
    if (total->corners >= UINT32_MAX || total->v >= UINT32_MAX || total->vt >= UINT32_MAX ||
        normals >= UINT32_MAX)
        return air_fail(context, AIR_ERROR_UNSUPPORTED,
                        "%s: %zu v, %zu vt, %zu normals and %zu corners of faces, expected fewer "
                        "than 2^32 of each",
                        reader->path, total->v, total->vt, normals, total->corners);
    if (total->faces == 0)
        return air_fail(context, AIR_ERROR_FORMAT, "%s: expected at least one face (f)",
                        reader->path);
    reader->v = air_allocate(context, 3 * total->v, sizeof(float));
    reader->vt = air_allocate(context, 2 * total->vt, sizeof(float));
    reader->vn = air_allocate(context, 3 * normals, sizeof(float));
    reader->corners = air_allocate(context, total->most_corners, sizeof *reader->corners);
    /* a face of n corners has n - 2 triangles at most */
    out->indices = air_allocate(context, 3 * total->corners, sizeof *out->indices);
    if (reader->v == NULL || reader->vt == NULL || reader->vn == NULL || reader->corners == NULL ||
        out->indices == NULL ||
        !air_mesh_polygon_init(context, total->most_corners, &reader->polygon) ||
        !air_obj_vertices_init(context, total->corners, &reader->vertices))
        return air_fail_memory(context, reader->path);
    return AIR_OK;
}

/* ---- values ---- */

/* All numbers of a line, of which `most` are kept and `least` must be there. */
static air_status read_numbers(const obj_reader *reader, const obj_line *line, size_t least,
                               size_t most, float *out, size_t *out_count)
{
    size_t count = 0;
    const char *at = skip_blanks(line->text, line->end);
    while (!is_finished(at, line->end)) {
        double value = 0.0;
        const char *behind = air_number_scan(at, line->end, &value);
        if (behind == NULL || !isfinite((float)value))
            break;
        if (count < most)
            out[count++] = (float)value;
        at = skip_blanks(behind, line->end);
        if (at == behind && at != line->end)
            break;
    }
    if (!is_finished(at, line->end) || count < least)
        return air_fail(reader->context, AIR_ERROR_FORMAT,
                        "%s: line %zu: expected %zu or more finite numbers", reader->path,
                        line->number, least);
    *out_count = count;
    return AIR_OK;
}

/* Vertices before the first that has a colour are white. */
static air_status store_color(obj_reader *reader, const float color[3])
{
    if (reader->colors == NULL) {
        reader->colors = air_allocate(reader->context, 3 * reader->total.v, sizeof(float));
        if (reader->colors == NULL)
            return air_fail_memory(reader->context, reader->path);
        for (size_t i = 0; i < 3 * reader->total.v; ++i)
            reader->colors[i] = 1.0f;
    }
    memcpy(reader->colors + 3 * reader->seen.v, color, 3 * sizeof(float));
    return AIR_OK;
}

static air_status read_value(obj_reader *reader, const obj_line *line)
{
    float values[6] = {0.0f};
    size_t count = 0;
    air_status status = AIR_OK;
    switch (line->keyword) {
    case OBJ_V:
        status = read_numbers(reader, line, 3, 6, values, &count);
        memcpy(reader->v + 3 * reader->seen.v, values, 3 * sizeof(float));
        if (status == AIR_OK && count == 6)
            status = store_color(reader, values + 3);
        break;
    case OBJ_VT:
        status = read_numbers(reader, line, 1, 2, values, &count);
        memcpy(reader->vt + 2 * reader->seen.vt, values, 2 * sizeof(float));
        break;
    case OBJ_VN:
        status = read_numbers(reader, line, 3, 3, values, &count);
        memcpy(reader->vn + 3 * reader->seen.vn, values, 3 * sizeof(float));
        break;
    case OBJ_F:
    case OBJ_OTHER:
        break;
    }
    count_value(&reader->seen, line->keyword);
    return status;
}

static air_status read_values(obj_reader *reader)
{
    obj_lines lines = all_lines(reader);
    obj_line line;
    air_status status = AIR_OK;
    while (status == AIR_OK && next_line(&lines, &line))
        status = read_value(reader, &line);
    return status;
}

/* ---- faces ---- */

/* An index from 1 on, or from -1 back from the last one seen. Returns where it ends, NULL if there
 * is none of that kind. */
static const char *read_index(const char *text, const char *end, size_t seen, size_t total,
                              uint32_t *out)
{
    const bool back = text < end && *text == '-';
    const char *at = text + back;
    const char *const digits = at;
    size_t value = 0;
    for (; at < end && *at >= '0' && *at <= '9'; ++at)
        value = value <= UINT32_MAX ? 10 * value + (size_t)(*at - '0') : value;
    if (at == digits || value == 0 || value > (back ? seen : total))
        return NULL;
    *out = (uint32_t)(back ? seen - value : value - 1);
    return at;
}

/* v, v/vt, v//vn or v/vt/vn */
static const char *read_corner(const obj_reader *reader, const char *text, const char *end,
                               air_obj_corner *out)
{
    const obj_counts *seen = &reader->seen, *total = &reader->total;
    *out = (air_obj_corner){AIR_OBJ_NONE, AIR_OBJ_NONE, AIR_OBJ_NONE};
    const char *at = read_index(text, end, seen->v, total->v, &out->v);
    if (at == NULL || at == end || *at != '/')
        return at;
    if (++at < end && *at != '/' && !is_blank(*at))
        at = read_index(at, end, seen->vt, total->vt, &out->vt);
    if (at == NULL || at == end || *at != '/')
        return at;
    if (++at < end && !is_blank(*at))
        at = read_index(at, end, seen->vn, total->vn, &out->vn);
    return at;
}

static air_status read_corners(obj_reader *reader, const obj_line *line, size_t *out_count)
{
    size_t count = 0;
    const char *at = skip_blanks(line->text, line->end);
    while (!is_finished(at, line->end)) {
        assert(count < reader->total.most_corners);
        const char *behind = read_corner(reader, at, line->end, &reader->corners[count]);
        at = behind == NULL ? at : skip_blanks(behind, line->end);
        if (behind == NULL || (at == behind && at != line->end))
            return air_fail(reader->context, AIR_ERROR_FORMAT,
                            "%s: line %zu: corner %zu: expected v, v/vt, v//vn or v/vt/vn with "
                            "indices of the %zu v, %zu vt and %zu vn of the file",
                            reader->path, line->number, count + 1, reader->total.v,
                            reader->total.vt, reader->total.vn);
        ++count;
    }
    if (count < 3)
        return air_fail(reader->context, AIR_ERROR_FORMAT,
                        "%s: line %zu: a face of %zu corners, expected 3 or more", reader->path,
                        line->number, count);
    *out_count = count;
    return AIR_OK;
}

/* Corners without a normal, where others of the file have one, take that of their face. */
static void complete_normals(obj_reader *reader, size_t count)
{
    const size_t own = reader->total.vn + reader->face_normals;
    bool wanted = false;
    for (size_t i = 0; i < count; ++i) {
        if (reader->corners[i].vn == AIR_OBJ_NONE) {
            reader->corners[i].vn = (uint32_t)own;
            wanted = true;
        }
    }
    if (wanted) {
        air_mesh_polygon_normal(&reader->polygon, reader->vn + 3 * own);
        ++reader->face_normals;
    }
}

static air_status read_face(obj_reader *reader, const obj_line *line, air_mesh_file *out)
{
    size_t count = 0;
    const air_status status = read_corners(reader, line, &count);
    if (status != AIR_OK)
        return status;
    air_mesh_polygon_begin(&reader->polygon);
    for (size_t i = 0; i < count; ++i)
        air_mesh_polygon_add(&reader->polygon, reader->v + 3 * (size_t)reader->corners[i].v);
    if (reader->total.normals)
        complete_normals(reader, count);
    const size_t triangles = air_mesh_polygon_triangulate(&reader->polygon);
    uint32_t *indices = out->indices + 3 * out->triangle_count;
    for (size_t i = 0; i < 3 * triangles; ++i) {
        const uint32_t corner = reader->polygon.triangles[i / 3][i % 3];
        indices[i] = air_obj_vertices_find(&reader->vertices, reader->corners[corner]);
    }
    out->triangle_count += triangles;
    return AIR_OK;
}

static air_status read_faces(obj_reader *reader, air_mesh_file *out)
{
    obj_lines lines = all_lines(reader);
    obj_line line;
    air_status status = AIR_OK;
    reader->seen = (obj_counts){0};
    while (status == AIR_OK && next_line(&lines, &line)) {
        if (line.keyword == OBJ_F)
            status = read_face(reader, &line, out);
        else
            count_value(&reader->seen, line.keyword);
    }
    return status;
}

/* ---- vertices ---- */

static air_status gather_vertices(obj_reader *reader, air_mesh_file *out)
{
    air_context *context = reader->context;
    const size_t count = reader->vertices.count;
    const bool colored = reader->colors != NULL;
    const air_obj_corner *corners = reader->vertices.corners;
    bool textured = false;
    for (size_t i = 0; i < count && !textured; ++i)
        textured = corners[i].vt != AIR_OBJ_NONE;
    out->vertex_count = count;
    out->positions = air_allocate(context, 3 * count, sizeof(float));
    out->normals = reader->total.normals ? air_allocate(context, 3 * count, sizeof(float)) : NULL;
    out->uv = textured ? air_allocate(context, 2 * count, sizeof(float)) : NULL;
    out->colors = colored ? air_allocate(context, 4 * count, sizeof(float)) : NULL;
    if (out->positions == NULL || (reader->total.normals && out->normals == NULL) ||
        (textured && out->uv == NULL) || (colored && out->colors == NULL))
        return air_fail_memory(context, reader->path);
    for (size_t i = 0; i < count; ++i) {
        const size_t v = corners[i].v;
        memcpy(out->positions + 3 * i, reader->v + 3 * v, 3 * sizeof(float));
        if (reader->total.normals)
            memcpy(out->normals + 3 * i, reader->vn + 3 * (size_t)corners[i].vn, 3 * sizeof(float));
        if (corners[i].vt != AIR_OBJ_NONE)
            memcpy(out->uv + 2 * i, reader->vt + 2 * (size_t)corners[i].vt, 2 * sizeof(float));
        if (colored) {
            memcpy(out->colors + 4 * i, reader->colors + 3 * v, 3 * sizeof(float));
            out->colors[4 * i + 3] = 1.0f;
        }
    }
    return AIR_OK;
}

air_status air_mesh_obj_decode(air_context *context, const char *path, const char *text,
                               size_t size, air_mesh_file *out)
{
    obj_reader reader = {.context = context, .path = path, .text = text, .end = text + size};
    count_all(&reader);
    air_status status = allocate(&reader, out);
    if (status == AIR_OK)
        status = read_values(&reader);
    if (status == AIR_OK)
        status = read_faces(&reader, out);
    if (status == AIR_OK)
        status = gather_vertices(&reader, out);
    air_obj_vertices_finish(context, &reader.vertices);
    air_mesh_polygon_finish(context, &reader.polygon);
    air_free(context, reader.corners);
    air_free(context, reader.colors);
    air_free(context, reader.vn);
    air_free(context, reader.vt);
    air_free(context, reader.v);
    return status;
}
