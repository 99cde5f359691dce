/* denoise_rows_avx2.c: the denoiser's inner loops for AVX2. */
#include "image/denoise_rows.h"

void air_denoise_row_avx2(const air_denoise_level *level, size_t row) { filter_row(level, row); }
