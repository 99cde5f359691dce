/* fuzz_sidecar.c: any bytes as the sidecar of a small scene: no crash, no leak, a scene or an
 * error. */
#include "fuzz_scene.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* A closed tetrahedron called Fog and a light called Lamp. */
static const char scene[] = "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"mesh\":0,\"name\":"
                            "\"Fog\",\"scale\":[2,1,1]},{\"name\":\"Lamp\","
                            "\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}],"
                            "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{"
                            "\"type\":\"point\"}]}},\"meshes\":[{\"primitives\":[{\"attributes\":{"
                            "\"POSITION\":0},\"indices\":1}]}],"
                            "\"buffers\":[{\"byteLength\":60,\"uri\":\"fog.bin\"}],\"bufferViews\":"
                            "[{\"buffer\":0,\"byteLength\":48},{"
                            "\"buffer\":0,\"byteOffset\":48,\"byteLength\":12}],\"accessors\":[{"
                            "\"bufferView\":0,\"componentType\":5126,"
                            "\"count\":4,\"type\":\"VEC3\"},{\"bufferView\":1,\"componentType\":"
                            "5121,\"count\":12,\"type\":\"SCALAR\"}]}";

static const float positions[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
static const uint8_t indices[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};

/* 2x2x2 samples of one channel, and a colour picture of 2x1 pixels. */
static const float grid[8] = {0, 1, 2, 3, 4, 5, 6, 7};
static const char sky[] = "PF\n2 1\n-1.0\n\0\0\200?\0\0\200?\0\0\200?\0\0\200?\0\0\200?\0\0\200?";

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    uint8_t fog[60];
    air_load_params load;
    const char *with[] = {"input.json"};
    memcpy(fog, positions, 48);
    memcpy(fog + 48, indices, 12);
    fuzz_files files = {.files = {{"input.gltf", scene, sizeof scene - 1},
                                  {"input.json", data, size},
                                  {"fog.bin", fog, sizeof fog},
                                  {".raw", grid, sizeof grid},
                                  {".pfm", sky, sizeof sky - 1}},
                        .count = 5};
    air_load_params_default(&load);
    load.with = with;
    load.with_count = 1;
    fuzz_load_scene(&files, "input.gltf", &load);
    return 0;
}
