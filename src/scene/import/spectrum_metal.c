#include <math.h>
#include <string.h>

#include "scene/import/spectrum.h"

typedef struct metal {
    const char *name;
    float eta[3], absorption[3];
} metal;

/* Measured indices [Palik1998], averaged as Mitsuba 3.9 averages its own tables of
 * them in its rgb variants: 4 digits of what it gives for each name. A 0 of eta is a colour that
 * the average puts out of gamut. */
static const metal metals[] = {{"Ag", {0.1553f, 0.1167f, 0.1384f}, {4.828f, 3.122f, 2.147f}},
                               {"Al", {1.658f, 0.8804f, 0.5212f}, {9.224f, 6.27f, 4.837f}},
                               {"AlAs", {3.605f, 3.233f, 2.216f}, {0.0006794f, 0.0f, 0.007513f}},
                               {"AlSb", {0.0f, 4.139f, 4.669f}, {0.0f, 0.09401f, 1.301f}},
                               {"Au", {0.143f, 0.3753f, 1.442f}, {3.983f, 2.386f, 1.603f}},
                               {"Be", {4.185f, 3.185f, 2.784f}, {3.835f, 3.01f, 2.869f}},
                               {"Cr", {4.37f, 2.917f, 1.655f}, {5.207f, 4.231f, 3.755f}},
                               {"CsI", {2.145f, 1.702f, 1.662f}, {0.0f, 0.0f, 0.0f}},
                               {"Cu", {0.201f, 0.9237f, 1.102f}, {3.913f, 2.453f, 2.142f}},
                               {"Cu2O", {3.552f, 2.95f, 2.752f}, {0.1142f, 0.1939f, 0.6061f}},
                               {"CuO", {3.248f, 2.448f, 2.21f}, {0.5211f, 0.57f, 0.7222f}},
                               {"Hg", {2.399f, 1.44f, 0.9096f}, {6.328f, 4.372f, 3.422f}},
                               {"HgTe", {4.779f, 3.231f, 2.66f}, {1.632f, 1.581f, 1.729f}},
                               {"Ir", {3.086f, 2.082f, 1.618f}, {5.592f, 4.067f, 3.267f}},
                               {"K", {0.06404f, 0.04641f, 0.03818f}, {2.104f, 1.349f, 0.9131f}},
                               {"Li", {0.2658f, 0.1956f, 0.2209f}, {3.54f, 2.311f, 1.669f}},
                               {"MgO", {2.09f, 1.651f, 1.595f}, {0.0f, 0.0f, 0.0f}},
                               {"Mo", {4.484f, 3.525f, 2.776f}, {4.111f, 3.421f, 3.151f}},
                               {"Na", {0.06027f, 0.05614f, 0.06199f}, {3.179f, 2.112f, 1.579f}},
                               {"Nb", {3.42f, 2.79f, 2.396f}, {3.441f, 2.738f, 2.58f}},
                               {"Ni", {2.367f, 1.663f, 1.467f}, {4.499f, 3.05f, 2.345f}},
                               {"Rh", {2.586f, 1.86f, 1.554f}, {6.782f, 4.703f, 3.976f}},
                               {"Se-e", {5.723f, 4.166f, 4.081f}, {0.8711f, 1.105f, 1.565f}},
                               {"Se", {4.058f, 2.843f, 2.821f}, {0.754f, 0.6384f, 0.5218f}},
                               {"SiC", {3.172f, 2.526f, 2.479f}, {0.0f, 0.0f, 1.019e-05f}},
                               {"SnTe", {4.524f, 1.982f, 1.282f}, {0.0f, 0.0f, 0.0f}},
                               {"Ta", {2.063f, 2.393f, 2.628f}, {2.408f, 1.741f, 1.947f}},
                               {"Te-e", {7.509f, 4.296f, 2.37f}, {5.584f, 4.947f, 3.998f}},
                               {"Te", {7.39f, 4.482f, 2.637f}, {3.256f, 3.527f, 3.292f}},
                               {"ThF4", {1.831f, 1.442f, 1.388f}, {0.0f, 0.0f, 0.0f}},
                               {"TiC", {3.701f, 2.837f, 2.582f}, {3.266f, 2.352f, 2.173f}},
                               {"TiN", {1.648f, 1.151f, 1.38f}, {3.368f, 1.943f, 1.102f}},
                               {"TiO2-e", {3.107f, 2.513f, 2.582f}, {2.975e-05f, 0.0f, 0.0001827f}},
                               {"TiO2", {3.457f, 2.802f, 2.905f}, {0.0001053f, 0.0f, 0.0006529f}},
                               {"VC", {3.658f, 2.753f, 2.533f}, {3.068f, 2.199f, 1.963f}},
                               {"VN", {2.866f, 2.119f, 1.94f}, {3.032f, 2.056f, 1.616f}},
                               {"V", {4.278f, 3.513f, 2.761f}, {3.491f, 2.889f, 3.112f}},
                               {"W", {4.371f, 3.3f, 2.998f}, {3.501f, 2.605f, 2.273f}},
                               {"a-C", {2.944f, 2.227f, 1.968f}, {0.8875f, 0.7993f, 0.8153f}},
                               {"d-C", {2.709f, 2.319f, 2.229f}, {0.0f, 0.0f, 0.0f}},
                               {"none", {0.0f, 0.0f, 0.0f}, {1.0f, 1.0f, 1.0f}}};

/* eta of a mirror: what is reflected is 1 - 2 eta about normal incidence, 1 in floats. */
static const float least_eta = 1e-8f;

static size_t chemical_length(const char *name)
{
    static const char suffix[] = "_palik";
    const size_t length = strlen(name), behind = sizeof suffix - 1;
    const bool has = length > behind && strcmp(name + length - behind, suffix) == 0;
    return has ? length - behind : length;
}

bool air_metal_find(const char *name, float out_eta[3], float out_absorption[3])
{
    const size_t length = chemical_length(name);
    for (size_t i = 0; i < sizeof metals / sizeof *metals; ++i) {
        if (strlen(metals[i].name) != length || memcmp(metals[i].name, name, length) != 0)
            continue;
        for (int k = 0; k < 3; ++k)
            out_eta[k] = fmaxf(metals[i].eta[k], least_eta);
        memcpy(out_absorption, metals[i].absorption, sizeof metals[i].absorption);
        return true;
    }
    return false;
}
