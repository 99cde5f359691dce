#include <airlight/render.h>
#include <jansson.h>
#include <stdio.h>
#include <string.h>

#include "host.h"
#include "output.h"
#include "scene_options.h"

static const cli_usage info_usage = {
    .command = "info",
    .arguments = "FILE",
    .summary =
        "Tells what was understood of a scene: triangles, lights, media with the kind of "
        "their boundary, cameras, bounds, the units assumed, which method owns which part "
        "of the light, warnings. Of an image (.exr, .hdr, .png, .jpg, .pfm, .ktx2) or a .film: "
        "size, channels and attributes.",
    .examples = "  airlight info room.glb\n"
                "  airlight info room.glb --medium visibility=50m --json\n"
                "  airlight info room.exr\n",
    .argument_min = 1,
    .argument_max = 1,
};

typedef struct info_options {
    bool json;
} info_options;

static const cli_option info_table[] = {
    {.name = "json",
     .kind = CLI_FLAG,
     .offset = offsetof(info_options, json),
     .help = "Print everything as a JSON object."},
};

/* ---- JSON as text ---- */

static void print_scalar(const json_t *value)
{
    if (json_is_string(value)) {
        printf("%s", json_string_value(value));
    } else if (json_is_integer(value)) {
        printf("%" JSON_INTEGER_FORMAT, json_integer_value(value));
    } else if (json_is_real(value)) {
        printf("%.6g", json_real_value(value));
    } else if (json_is_boolean(value)) {
        printf("%s", json_is_true(value) ? "yes" : "no");
    } else {
        printf("none");
    }
}

/* Handles mean nothing to a reader, and a name comes first by itself. */
static bool in_line(const char *key)
{
    return strcmp(key, "handle") != 0 && strcmp(key, "name") != 0;
}

/* Depth of nesting from here on is that of the description, a few levels. */
static void print_in_line(const json_t *value)
{
    size_t index, count = 0;
    const char *key;
    json_t *item;
    if (json_is_object(value)) {
        const char *const name = json_string_value(json_object_get(value, "name"));
        if (name != NULL && name[0] != '\0') {
            printf("\"%s\"", name);
            count++;
        }
        json_object_foreach((json_t *)value, key, item)
        {
            if (in_line(key)) {
                printf("%s%s ", count++ == 0 ? "" : ", ", key);
                print_in_line(item);
            }
        }
    } else if (json_is_array(value)) {
        putchar('(');
        json_array_foreach(value, index, item)
        {
            printf("%s", index == 0 ? "" : " ");
            print_in_line(item);
        }
        putchar(')');
    } else {
        print_scalar(value);
    }
}

/* Numbers side by side, anything else one item a line; after so many lines the reader wants JSON.
 */
static void print_array(const json_t *value)
{
    enum { LINE_MAX_COUNT = 24 };
    const size_t count = json_array_size(value);
    size_t index;
    json_t *item;
    if (count == 0) {
        printf(" none\n");
        return;
    }
    if (json_is_number(json_array_get(value, 0))) {
        putchar(' ');
        print_in_line(value);
        putchar('\n');
        return;
    }
    putchar('\n');
    json_array_foreach(value, index, item)
    {
        if (index == LINE_MAX_COUNT && count > LINE_MAX_COUNT + 1) {
            printf("  and %zu more (--json lists all)\n", count - index);
            break;
        }
        printf("  %zu: ", index);
        print_in_line(item);
        putchar('\n');
    }
}

/* ---- owners: a line for each light, as short as what differs allows ---- */

static bool same_member(const json_t *a, const json_t *b, const char *key)
{
    const json_t *const x = json_object_get(a, key), *const y = json_object_get(b, key);
    return x == y || json_equal(x, y);
}

static bool same_owner(const json_t *a, const json_t *b)
{
    return same_member(a, b, "method") && same_member(a, b, "mode");
}

/* The first row before `limit` that agrees with it in light and owner, and, unless any_term, in the
 * term; `limit` if there is none. */
static size_t first_alike(const json_t *owners, size_t limit, bool any_term)
{
    const json_t *const row = json_array_get(owners, limit);
    for (size_t i = 0; i < limit; i++) {
        const json_t *const other = json_array_get(owners, i);
        if (same_member(row, other, "light_index") && same_owner(row, other) &&
            (any_term || same_member(row, other, "term"))) {
            return i;
        }
    }
    return limit;
}

static void print_owner(const json_t *row)
{
    const char *const mode = json_string_value(json_object_get(row, "mode"));
    printf(" %s%s%s", json_string_value(json_object_get(row, "method")), mode != NULL ? ":" : "",
           mode != NULL ? mode : "");
}

/* "METHOD of TERM, TERM": the terms of one light that the owner of row i has. */
static void print_share(const json_t *owners, size_t i)
{
    const json_t *const row = json_array_get(owners, i);
    const char *before = " of ";
    size_t k;
    json_t *other;
    print_owner(row);
    json_array_foreach(owners, k, other)
    {
        if (same_member(row, other, "light_index") && same_owner(row, other) &&
            first_alike(owners, k, false) == k) {
            printf("%s%s", before, json_string_value(json_object_get(other, "term")));
            before = ", ";
        }
    }
}

static bool single_owner(const json_t *owners)
{
    size_t i;
    json_t *row;
    json_array_foreach(owners, i, row)
    {
        if (!same_owner(row, json_array_get(owners, 0))) {
            return false;
        }
    }
    return json_array_size(owners) > 0;
}

