/* version.h: the version of the headers, and of the library that was linked. */
#ifndef AIRLIGHT_VERSION_H
#define AIRLIGHT_VERSION_H

#include "airlight/status.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { AIR_VERSION_MAJOR = 0, AIR_VERSION_MINOR = 1, AIR_VERSION_PATCH = 0 };

/* "MAJOR.MINOR.PATCH" of the linked library. Static storage; thread-safe. */
AIR_API const char *air_version(void);

#ifdef __cplusplus
}
#endif
#endif
