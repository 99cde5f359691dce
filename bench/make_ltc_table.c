/* Prints src/arealight/ltc_table.c: fits at all knots. */
#include <airlight/airlight.h>
#include <airlight/area_ltc.h>
#include <stdio.h>
#include <stdlib.h>

int main(void)
{
    static air_area_ltc_table table;
    air_context *context;
    if (air_context_create(NULL, &context) != AIR_OK) {
        return EXIT_FAILURE;
    }
    air_area_ltc_table_fit(context, &table);
    printf("/* ltc_table.c: fits by ltc_fit.c, printed by bench/make_ltc_table.c. */\n"
           "#include \"arealight/ltc_table.h\"\n\n"
           "const air_area_ltc_table air_ltc_table = {{\n");
    for (int i = 0; i < AIR_LTC_SIDE; i++) {
        printf("    {\n");
        for (int j = 0; j < AIR_LTC_SIDE; j++) {
            const air_area_ltc *f = &table.knots[i][j];
            printf("        {%.9e, %.9e, %.9e, %.9e, %.9e},\n", f->xx, f->xz, f->zx, f->zz,
                   f->albedo);
        }
        printf("    },\n");
    }
    printf("}};\n");
    air_context_destroy(context);
    return EXIT_SUCCESS;
}