static void print_owners(const json_t *owners)
{
    const json_t *light = NULL;
    size_t i;
    json_t *row;
    printf("owners:");
    if (single_owner(owners)) {
        print_owner(json_array_get(owners, 0));
        printf(" of every light, medium and term\n");
        return;
    }
    json_array_foreach(owners, i, row)
    {
        if (first_alike(owners, i, true) != i) {
            continue;
        }
        if (light == NULL || !same_member(light, row, "light_index")) {
            light = row;
            printf("\n  \"%s\":", json_string_value(json_object_get(row, "light")));
        } else {
            putchar(';');
        }
        print_share(owners, i);
    }
    putchar('\n');
}

/* One entry of the top level: a line, or a heading with a line for each member. */
static void print_entry(const char *key, const json_t *value)
{
    const char *member;
    json_t *item;
    if (strcmp(key, "owners") == 0 && json_array_size(value) > 0) {
        print_owners(value);
        return;
    }
    printf("%s:", key);
    if (json_is_array(value)) {
        print_array(value);
    } else if (json_is_object(value)) {
        putchar('\n');
        json_object_foreach((json_t *)value, member, item)
        {
            printf("  %s ", member);
            print_in_line(item);
            putchar('\n');
        }
    } else {
        putchar(' ');
        print_scalar(value);
        putchar('\n');
    }
}

static void print_description(json_t *description, bool json)
{
    const char *key;
    json_t *value;
    if (json) {
        json_dumpf(description, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
        putchar('\n');
        return;
    }
    json_object_foreach(description, key, value) { print_entry(key, value); }
}

/* ---- images and films ---- */

/* json_string refuses what is not UTF-8; files may hold anything. */
static json_t *text_or_null(const char *text)
{
    json_t *const value = json_string(text);
    return value != NULL ? value : json_null();
}

static json_t *describe_image(const air_image *image)
{
    json_t *const channels = json_array();
    json_t *const attributes = json_object();
    for (size_t i = 0; i < air_image_channel_count(image); i++) {
        json_array_append_new(channels, text_or_null(air_image_channel_name(image, i)));
    }
    for (size_t i = 0; i < air_image_attribute_count(image); i++) {
        const char *const name = air_image_attribute_name(image, i);
        json_object_set_new(attributes, name, text_or_null(air_image_attribute(image, name)));
    }
    return json_pack("{s:I, s:I, s:o, s:o}", "width", (json_int_t)air_image_width(image), "height",
                     (json_int_t)air_image_height(image), "channels", channels, "attributes",
                     attributes);
}

static cli_exit open_film(cli_host *host, const char *path, json_t **out_description)
{
    air_film *film = NULL;
    air_image *image = NULL;
    uint32_t begin, end;
    air_status status = air_film_load(host->context, path, &film);
    if (status == AIR_OK) {
        status = air_film_resolve(film, NULL, &image);
    }
    if (status == AIR_OK) {
        air_film_samples(film, &begin, &end);
        *out_description = describe_image(image);
        json_object_set_new(*out_description, "samples",
                            json_pack("[I, I]", (json_int_t)begin, (json_int_t)end));
    }
    air_image_destroy(image);
    air_film_destroy(film);
    return cli_host_exit(host, status, path);
}

static cli_exit open_image(cli_host *host, const char *path, json_t **out_description)
{
    air_image *image = NULL;
    const air_status status = air_image_load(host->context, path, &image);
    if (status == AIR_OK) {
        *out_description = describe_image(image);
    }
    air_image_destroy(image);
    return cli_host_exit(host, status, path);
}

/* ---- the command ---- */

static cli_exit open_file(cli_host *host, const char *path, const cli_scene_options *options,
                          json_t **out_description)
{
    static const char *const images[] = {".exr", ".hdr", ".png", ".jpg", ".jpeg", ".pfm", ".ktx2"};
    air_snapshot *snapshot = NULL;
    if (cli_has_extension(path, ".film")) {
        return open_film(host, path, out_description);
    }
    for (size_t i = 0; i < sizeof images / sizeof images[0]; i++) {
        if (cli_has_extension(path, images[i])) {
            return open_image(host, path, out_description);
        }
    }
    const cli_exit result = cli_scene_open(host, path, options, &snapshot, out_description);
    air_snapshot_release(snapshot);
    return result;
}

cli_exit cli_info(int argc, char **argv)
{
    info_options options = {.json = false};
    cli_scene_options scene_options = {.environment = NULL};
    cli_host_options host_options = {0};
    cli_host host = {0};
    json_t *description = NULL;
    const cli_option_group groups[] = {
        {"Output", info_table, sizeof info_table / sizeof info_table[0], &options},
        cli_scene_group(&scene_options),
        cli_host_group(&host_options),
    };
    const cli_parsed parsed =
        cli_parse(&info_usage, groups, sizeof groups / sizeof groups[0], &argc, argv);
    if (parsed != CLI_PARSED) {
        return parsed == CLI_PARSED_HELP ? CLI_OK : CLI_USAGE;
    }
    cli_exit result = cli_host_open(&host, &host_options);
    if (result == CLI_OK) {
        result = open_file(&host, argv[0], &scene_options, &description);
    }
    cli_progress_clear(&host.progress);
    if (result == CLI_OK) {
        print_description(description, options.json);
    }
    json_decref(description);
    cli_host_close(&host);
    return result;
}
