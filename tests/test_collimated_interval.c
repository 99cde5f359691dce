/* Interval lists against a membership test on a grid of points. */
#include "airlight/interval.h"

#include <stdbool.h>

#include "cmocka_test.h"
#include "core/random.h"

enum { MOST = 12, POINTS = 200, CASES = 2000 };

/* Ends at multiples of 0.1, so that touching and empty intervals occur; probes lie between. */
static size_t random_list(air_rng *rng, air_interval *out)
{
    const size_t count = air_rng_next(rng) % (MOST + 1);
    for (size_t i = 0; i < count; i++) {
        out[i].begin = 0.1 * (air_rng_next(rng) % 100u);
        out[i].end = out[i].begin + 0.1 * (air_rng_next(rng) % 20u) - 0.2;
    }
    return count;
}

static double probe(int i) { return 0.05 + 0.1 * (double)i - 5.0; }

static bool holds(const air_interval *list, size_t count, double t)
{
    for (size_t i = 0; i < count; i++) {
        if (t > list[i].begin && t < list[i].end) {
            return true;
        }
    }
    return false;
}

static void assert_sorted(const air_interval *list, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        assert_true(list[i].begin < list[i].end);
        assert_true(i == 0 || list[i - 1].end < list[i].begin);
    }
}

static void joining_keeps_membership(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(1, 2);
    air_interval list[MOST], joined[MOST];
    for (int n = 0; n < CASES; n++) {
        const size_t count = random_list(&rng, list);
        for (size_t i = 0; i < count; i++) {
            joined[i] = list[i];
        }
        const size_t left = air_intervals_join(joined, count);
        assert_sorted(joined, left);
        for (int i = 0; i < POINTS; i++) {
            assert_int_equal(holds(list, count, probe(i)), holds(joined, left, probe(i)));
        }
    }
}

static void gaps_are_the_rest(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(3, 4);
    air_interval list[MOST], gaps[MOST + 1];
    for (int n = 0; n < CASES; n++) {
        const size_t count = air_intervals_join(list, random_list(&rng, list));
        const double begin = 0.1 * (air_rng_next(&rng) % 50u), end = begin + 3.0;
        const size_t gap_count = air_intervals_gaps(list, count, begin, end, gaps);
        assert_true(gap_count <= count + 1);
        for (int i = 0; i < POINTS; i++) {
            const double t = probe(i);
            const bool expected = t > begin && t < end && !holds(list, count, t);
            assert_int_equal(expected, holds(gaps, gap_count, t));
        }
    }
}

static void intersections_hold_what_both_hold(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(5, 6);
    air_interval a[MOST], b[MOST], both[2 * MOST];
    for (int n = 0; n < CASES; n++) {
        const size_t a_count = air_intervals_join(a, random_list(&rng, a));
        const size_t b_count = air_intervals_join(b, random_list(&rng, b));
        const size_t count = air_intervals_intersect(a, a_count, b, b_count, both);
        assert_true(count == 0 || count <= a_count + b_count - 1);
        for (int i = 0; i < POINTS; i++) {
            const double t = probe(i);
            assert_int_equal(holds(a, a_count, t) && holds(b, b_count, t), holds(both, count, t));
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(joining_keeps_membership),
        cmocka_unit_test(gaps_are_the_rest),
        cmocka_unit_test(intersections_hold_what_both_hold),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
