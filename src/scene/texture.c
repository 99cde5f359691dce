#include "scene/texture.h"

#include "scene/subject.h"

enum { MAX_TEXTURE_SIDE = 1 << 20 };

/* ---- making ---- */

static void destroy_texture(air_record *record)
{
    air_texture *texture = &((air_texture_record *)record)->texture;
    air_free(record->context, texture->bytes);
    air_free(record->context, texture->floats);
}

static air_status check_texture(air_context *context, const air_texture_desc *desc)
{
    const air_subject subject = {context, "texture", desc->name};
    air_status status = AIR_OK;
    if (desc->width < 1 || desc->height < 1 || desc->width > MAX_TEXTURE_SIDE ||
        desc->height > MAX_TEXTURE_SIDE)
        return air_subject_fail(&subject, "size is %zu x %zu, but must be from 1 x 1 to %d x %d",
                                desc->width, desc->height, MAX_TEXTURE_SIDE, MAX_TEXTURE_SIDE);
    if (desc->channels < 1 || desc->channels > 4)
        return air_subject_fail(&subject, "channels is %zu, but must be in 1..4", desc->channels);
    if ((desc->bytes == NULL) == (desc->floats == NULL))
        return air_subject_fail(&subject, "exactly one of bytes and floats must be set");
    if ((status = air_subject_check_enum(&subject, "wrap_u", (int)desc->wrap_u, 3)) != AIR_OK ||
        (status = air_subject_check_enum(&subject, "wrap_v", (int)desc->wrap_v, 3)) != AIR_OK ||
        (status = air_subject_check_enum(&subject, "filter", (int)desc->filter, 2)) != AIR_OK)
        return status;
    if (desc->floats != NULL)
        status =
            air_subject_check(&subject, "floats", desc->floats,
                              desc->width * desc->height * desc->channels, -INFINITY, INFINITY);
    return status;
}

air_status air_texture_record_create(air_context *context, const air_texture_desc *desc,
                                     air_record **out_record)
{
    const air_status status = check_texture(context, desc);
    if (status != AIR_OK)
        return status;
    air_texture_record *record =
        air_record_create(context, sizeof *record, destroy_texture, desc->name);
    if (record == NULL)
        return AIR_ERROR_MEMORY;
    bool ok = true;
    const size_t count = desc->width * desc->height * desc->channels;
    air_texture *texture = &record->texture;
    texture->name = record->base.name;
    texture->width = desc->width;
    texture->height = desc->height;
    texture->channels = desc->channels;
    texture->bytes = air_record_copy(context, desc->bytes, count, 1, &ok);
    texture->floats = air_record_copy(context, desc->floats, count, sizeof(float), &ok);
    texture->srgb = desc->srgb;
    texture->wrap_u = desc->wrap_u;
    texture->wrap_v = desc->wrap_v;
    texture->filter = desc->filter;
    if (!ok) {
        air_record_release(&record->base);
        return air_fail_memory(context, "texture");
    }
    *out_record = &record->base;
    return AIR_OK;
}

/* ---- looking up ---- */

