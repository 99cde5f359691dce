/* vec.c: affine maps, computed in double. */
#include "core/vec.h"

void affine_multiply(const float a[12], const float b[12], float out[12])
{
    float product[12];
    for (int row = 0; row < 3; ++row) {
        const float *r = a + 4 * row;
        for (int column = 0; column < 4; ++column) {
            const double sum = (double)r[0] * b[column] + (double)r[1] * b[4 + column] +
                               (double)r[2] * b[8 + column] + (column == 3 ? (double)r[3] : 0.0);
            product[4 * row + column] = (float)sum;
        }
    }
    for (int i = 0; i < 12; ++i) {
        out[i] = product[i];
    }
}

bool affine_invert(const float m[12], float out[12])
{
    const double determinant = affine_determinant(m);
    if (!isfinite(determinant) || determinant == 0.0) {
        return false;
    }
    double inverse[12];
    for (int row = 0; row < 3; ++row) {
        /* Cofactors with cyclic indices carry their sign already. */
        const int c1 = (row + 1) % 3, c2 = (row + 2) % 3;
        for (int column = 0; column < 3; ++column) {
            const int r1 = (column + 1) % 3, r2 = (column + 2) % 3;
            inverse[4 * row + column] = ((double)m[4 * r1 + c1] * m[4 * r2 + c2] -
                                         (double)m[4 * r1 + c2] * m[4 * r2 + c1]) /
                                        determinant;
        }
        const double *r = inverse + 4 * row;
        inverse[4 * row + 3] = -(r[0] * m[3] + r[1] * m[7] + r[2] * m[11]);
    }
    for (int i = 0; i < 12; ++i) {
        if (!isfinite((float)inverse[i])) {
            return false;
        }
    }
    for (int i = 0; i < 12; ++i) {
        out[i] = (float)inverse[i];
    }
    return true;
}
