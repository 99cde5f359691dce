/* Instruction sets. */
#include "core/cpu.h"

#include <stdio.h>
#include <string.h>

#include "cmocka_test.h"

/* Whether the kernel lists a feature for the first processor; -1 where there is no such list. */
static int kernel_lists(const char *feature)
{
    FILE *file = fopen("/proc/cpuinfo", "r");
    char line[8192], word[64];
    int found = -1;
    (void)snprintf(word, sizeof word, " %s ", feature);
    while (file != NULL && found < 0 && fgets(line, sizeof line, file) != NULL) {
        if (strncmp(line, "flags", 5) == 0) {
            line[strcspn(line, "\n")] = ' ';
            found = strstr(line, word) != NULL;
        }
    }
    if (file != NULL) {
        (void)fclose(file);
    }
    return found;
}

static void the_level_agrees_with_what_the_kernel_lists(void **state)
{
    (void)state;
    const air_cpu cpu = air_cpu_detect();
    assert_in_range(cpu, AIR_CPU_C, AIR_CPU_AVX512);
    if (kernel_lists("sse4_2") < 0) {
        print_message("no list of processor features here\n");
        skip();
    }
    assert_int_equal(cpu >= AIR_CPU_SSE42, kernel_lists("sse4_2"));
    assert_int_equal(cpu >= AIR_CPU_AVX2,
                     kernel_lists("avx2") && kernel_lists("fma") && kernel_lists("bmi2"));
    assert_int_equal(cpu >= AIR_CPU_AVX512,
                     kernel_lists("avx2") && kernel_lists("avx512vl") && kernel_lists("avx512dq"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_level_agrees_with_what_the_kernel_lists),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
