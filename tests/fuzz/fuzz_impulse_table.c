/* fuzz_impulse_table.c: any bytes as tables of impulse responses: no crash, no leak, finite
 * irradiances or an error. */
#include <math.h>

#include "airlight/impulse.h"
#include "fuzz_host.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void ask(const air_impulse_tables *tables)
{
    for (int i = 0; i < 3 * 12; i++) {
        const air_impulse_medium medium = {.sigma_s = 0.3 + 0.1 * (i % 2),
                                           .sigma_t = 0.4,
                                           .g = 0.3 * (i % 5) - 0.6,
                                           .bounces = 20,
                                           .rule = (air_impulse_rule)(i % 2)};
        const air_impulse_place place = {.distance = pow(2.0, i / 3 - 6),
                                         .n_l = 0.2 * (i % 11) - 1.0,
                                         .cos_s = 0.25 * (i % 9) - 1.0,
                                         .n_x = 0.1};
        const double e =
            air_impulse_irradiance(tables, (air_impulse_emitter)(i % 3), &medium, &place);
        if (!isfinite(e) || !(e >= 0.0)) {
            abort();
        }
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_files files = {.files = {{"", data, size}}, .count = 1};
    air_context *context = fuzz_context(&files, NULL);
    air_impulse_tables *tables;
    bool is;
    if (context == NULL) {
        return 0;
    }
    (void)air_impulse_is_tables(context, "input.impulse", &is);
    if (air_impulse_tables_load(context, "input.impulse", &tables) == AIR_OK) {
        ask(tables);
        air_impulse_tables_destroy(tables);
    }
    air_context_destroy(context);
    return 0;
}
