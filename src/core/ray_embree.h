/* ray_embree.h: the default ray backend. */
#ifndef AIR_CORE_RAY_EMBREE_H
#define AIR_CORE_RAY_EMBREE_H

#include "airlight/context.h"

air_ray_backend air_ray_embree(void);

#endif
