/* probability.h: tail probabilities of the distributions that tests compare against. */
#ifndef AIR_IMAGE_PROBABILITY_H
#define AIR_IMAGE_PROBABILITY_H

/* P(|T| >= |t|) of Student's t with nu > 0 degrees of freedom (INFINITY: the normal distribution).
 */
double air_student_two_sided(double t, double nu);

/* P(X >= x) of chi-square with n > 0 degrees of freedom; x >= 0. */
double air_chi_square_upper(double x, double n);

/* The z >= 0 with P(|Z| >= z) = p of the normal distribution; p in [0,1], below 1e-300 taken as
 * 1e-300. */
double air_normal_two_sided_score(double p);

/* 1 - (1 - p)^n, the chance that the smallest of n independent p-values is at most p. */
double air_sidak(double p, double n);

#endif
