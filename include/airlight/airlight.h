/* airlight.h: everything, included. */
#ifndef AIRLIGHT_H
#define AIRLIGHT_H

#include "airlight/area_ltc.h"
#include "airlight/area_table.h"
#include "airlight/arealight.h"
#include "airlight/arealight_eval.h"
#include "airlight/bake.h"
#include "airlight/collimated.h"
#include "airlight/collimated_walk.h"
#include "airlight/context.h"
#include "airlight/denoise.h"
#include "airlight/image.h"
#include "airlight/impulse.h"
#include "airlight/impulse_quadrature.h"
#include "airlight/interval.h"
#include "airlight/light.h"
#include "airlight/lightmap.h"
#include "airlight/medium.h"
#include "airlight/moment.h"
#include "airlight/ordinates.h"
#include "airlight/ordinates_beam.h"
#include "airlight/ordinates_dom.h"
#include "airlight/ordinates_view.h"
#include "airlight/phase_fit.h"
#include "airlight/point.h"
#include "airlight/render.h"
#include "airlight/scene.h"
#include "airlight/shadow.h"
#include "airlight/status.h"
#include "airlight/version.h"

#endif
