/* status.c: names of statuses, and the version. */
#include "airlight/status.h"

#include "airlight/version.h"

const char *air_status_name(air_status status)
{
    switch (status) {
    case AIR_OK:
        return "ok";
    case AIR_ERROR_ARGUMENT:
        return "argument";
    case AIR_ERROR_MEMORY:
        return "memory";
    case AIR_ERROR_IO:
        return "io";
    case AIR_ERROR_FORMAT:
        return "format";
    case AIR_ERROR_UNSUPPORTED:
        return "unsupported";
    case AIR_ERROR_INTERRUPTED:
        return "interrupted";
    case AIR_ERROR_INTERNAL:
        return "internal";
    }
    return "unknown";
}

const char *air_version(void) { return AIR_VERSION_STRING; }
