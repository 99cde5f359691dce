#include "interrupt.h"

#include <signal.h>
#include <stddef.h>

/* The one mutable global of the program: a signal handler can reach nothing else. */
static volatile sig_atomic_t interrupt_pending;

static void on_signal(int signal_number)
{
    (void)signal_number;
    interrupt_pending = 1;
}

void cli_interrupt_install(void)
{
    /* SA_RESETHAND gives the second signal its default action. */
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = (int)SA_RESETHAND | SA_RESTART};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
}

bool cli_interrupt_pending(void) { return interrupt_pending != 0; }
