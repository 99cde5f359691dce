/* airlight.h: everything, included. */
#ifndef AIRLIGHT_H
#define AIRLIGHT_H

#include "airlight/context.h"
#include "airlight/image.h"
#include "airlight/light.h"
#include "airlight/medium.h"
#include "airlight/render.h"
#include "airlight/scene.h"
#include "airlight/status.h"
#include "airlight/version.h"

#endif
