/* ktx2.h: numbers of the KTX 2 container that reader and writer share. */
#ifndef AIR_IMAGE_KTX2_H
#define AIR_IMAGE_KTX2_H

#include <stdint.h>

/* Names of Vulkan's formats [KTX2, section 3.1]. */
enum {
    AIR_VK_R16G16B16A16_SFLOAT = 97,
    AIR_VK_R32G32B32A32_SFLOAT = 109,
    AIR_VK_B10G11R11_UFLOAT_PACK32 = 122,
    AIR_VK_E5B9G9R9_UFLOAT_PACK32 = 123
};

enum {
    AIR_KTX2_HEADER = 80,  /* bytes before the index of levels */
    AIR_KTX2_LEVEL = 24,   /* bytes of an entry of that index */
    AIR_KTX2_ZSTANDARD = 2 /* supercompressionScheme */
};

static const uint8_t air_ktx2_identifier[12] = {0xab, 'K',  'T',  'X',  ' ',  '2',
                                                '0',  0xbb, '\r', '\n', 0x1a, '\n'};

#endif
