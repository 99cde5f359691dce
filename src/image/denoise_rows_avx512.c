/* denoise_rows_avx512.c: the denoiser's inner loops for AVX-512. */
#include "image/denoise_rows.h"

void air_denoise_row_avx512(const air_denoise_level *level, size_t row) { filter_row(level, row); }