/* The inverse of the sRGB transfer function [IEC61966-2-1] of i/255. */
static const float srgb_to_linear[256] = {
    0.0f,           0.000303526984f, 0.000607053967f, 0.000910580951f, 0.00121410793f,
    0.00151763492f, 0.0018211619f,   0.00212468888f,  0.00242821587f,  0.00273174285f,
    0.00303526984f, 0.00334653576f,  0.00367650732f,  0.00402471702f,  0.00439144204f,
    0.00477695348f, 0.0051815167f,   0.00560539162f,  0.00604883302f,  0.00651209079f,
    0.00699541019f, 0.00749903204f,  0.00802319299f,  0.00856812562f,  0.0091340587f,
    0.00972121732f, 0.010329823f,    0.010960094f,    0.0116122452f,   0.0122864884f,
    0.0129830323f,  0.013702083f,    0.0144438436f,   0.0152085144f,   0.0159962934f,
    0.0168073758f,  0.0176419545f,   0.0185002201f,   0.019382361f,    0.0202885631f,
    0.0212190104f,  0.0221738848f,   0.0231533662f,   0.0241576324f,   0.0251868596f,
    0.0262412219f,  0.0273208916f,   0.0284260395f,   0.0295568344f,   0.0307134437f,
    0.0318960331f,  0.0331047666f,   0.0343398068f,   0.0356013149f,   0.0368894504f,
    0.0382043716f,  0.0395462353f,   0.0409151969f,   0.0423114106f,   0.0437350293f,
    0.0451862044f,  0.0466650863f,   0.0481718242f,   0.049706566f,    0.0512694584f,
    0.052860647f,   0.0544802764f,   0.05612849f,     0.0578054302f,   0.0595112382f,
    0.0612460542f,  0.0630100177f,   0.0648032667f,   0.0666259386f,   0.0684781698f,
    0.0703600957f,  0.0722718507f,   0.0742135684f,   0.0761853815f,   0.0781874218f,
    0.0802198203f,  0.0822827071f,   0.0843762115f,   0.086500462f,    0.0886555863f,
    0.0908417112f,  0.0930589628f,   0.0953074666f,   0.0975873471f,   0.0998987282f,
    0.102241733f,   0.104616484f,    0.107023103f,    0.109461711f,    0.111932428f,
    0.114435374f,   0.116970668f,    0.119538428f,    0.122138772f,    0.124771818f,
    0.12743768f,    0.130136477f,    0.132868322f,    0.13563333f,     0.138431615f,
    0.141263291f,   0.144128471f,    0.147027266f,    0.14995979f,     0.152926152f,
    0.155926464f,   0.158960835f,    0.162029376f,    0.165132195f,    0.1682694f,
    0.171441101f,   0.174647404f,    0.177888416f,    0.181164244f,    0.184474995f,
    0.187820772f,   0.191201683f,    0.19461783f,     0.19806932f,     0.201556254f,
    0.205078736f,   0.20863687f,     0.212230757f,    0.2158605f,      0.2195262f,
    0.223227957f,   0.226965874f,    0.230740049f,    0.234550582f,    0.238397574f,
    0.242281122f,   0.246201327f,    0.250158285f,    0.254152094f,    0.258182853f,
    0.262250658f,   0.266355605f,    0.270497791f,    0.274677312f,    0.278894263f,
    0.28314874f,    0.287440838f,    0.29177065f,     0.296138271f,    0.300543794f,
    0.304987314f,   0.309468923f,    0.313988713f,    0.318546778f,    0.323143209f,
    0.327778098f,   0.332451536f,    0.337163615f,    0.341914425f,    0.346704056f,
    0.3515326f,     0.356400144f,    0.36130678f,     0.366252596f,    0.37123768f,
    0.376262123f,   0.381326011f,    0.386429434f,    0.391572478f,    0.396755231f,
    0.40197778f,    0.407240212f,    0.412542613f,    0.417885071f,    0.42326767f,
    0.428690497f,   0.434153636f,    0.439657174f,    0.445201195f,    0.450785783f,
    0.456411023f,   0.462077f,       0.467783796f,    0.473531496f,    0.479320183f,
    0.48514994f,    0.49102085f,     0.496932995f,    0.502886458f,    0.508881321f,
    0.514917665f,   0.520995573f,    0.527115126f,    0.533276404f,    0.539479489f,
    0.545724461f,   0.552011402f,    0.55834039f,     0.564711506f,    0.571124829f,
    0.57758044f,    0.584078418f,    0.590618841f,    0.597201788f,    0.603827339f,
    0.610495571f,   0.617206562f,    0.623960392f,    0.630757136f,    0.637596874f,
    0.644479682f,   0.651405637f,    0.658374817f,    0.665387298f,    0.672443157f,
    0.67954247f,    0.686685312f,    0.693871761f,    0.701101892f,    0.70837578f,
    0.715693501f,   0.723055129f,    0.73046074f,     0.737910409f,    0.74540421f,
    0.752942217f,   0.760524505f,    0.768151147f,    0.775822218f,    0.783537792f,
    0.79129794f,    0.799102738f,    0.806952258f,    0.814846572f,    0.822785754f,
    0.830769877f,   0.838799012f,    0.846873232f,    0.854992608f,    0.863157213f,
    0.871367119f,   0.879622397f,    0.887923118f,    0.896269353f,    0.904661174f,
    0.913098652f,   0.921581856f,    0.930110858f,    0.938685728f,    0.947306537f,
    0.955973353f,   0.964686248f,    0.97344529f,     0.98225055f,     0.991102097f,
    1.0f,
};

static float colour_value(const air_texture *texture, size_t index)
{
    if (texture->floats != NULL)
        return texture->floats[index];
    const uint8_t byte = texture->bytes[index];
    return texture->srgb ? srgb_to_linear[byte] : (float)byte * (1.0f / 255.0f);
}

static float alpha_value(const air_texture *texture, size_t index)
{
    return texture->floats != NULL ? texture->floats[index]
                                   : (float)texture->bytes[index] * (1.0f / 255.0f);
}

void air_texture_texel(const air_texture *texture, size_t x, size_t y, float out_rgba[4])
{
    const size_t channels = texture->channels;
    const size_t first = (y * texture->width + x) * channels;
    if (channels == 3 && texture->srgb && texture->bytes != NULL) { /* the usual case */
        const uint8_t *bytes = texture->bytes + first;
        for (size_t i = 0; i < 3; ++i)
            out_rgba[i] = srgb_to_linear[bytes[i]];
        out_rgba[3] = 1.0f;
        return;
    }
    out_rgba[0] = colour_value(texture, first);
    if (channels < 3) {
        out_rgba[1] = out_rgba[2] = out_rgba[0];
    } else {
        out_rgba[1] = colour_value(texture, first + 1);
        out_rgba[2] = colour_value(texture, first + 2);
    }
    out_rgba[3] =
        channels == 2 || channels == 4 ? alpha_value(texture, first + channels - 1) : 1.0f;
}

