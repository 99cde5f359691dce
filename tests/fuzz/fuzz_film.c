/* fuzz_film.c: any bytes as a film: no crash, no leak, a film that can be merged and resolved or an
 * error. */
#include "airlight/render.h"
#include "fuzz_host.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* What `airlight merge` does with films, the same one twice: samples must not count twice, and what
 * has samples has a picture of its size. */
static void use(air_context *context, air_film *film, const air_film *again)
{
    uint32_t begin, end;
    air_image *image = NULL;
    air_film_samples(film, &begin, &end);
    if ((air_film_merge(film, again) == AIR_OK) != (begin == end))
        abort();
    const air_status status = air_film_resolve(film, NULL, &image);
    fuzz_check_outcome(context, status, image);
    if (image != NULL && (air_image_width(image) != air_film_width(film) ||
                          air_image_height(image) != air_film_height(film)))
        abort();
    if (image == NULL && begin != end && status != AIR_ERROR_MEMORY)
        abort();
    air_image_destroy(image);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_files files = {.files = {{"", data, size}}, .count = 1};
    air_context *context = fuzz_context(&files, NULL);
    air_film *film = NULL, *again = NULL;
    if (context == NULL)
        return 0;
    const air_status status = air_film_load(context, "input.film", &film);
    fuzz_check_outcome(context, status, film);
    if (film != NULL && air_film_load(context, "input.film", &again) == AIR_OK)
        use(context, film, again);
    air_film_destroy(again);
    air_film_destroy(film);
    air_context_destroy(context);
    return 0;
}
