/* fuzz_nvdb.c: any bytes as a NanoVDB file: no crash, no leak, a sound grid or an error.
 *
 * The nodes of an unpacked tree are some 300 KB, nearly all zeros. So that small inputs reach them,
 * an input that begins with "P" is a file with its runs of zeros packed: a count of zeros (2 bytes,
 * little-endian), a count of bytes (1 byte), these bytes, and so on. pack_nvdb.py makes such
 * inputs. */
#include "fuzz_grid.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { MAX_FILE = 1 << 20 };

static air_status load(air_context *context, air_grid **out_grid)
{
    return air_grid_load_nvdb(context, "input.nvdb", NULL, out_grid);
}

/* out has MAX_FILE zero bytes; returns how many the file has. */
static size_t expand(const uint8_t *data, size_t size, uint8_t *out)
{
    size_t used = 0;
    for (size_t at = 1; at + 3 <= size;) {
        const size_t zeros = data[at] | (size_t)data[at + 1] << 8;
        const size_t count = data[at + 2] < size - at - 3 ? data[at + 2] : size - at - 3;
        if (zeros + count > MAX_FILE - used) {
            break;
        }
        memcpy(out + used + zeros, data + at + 3, count);
        used += zeros + count;
        at += 3 + count;
    }
    return used;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size == 0 || data[0] != 'P') {
        fuzz_load(data, size, load);
        return 0;
    }
    uint8_t *file = calloc(MAX_FILE, 1);
    if (file != NULL) {
        const size_t used = expand(data, size, file);
        fuzz_load(file, used, load);
    }
    free(file);
    return 0;
}
