/* exponential_integral.h: the second exponential integral. */
#ifndef AIR_AREALIGHT_EXPONENTIAL_INTEGRAL_H
#define AIR_AREALIGHT_EXPONENTIAL_INTEGRAL_H

/* The integral of exp(-x t)/t^2 over t from 1 to infinity, x >= 0 (INFINITY too): 1 at 0. Relative
 * error below 2e-15 while the result is a normal number (tests/test_arealight_transmitted.c). */
double air_exponential_integral_2(double x);

#endif
