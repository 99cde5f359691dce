/* Re-derives the tables of ggx_albedo_table.c by quadrature. With --print: writes that file to
 * stdout. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cmocka_test.h"
#include "core/quadrature.h"
#include "core/random.h"
#include "core/vec.h"
#include "scene/ggx_albedo_table.h"

typedef struct albedo {
    double loss, fresnel;
} albedo;

enum { POINTS = 96 };

/* Of albedo_by_quadrature, seen when POINTS is doubled. */
static const double QUADRATURE_ERROR = 1e-6;

/* Gauss-Legendre on [-1, 1]. */
typedef struct quadrature {
    double nodes[POINTS], weights[POINTS];
} quadrature;

/* G2 / G1 of Smith's height-correlated shadowing [Heitz2014, eq. 99] and 1 minus it, without
 * cancellation. */
typedef struct shadowing {
    double passed, lost;
} shadowing;

static shadowing shadowing_at(double mu, double nu, double alpha)
{
    const double at_mu = sqrt(mu * mu + alpha * alpha * (1.0 - mu * mu));
    const double at_nu = sqrt(nu * nu + alpha * alpha * (1.0 - nu * nu));
    const double sum = mu * at_nu + nu * at_mu;
    return (shadowing){nu * (mu + at_mu) / sum,
                       mu * alpha * alpha * (1.0 - nu * nu) / ((at_nu + nu) * sum)};
}

/* The part of the distribution of visible normals that reflects below the horizon, at one azimuth:
 * the integral of q (rho sinh + 1) / (1 + q^2)^2 over q = rho / alpha beyond q_edge, up to where
 * normals turn invisible. */
static double beyond_edge(double sinh_tau, double alpha, double q_edge)
{
    const double q_end = sinh_tau < 0.0 ? -1.0 / (alpha * sinh_tau) : INFINITY;
    const double tail = isinf(q_end) ? 0.0 : 1.0 / (1.0 + q_end * q_end);
    const double tail_moment = isinf(q_end) ? 0.5 * AIR_PI : atan(q_end) - q_end * tail;
    const double edge = 1.0 / (1.0 + q_edge * q_edge);
    return 0.5 * (edge - tail) +
           0.5 * alpha * sinh_tau * (tail_moment - (atan(q_edge) - q_edge * edge));
}

/* Over what reflects above the horizon, in log q. */
static albedo within_edge(const quadrature *rule, double mu, double alpha, double sinh_tau,
                          double rho_edge)
{
    const double low = log(1e-6), high = log(rho_edge / alpha);
    albedo sum = {0.0, 0.0};
    for (int i = 0; i < POINTS; i++) {
        const double q = exp(low + 0.5 * (high - low) * (1.0 + rule->nodes[i]));
        const double rho = alpha * q, across = rho * sinh_tau + 1.0;
        const double cos_incident = mu * across / sqrt(1.0 + rho * rho);
        const double nu = mu * (2.0 * across / (1.0 + rho * rho) - 1.0);
        const shadowing g = shadowing_at(mu, fmin(1.0, fmax(0.0, nu)), alpha);
        const double density = q * across / ((1.0 + q * q) * (1.0 + q * q));
        const double weight = 0.5 * (high - low) * rule->weights[i] * q * density;
        sum.loss += weight * g.lost;
        sum.fresnel += weight * g.passed * pow(1.0 - fmin(1.0, cos_incident), 5.0);
    }
    return sum;
}

/* The directional albedo: the mean of F G2/G1 over the normals visible from mu. In the plane of
 * slopes (rho, psi) those that reflect above the horizon fill a disk of radius 1/mu around (sin/mu,
 * 0), which holds the origin; with sin cos(psi) = mu sinh(tau) its edge is rho = exp(tau). tau = T
 * sin(turn) removes the root at both ends. */
