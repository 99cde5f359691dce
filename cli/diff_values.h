/* diff_values.h: the numbers that `airlight diff` prints, their names, and limits on them. */
#ifndef AIR_CLI_DIFF_VALUES_H
#define AIR_CLI_DIFF_VALUES_H

#include <airlight/temporal.h>

#include "host.h"

/* Values come in groups, all of one or none. */
typedef enum cli_diff_group {
    CLI_DIFF_METRIC,
    CLI_DIFF_ZTEST,
    CLI_DIFF_TEMPORAL,
    CLI_DIFF_GROUPS
} cli_diff_group;

enum { CLI_DIFF_VALUES_MAX = 32 };

typedef struct cli_diff_values {
    double value[CLI_DIFF_VALUES_MAX];
    bool present[CLI_DIFF_GROUPS];
} cli_diff_values;

void cli_diff_keep_metrics(const air_metrics *metrics, cli_diff_values *out);
void cli_diff_keep_ztest(const air_ztest *test, cli_diff_values *out);
void cli_diff_keep_temporal(const air_temporal_metrics *metrics, cli_diff_values *out);

/* The values that are present, on stdout: a line each with what they mean, or an object. */
void cli_diff_print(const cli_diff_values *values, bool json);

/* Can these limits, METRIC=NUMBER each, be read? Says which cannot. */
bool cli_diff_limits_readable(const cli_list *above, const cli_list *below);
/* Exit code 1, and says so, where a value breaks one. */
cli_exit cli_diff_check_limits(cli_host *host, const cli_list *above, const cli_list *below,
                               const cli_diff_values *values);

#endif
