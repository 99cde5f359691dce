/* fuzz_lightmap.c: any bytes as a lightmap's folder: no crash, no leak, a lightmap that may be
 * saved again or an error. The bytes are lightmap.json, probes.json, cuts.bin and an EXR for all
 * images, with lines of four dashes between them. */
#include "fuzz_host.h"
#include "lightmap/check.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* The bytes up to the next line of dashes; what is behind it stays in *data. */
static fuzz_file next_part(const char *ending, const uint8_t **data, size_t *size)
{
    static const char line[] = "\n----\n";
    const size_t length = sizeof line - 1;
    size_t i = 0;
    while (i + length <= *size && memcmp(*data + i, line, length) != 0)
        ++i;
    const bool found = i + length <= *size;
    const size_t end = found ? i : *size, next = found ? i + length : *size;
    const fuzz_file part = {ending, *data, end};
    *data += next;
    *size -= next;
    return part;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_files files = {.count = 4};
    files.files[0] = next_part("lightmap.json", &data, &size);
    files.files[1] = next_part("probes.json", &data, &size);
    files.files[2] = next_part("cuts.bin", &data, &size);
    files.files[3] = next_part(".exr", &data, &size);
    air_context *context = fuzz_context(&files, NULL);
    if (context == NULL)
        return 0;
    air_lightmap *lightmap = NULL;
    const air_status status = air_lightmap_load(context, "bake", &lightmap);
    fuzz_check_outcome(context, status, lightmap);
    if (lightmap != NULL &&
        air_lightmap_check(context, lightmap, "again", AIR_ERROR_ARGUMENT) != AIR_OK)
        abort();
    air_lightmap_destroy(lightmap);
    air_context_destroy(context);
    return 0;
}