static albedo albedo_by_quadrature(const quadrature *rule, double mu_exact, double alpha)
{
    const double mu = fmin(fmax(mu_exact, 1e-9), 1.0 - 1e-9);
    const double sine = sqrt(1.0 - mu * mu);
    const double tau_max = asinh(sine / mu);
    const double g1 = 2.0 * mu / (mu + sqrt(mu * mu + alpha * alpha * sine * sine));
    albedo sum = {0.0, 0.0};
    for (int i = 0; i < POINTS; i++) {
        const double turn = 0.5 * AIR_PI * rule->nodes[i];
        const double tau = tau_max * sin(turn), sinh_tau = sinh(tau);
        const double sin_psi = sqrt(fmax(0.0, 1.0 - mu * mu * sinh_tau * sinh_tau / (sine * sine)));
        const double psi_rate = tau_max * cos(turn) * mu * cosh(tau) / (sine * sin_psi);
        /* 2: both halves of the azimuths */
        const double weight = g1 / AIR_PI * 2.0 * 0.5 * AIR_PI * rule->weights[i] * psi_rate;
        const albedo within = within_edge(rule, mu, alpha, sinh_tau, exp(tau));
        sum.loss += weight * (within.loss + beyond_edge(sinh_tau, alpha, exp(tau) / alpha));
        sum.fresnel += weight * within.fresnel;
    }
    return sum;
}

/* ---- the axes, inverted ---- */

static double alpha_of_axis(double x)
{
    const double start = sqrt((double)air_ggx_alpha_min());
    const double roughness = start + x * (1.0 - start);
    return fmin(1.0, roughness * roughness);
}

static double mu_axis(double mu, double alpha)
{
    return 0.5 * mu * ((1.0 + alpha) / (mu + alpha) + 1.25 / (mu + 0.25));
}

