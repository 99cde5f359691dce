/* spectrum_observer.h: the CIE 1931 2-degree observer and the illuminant D65. */
#ifndef AIR_SCENE_IMPORT_SPECTRUM_OBSERVER_H
#define AIR_SCENE_IMPORT_SPECTRUM_OBSERVER_H

enum { AIR_OBSERVER_FIRST_NM = 360, AIR_OBSERVER_STEP_NM = 5, AIR_OBSERVER_COUNT = 95 };

/* x, y and z of the observer, then the power of D65, 100 at 560 nm [CIE2018]. */
extern const double air_observer[AIR_OBSERVER_COUNT][4];

#endif
