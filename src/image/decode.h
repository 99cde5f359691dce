/* decode.h: compressed 8-bit pictures (PNG, JPEG) from memory. */
#ifndef AIR_IMAGE_DECODE_H
#define AIR_IMAGE_DECODE_H

#include "core/host.h"

/* Decodes `size` bytes at `data` into *out_bytes: row 0 at the top, *out_channels (1 to 4)
 * interleaved, 16-bit pictures reduced to 8. The caller frees *out_bytes with air_free. `what`
 * names the picture in messages (a file name, or a place within a file). AIR_ERROR_FORMAT: not a
 * PNG or JPEG, truncated, a side above 65535 or more than 2^31 bytes. On failure the outputs are
 * untouched. */
air_status air_decode_bytes(air_context *context, const void *data, size_t size, const char *what,
                            size_t *out_width, size_t *out_height, size_t *out_channels,
                            uint8_t **out_bytes);

#endif
