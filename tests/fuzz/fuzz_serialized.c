/* fuzz_serialized.c: any bytes as a .serialized file, and as what its zlib stream holds: no crash,
 * no leak, a sound mesh or an error. */
#include <zlib.h>

#include "fuzz_mesh.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { HEADER_SIZE = 4, DICTIONARY_SIZE = 12 };

/* A file of one shape of version 4 around these contents. */
static void fuzz_contents(const uint8_t *data, size_t size)
{
    static const uint8_t header[HEADER_SIZE] = {0x1c, 0x04, 4, 0};
    static const uint8_t dictionary[DICTIONARY_SIZE] = {[8] = 1};
    uLongf packed = compressBound((uLong)size);
    uint8_t *file = malloc(HEADER_SIZE + packed + DICTIONARY_SIZE);
    if (file == NULL)
        return;
    if (compress2(file + HEADER_SIZE, &packed, data, (uLong)size, 1) == Z_OK) {
        memcpy(file, header, sizeof header);
        memcpy(file + HEADER_SIZE + packed, dictionary, sizeof dictionary);
        fuzz_mesh(file, HEADER_SIZE + packed + DICTIONARY_SIZE, AIR_MESH_SERIALIZED, 0);
    }
    free(file);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_mesh(data, size, AIR_MESH_SERIALIZED, 0);
    fuzz_mesh(data, size, AIR_MESH_SERIALIZED, 1);
    fuzz_contents(data, size);
    return 0;
}
