/* interrupt.h: SIGINT and SIGTERM as a wish to stop. */
#ifndef AIR_CLI_INTERRUPT_H
#define AIR_CLI_INTERRUPT_H

#include <stdbool.h>

/* From now on the first SIGINT or SIGTERM only sets a flag; a second one of the same kind kills the
 * process. */
void cli_interrupt_install(void);
bool cli_interrupt_pending(void);

#endif
