/* Prints src/arealight/ltc_table.c: fits at all knots; about half a minute on two cores. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "airlight/area_ltc.h"
#include "arealight/ltc_table.h"
#include "core/host.h"

static air_area_ltc fits[AIR_LTC_SIDE][AIR_LTC_SIDE];

static void fit_row(void *user, size_t i, size_t worker)
{
    (void)user;
    (void)worker;
    const double least = sqrt(1e-3), u = (double)i / (AIR_LTC_SIDE - 1);
    const double root = least + u * (1.0 - least);
    for (int j = 0; j < AIR_LTC_SIDE; j++) {
        const double v = (double)j / (AIR_LTC_SIDE - 1);
        fits[i][j] = air_area_ltc_fit(root * root, 1.0 - v * v);
    }
}

int main(void)
{
    air_context *context;
    if (air_context_create(NULL, &context) != AIR_OK) {
        return EXIT_FAILURE;
    }
    air_parallel_for(context, AIR_LTC_SIDE, fit_row, NULL);
    printf("/* ltc_table.c: fits by ltc_fit.c, printed by bench/make_ltc_table.c. */\n"
           "#include \"arealight/ltc_table.h\"\n\n"
           "const float air_ltc_table[AIR_LTC_SIDE][AIR_LTC_SIDE][5] = {\n");
    for (int i = 0; i < AIR_LTC_SIDE; i++) {
        printf("    {\n");
        for (int j = 0; j < AIR_LTC_SIDE; j++) {
            const air_area_ltc *f = &fits[i][j];
            printf("        {%.8ef, %.8ef, %.8ef, %.8ef, %.8ef},\n", f->xx, f->xz, f->zx, f->zz,
                   f->albedo);
        }
        printf("    },\n");
    }
    printf("};\n");
    air_context_destroy(context);
    return EXIT_SUCCESS;
}