/* A coordinate brought into [0, 1]; what is not a number becomes 0. */
static float wrap_coordinate(float u, air_wrap wrap)
{
    float wrapped = u;
    if (wrap == AIR_WRAP_REPEAT) {
        wrapped = u - floorf(u);
    } else if (wrap == AIR_WRAP_MIRROR) {
        const float period = u - 2.0f * floorf(0.5f * u);
        wrapped = period > 1.0f ? 2.0f - period : period;
    }
    return wrapped > 0.0f ? float_min(wrapped, 1.0f) : 0.0f;
}

/* The two texels around a wrapped coordinate and the share of the second; texel i is centred at (i
 * + 1/2) / size. Beyond the edge a repeated texture goes on at the other side; clamped and mirrored
 * ones hold the edge texel. */
static float texel_pair(float wrapped, size_t size, air_wrap wrap, size_t out_texels[2])
{
    const float x = wrapped * (float)size + 0.5f;
    size_t upper = (size_t)x;
    if (upper > size)
        upper = size;
    const bool repeat = wrap == AIR_WRAP_REPEAT;
    out_texels[0] = upper > 0 ? upper - 1 : (repeat ? size - 1 : 0);
    out_texels[1] = upper < size ? upper : (repeat ? 0 : size - 1);
    return float_min(x - (float)upper, 1.0f);
}

static size_t nearest_texel(float wrapped, size_t size)
{
    const size_t texel = (size_t)(wrapped * (float)size);
    return texel < size ? texel : size - 1;
}

void air_texture_lookup(const air_texture *texture, float u, float v, float out_rgba[4])
{
    const float wrapped_u = wrap_coordinate(u, texture->wrap_u);
    const float wrapped_v = wrap_coordinate(v, texture->wrap_v);
    if (texture->filter == AIR_TEXTURE_NEAREST) {
        air_texture_texel(texture, nearest_texel(wrapped_u, texture->width),
                          nearest_texel(wrapped_v, texture->height), out_rgba);
        return;
    }
    size_t x[2], y[2];
    float corner[4][4];
    const float share_x = texel_pair(wrapped_u, texture->width, texture->wrap_u, x);
    const float share_y = texel_pair(wrapped_v, texture->height, texture->wrap_v, y);
    for (size_t i = 0; i < 4; ++i)
        air_texture_texel(texture, x[i & 1], y[i >> 1], corner[i]);
    for (size_t channel = 0; channel < 4; ++channel) {
        const float top = corner[0][channel] + share_x * (corner[1][channel] - corner[0][channel]);
        const float bottom =
            corner[2][channel] + share_x * (corner[3][channel] - corner[2][channel]);
        out_rgba[channel] = top + share_y * (bottom - top);
    }
}

air_vec3 air_texture_rgb(const air_texture *texture, float u, float v)
{
    float rgba[4];
    air_texture_lookup(texture, u, v, rgba);
    return vec3_load(rgba);
}

/* RGB at the point of the triangle with barycentrics (b1, b2). */
static air_vec3 triangle_rgb(const air_texture *texture, const float uv[3][2], float b1, float b2)
{
    const float b0 = 1.0f - b1 - b2;
    return air_texture_rgb(texture, b0 * uv[0][0] + b1 * uv[1][0] + b2 * uv[2][0],
                           b0 * uv[0][1] + b1 * uv[1][1] + b2 * uv[2][1]);
}

air_vec3 air_texture_triangle_mean(const air_texture *texture, const float uv[3][2])
{
    float texels = 1.0f; /* how many texels the triangle's bounding square has along a side */
    for (size_t i = 0; i < 3; ++i) {
        const size_t j = (i + 1) % 3;
        texels = fmaxf(texels, fabsf(uv[i][0] - uv[j][0]) * (float)texture->width);
        texels = fmaxf(texels, fabsf(uv[i][1] - uv[j][1]) * (float)texture->height);
    }
    const size_t n = (size_t)ceilf(fminf(texels, 64.0f));
    /* n^2 equal parts, each at its centroid: those that point as the triangle does, and those
     * between them */
    const float step = 1.0f / (float)n;
    air_vec3 sum = vec3_set1(0.0f);
    for (size_t i = 0; i < n; ++i) {
        for (size_t j = 0; i + j < n; ++j) {
            const float b1 = (float)i * step, b2 = (float)j * step;
            sum = vec3_add(sum, triangle_rgb(texture, uv, b1 + step / 3.0f, b2 + step / 3.0f));
            if (i + j + 1 < n)
                sum = vec3_add(sum, triangle_rgb(texture, uv, b1 + step * 2.0f / 3.0f,
                                                 b2 + step * 2.0f / 3.0f));
        }
    }
    return vec3_scale(sum, step * step);
}
