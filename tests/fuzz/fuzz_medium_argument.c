/* fuzz_medium_argument.c: any text as a --medium, and as an --environment: no crash, no leak, a
 * scene or an error. */
#include "fuzz_scene.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static const char scene[] = "{\"asset\":{\"version\":\"2.0\"}}";
static const float grid[8] = {0, 1, 2, 3, 4, 5, 6, 7};

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    air_load_params load;
    fuzz_files files = {
        .files = {{"input.gltf", scene, sizeof scene - 1}, {".raw", grid, sizeof grid}},
        .count = 2};
    char *text = malloc(size + 1);
    if (text == NULL)
        return 0;
    if (size > 0)
        memcpy(text, data, size);
    text[size] = '\0';
    const char *media[] = {text};
    air_load_params_default(&load);
    load.media = media;
    load.media_count = 1;
    fuzz_load_scene(&files, "input.gltf", &load);
    load.media_count = 0;
    load.environment = text;
    fuzz_load_scene(&files, "input.gltf", &load);
    free(text);
    return 0;
}
