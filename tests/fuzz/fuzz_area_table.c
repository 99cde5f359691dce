/* fuzz_area_table.c: any bytes as a table of fitted lobes or of transformed cosines: no crash, no
 * leak, a table whose entries are finite or an error. */
#include <math.h>

#include "airlight/area_ltc.h"
#include "airlight/area_table.h"
#include "fuzz_host.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_files files = {.files = {{"", data, size}}, .count = 1};
    air_context *context = fuzz_context(&files, NULL);
    air_area_table table;
    if (context == NULL) {
        return 0;
    }
    if (air_area_table_load(context, "input.json", &table) == AIR_OK) {
        for (double g = -1.0; g <= 1.0; g += 0.05) {
            const air_area_lobe lobe = air_area_table_lobe(&table, g);
            if (!isfinite(lobe.s_near + lobe.w_near + lobe.s_far + lobe.w_far) ||
                !(lobe.s_near > 0.0) || !(lobe.s_far > 0.0)) {
                abort();
            }
        }
    }
    static air_area_ltc_table ltc;
    if (air_area_ltc_table_load(context, "input.json", &ltc) == AIR_OK) {
        for (double x = 0.0; x <= 1.0; x += 0.05) {
            const air_area_ltc fit = air_area_ltc_at(&ltc, x * x, x);
            if (!isfinite(fit.xx + fit.xz + fit.zx + fit.zz + fit.albedo)) {
                abort();
            }
        }
    }
    air_context_destroy(context);
    return 0;
}
