/* roombeam_quadrature: writes the reference picture of the scene roombeam (direct light on surfaces
 * and single scattering, one ray through each pixel's centre) and the mask of its fog-only pixels.
 *
 *     roombeam_quadrature OUTPUT            writes OUTPUT.pfm (grey, float) and OUTPUT.pbm (1: fog
 * only) roombeam_quadrature --mean SAMPLES  prints the mean over SAMPLES rays per pixel (the box
 * filter) */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "roombeam_exact.h"

static double fraction(double x) { return x - floor(x); }

/* The box filter: samples anywhere in each pixel, from a rank-1 sequence that runs on through the
 * picture (steps 1/rho and 1/rho^2, rho^3 = rho + 1), so that no edge in the picture lines up with
 * it. */
static int print_mean(long samples)
{
    double surface = 0.0, medium = 0.0, index = 0.0;
    for (int y = 0; y < ROOMBEAM_HEIGHT; ++y)
        for (int x = 0; x < ROOMBEAM_WIDTH; ++x)
            for (long k = 0; k < samples; ++k, index += 1.0) {
                const double sx = x + fraction(0.5 + index * 0.7548776662466927);
                const double sy = y + fraction(0.5 + index * 0.5698402909980532);
                const exact_pixel p =
                    exact_radiance(exact_camera_position(), exact_camera_dir(sx, sy));
                surface += p.surface;
                medium += p.medium;
            }
    printf("mean %.7f (surface %.7f, medium %.7f)\n", (surface + medium) / index, surface / index,
           medium / index);
    return 0;
}

static FILE *open_output(const char *stem, const char *extension)
{
    char path[4096];
    const int length = snprintf(path, sizeof path, "%s%s", stem, extension);
    if (length < 0 || (size_t)length >= sizeof path)
        return NULL;
    FILE *file = fopen(path, "wb");
    if (!file)
        perror(path);
    return file;
}

/* Portable float map: rows from the bottom, little-endian. */
static void write_row_pfm(FILE *file, const exact_pixel *row)
{
    for (int x = 0; x < ROOMBEAM_WIDTH; ++x) {
        const float value = (float)(row[x].surface + row[x].medium);
        unsigned bits;
        memcpy(&bits, &value, sizeof bits);
        for (int k = 0; k < 4; ++k)
            fputc((int)(bits >> (8 * k) & 255u), file);
    }
}

static void write_row_pbm(FILE *file, const exact_pixel *row)
{
    for (int x = 0; x < ROOMBEAM_WIDTH; x += 8) {
        int bits = 0;
        for (int k = 0; k < 8; ++k)
            bits |= row[x + k].fog_only << (7 - k);
        fputc(bits, file);
    }
}

static int write_files(const char *stem)
{
    static exact_pixel pixels[ROOMBEAM_HEIGHT][ROOMBEAM_WIDTH];
    FILE *image = open_output(stem, ".pfm"), *mask = open_output(stem, ".pbm");
    bool ok = image && mask;
    if (ok) {
        for (int y = 0; y < ROOMBEAM_HEIGHT; ++y)
            for (int x = 0; x < ROOMBEAM_WIDTH; ++x)
                pixels[y][x] =
                    exact_radiance(exact_camera_position(), exact_camera_dir(x + 0.5, y + 0.5));
        fprintf(image, "Pf\n%d %d\n-1.0\n", ROOMBEAM_WIDTH, ROOMBEAM_HEIGHT);
        fprintf(mask, "P4\n%d %d\n", ROOMBEAM_WIDTH, ROOMBEAM_HEIGHT);
        for (int y = 0; y < ROOMBEAM_HEIGHT; ++y) {
            write_row_pfm(image, pixels[ROOMBEAM_HEIGHT - 1 - y]);
            write_row_pbm(mask, pixels[y]);
        }
        ok = !ferror(image) && !ferror(mask);
    }
    if (image)
        ok = fclose(image) == 0 && ok;
    if (mask)
        ok = fclose(mask) == 0 && ok;
    return ok ? 0 : 1;
}

int main(int argc, char **argv)
{
    if (argc == 3 && strcmp(argv[1], "--mean") == 0 && atol(argv[2]) > 0)
        return print_mean(atol(argv[2]));
    if (argc == 2 && argv[1][0] != '-')
        return write_files(argv[1]);
    fprintf(stderr, "usage: roombeam_quadrature OUTPUT | roombeam_quadrature --mean SAMPLES\n");
    return 2;
}