static double mu_of_axis(double x, double alpha)
{
    double low = 0.0, high = 1.0;
    for (int i = 0; i < 100; i++) {
        const double middle = 0.5 * (low + high);
        if (mu_axis(middle, alpha) < x) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return x >= 1.0 ? 1.0 : low;
}

/* ---- making the tables (--print) ---- */

typedef struct tables {
    albedo nodes[AIR_GGX_ALPHA_COUNT][AIR_GGX_MU_COUNT];
    albedo factors[AIR_GGX_ALPHA_COUNT][AIR_GGX_MU_COUNT];
    albedo means[AIR_GGX_MEAN_COUNT];
} tables;

static albedo mix(albedo a, albedo b, double share)
{
    return (albedo){a.loss + share * (b.loss - a.loss),
                    a.fresnel + share * (b.fresnel - a.fresnel)};
}

static albedo table_at(const tables *t, double mu, double alpha, double alpha_axis)
{
    const double y = alpha_axis * (AIR_GGX_ALPHA_COUNT - 1);
    const double x = mu_axis(mu, alpha) * (AIR_GGX_MU_COUNT - 1);
    const int row = (int)fmin(y, AIR_GGX_ALPHA_COUNT - 2),
              column = (int)fmin(x, AIR_GGX_MU_COUNT - 2);
    const albedo *low = t->nodes[row] + column, *high = t->nodes[row + 1] + column;
    return mix(mix(low[0], low[1], x - column), mix(high[0], high[1], x - column), y - row);
}

/* How far the four nodes around a cell must move so that the table errs on the dark side everywhere
 * in it. */
static void widen_cell(const quadrature *rule, tables *t, int row, int column)
{
    enum { SUBDIVISION = 6 };
    albedo widest = {1.0, 1.0};
    for (int i = 0; i < (SUBDIVISION + 1) * (SUBDIVISION + 1); i++) {
        const double y =
            (row + (double)(i / (SUBDIVISION + 1)) / SUBDIVISION) / (AIR_GGX_ALPHA_COUNT - 1);
        const double x =
            (column + (double)(i % (SUBDIVISION + 1)) / SUBDIVISION) / (AIR_GGX_MU_COUNT - 1);
        const double alpha = alpha_of_axis(y), mu = mu_of_axis(x, alpha);
        const albedo truth = albedo_by_quadrature(rule, mu, alpha);
        const albedo table = table_at(t, mu, alpha, y);
        if (mu > 0.0) { /* where both losses are 0 */
            widest.loss = fmin(widest.loss, truth.loss / table.loss);
        }
        widest.fresnel = fmax(widest.fresnel, truth.fresnel / table.fresnel);
    }
    const double slack = 2e-4; /* for the places between those that are looked at */
    for (int i = 0; i < 4; i++) {
        albedo *factor = &t->factors[row + i / 2][column + i % 2];
        factor->loss = fmin(factor->loss, widest.loss * (1.0 - slack));
        factor->fresnel = fmax(factor->fresnel, widest.fresnel * (1.0 + slack));
    }
}

static void make_directional(const quadrature *rule, tables *t)
{
    for (int row = 0; row < AIR_GGX_ALPHA_COUNT; row++) {
        const double alpha = alpha_of_axis((double)row / (AIR_GGX_ALPHA_COUNT - 1));
        for (int column = 0; column < AIR_GGX_MU_COUNT; column++) {
            const double mu = mu_of_axis((double)column / (AIR_GGX_MU_COUNT - 1), alpha);
            t->nodes[row][column] = albedo_by_quadrature(rule, mu, alpha);
            t->factors[row][column] = (albedo){1.0, 1.0};
        }
    }
    for (int row = 0; row < AIR_GGX_ALPHA_COUNT - 1; row++) {
        for (int column = 0; column < AIR_GGX_MU_COUNT - 1; column++) {
            widen_cell(rule, t, row, column);
        }
    }
    for (int row = 0; row < AIR_GGX_ALPHA_COUNT; row++) {
        for (int column = 0; column < AIR_GGX_MU_COUNT; column++) {
            albedo *node = &t->nodes[row][column];
            const albedo factor = t->factors[row][column];
            node->loss = fmax(0.0, node->loss * factor.loss - QUADRATURE_ERROR);
            node->fresnel = node->fresnel * factor.fresnel + QUADRATURE_ERROR;
        }
    }
}

/* 2 integral table(mu) mu dmu, with mu = y^2. */
static albedo mean_of_table(const tables *t, double alpha, double alpha_axis)
{
    enum { STEPS = 8192 };
    albedo sum = {0.0, 0.0};
    for (int i = 0; i < STEPS; i++) {
        const double y = (i + 0.5) / STEPS;
        const double weight = 4.0 * y * y * y / STEPS;
        const albedo value = table_at(t, y * y, alpha, alpha_axis);
        sum.loss += weight * value.loss;
        sum.fresnel += weight * value.fresnel;
    }
    return sum;
}

/* The means are divided by: they err towards more loss and less Fresnel, between nodes too. */
static void make_means(tables *t)
{
    enum { CELLS = AIR_GGX_MEAN_COUNT - 1 };
    albedo factors[AIR_GGX_MEAN_COUNT];
    for (int i = 0; i <= CELLS; i++) {
        const double axis = (double)i / CELLS;
        t->means[i] = mean_of_table(t, alpha_of_axis(axis), axis);
        factors[i] = (albedo){1.0 + 1e-5, 1.0 - 1e-5};
    }
    for (int i = 0; i < CELLS; i++) {
        const double axis = (i + 0.5) / CELLS;
        const albedo exact = mean_of_table(t, alpha_of_axis(axis), axis);
        const albedo between = mix(t->means[i], t->means[i + 1], 0.5);
        for (int k = i; k <= i + 1; k++) {
            factors[k].loss = fmax(factors[k].loss, exact.loss / between.loss * (1.0 + 1e-5));
            factors[k].fresnel =
                fmin(factors[k].fresnel, exact.fresnel / between.fresnel * (1.0 - 1e-5));
        }
    }
    for (int i = 0; i <= CELLS; i++) {
        t->means[i].loss *= factors[i].loss;
        t->means[i].fresnel *= factors[i].fresnel;
    }
}

static void print_node(albedo node) { printf("{%.6ef, %.6ef}", node.loss, node.fresnel); }

static void print_row(const albedo *row, int count, const char *indent)
{
    for (int i = 0; i < count; i++) {
        printf(i % 3 == 0 ? "%s" : " ", indent);
        print_node(row[i]);
        printf(i % 3 == 2 || i == count - 1 ? ",\n" : ",");
    }
}

static void print_tables(const tables *t)
{
    printf(
        "/* ggx_albedo_table.c: made by `test_ggx_albedo_table --print`. */\n"
        "#include \"scene/ggx_albedo_table.h\"\n\n"
        "/* clang-format off */\n"
        "const air_ggx_albedo air_ggx_albedo_table[AIR_GGX_ALPHA_COUNT][AIR_GGX_MU_COUNT] = {\n");
    for (int row = 0; row < AIR_GGX_ALPHA_COUNT; row++) {
        printf("    {\n");
        print_row(t->nodes[row], AIR_GGX_MU_COUNT, "        ");
        printf("    },\n");
    }
    printf("};\n\nconst air_ggx_albedo air_ggx_albedo_mean_table[AIR_GGX_MEAN_COUNT] = {\n");
    print_row(t->means, AIR_GGX_MEAN_COUNT, "    ");
    printf("};\n");
}

/* ---- tests ---- */

static void quadrature_meets_the_closed_form_at_normal_incidence(void **state)
{
    /* For alpha = 1 and mu = 1 the distribution of normals is uniform and the albedo is 1 - ln 2.
     */
    const albedo value = albedo_by_quadrature(*state, 1.0, 1.0);
    assert_true(fabs(value.loss - log(2.0)) < 1e-8);
}

static void table_errs_on_the_dark_side_by_little(void **state)
{
    air_rng rng = air_rng_from_keys(1, 2);
    double worst_loss = 0.0, worst_fresnel = 0.0;
    for (int i = 0; i < 4000; i++) {
        const float axis = air_rng_float(&rng);
        const double alpha = alpha_of_axis((double)axis);
        const double mu = mu_of_axis((double)air_rng_float(&rng), alpha);
        const albedo truth = albedo_by_quadrature(*state, mu, alpha);
        const air_ggx_albedo table = air_ggx_albedo_at((float)mu, (float)alpha, axis);
        /* 2e-6: float rounding of the axes times the slope of the table, which is below 10 per unit
         * of axis. */
        assert_true((double)table.loss <= truth.loss + 2e-6);
        assert_true((double)table.fresnel >= truth.fresnel - 2e-6);
        worst_loss = fmax(worst_loss, truth.loss - (double)table.loss);
        worst_fresnel = fmax(worst_fresnel, (double)table.fresnel - truth.fresnel);
    }
    printf("directional albedo: loss at most %.2e too small, fresnel at most %.2e too large\n",
           worst_loss, worst_fresnel);
    /* Linear interpolation is off by h^2/8 times the second derivative; the shift that makes it
     * one-sided doubles that at most. In mu the loss has about 10 (a dip of 0.11 within a quarter
     * of the axis), (1-mu)^5 about 40, with h = 1/63; in roughness both have about 5, with h =
     * 1/31. */
    assert_true(worst_loss < 2.0 * (10.0 / 63 / 63 + 5.0 / 31 / 31) / 8.0);
    assert_true(worst_fresnel < 2.0 * (40.0 / 63 / 63 + 5.0 / 31 / 31) / 8.0);
}

static void means_are_those_of_the_table(void **state)
{
    (void)state;
    for (int i = 0; i < 300; i++) {
        const float axis = ((float)i + 0.5f) / 300.0f;
        const float alpha = (float)alpha_of_axis((double)axis);
        double loss = 0.0, fresnel = 0.0;
        enum { STEPS = 4096 };
        for (int k = 0; k < STEPS; k++) {
            const double y = (k + 0.5) / STEPS;
            const air_ggx_albedo value = air_ggx_albedo_at((float)(y * y), alpha, axis);
            loss += 4.0 * y * y * y / STEPS * (double)value.loss;
            fresnel += 4.0 * y * y * y / STEPS * (double)value.fresnel;
        }
        const air_ggx_albedo mean = air_ggx_albedo_mean(axis);
        assert_true((double)mean.loss >= loss * (1.0 - 1e-6));
        assert_true((double)mean.fresnel <= fresnel * (1.0 + 1e-6));
        /* Between nodes the mean loss grows like roughness^4: at the smallest roughness r = 0.032
         * with h = 1/263 linear interpolation is off by 12 r^2 h^2 / 8 / r^4 = 2 %, shifted to one
         * side. */
        assert_true((double)mean.loss <= loss * 1.03 && (double)mean.fresnel >= fresnel * 0.998);
    }
}

int main(int argc, char **argv)
{
    quadrature rule;
    air_gauss_legendre(POINTS, rule.nodes, rule.weights);
    if (argc > 1 && strcmp(argv[1], "--print") == 0) {
        tables *t = malloc(sizeof *t);
        if (t == NULL) {
            return 1;
        }
        make_directional(&rule, t);
        make_means(t);
        print_tables(t);
        free(t);
        return 0;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_prestate(quadrature_meets_the_closed_form_at_normal_incidence, &rule),
        cmocka_unit_test_prestate(table_errs_on_the_dark_side_by_little, &rule),
        cmocka_unit_test_prestate(means_are_those_of_the_table, &rule),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
