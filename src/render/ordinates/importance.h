/* importance.h: which directions of the sky a camera sees by scattering in the media. */
#ifndef AIR_RENDER_ORDINATES_IMPORTANCE_H
#define AIR_RENDER_ORDINATES_IMPORTANCE_H

#include "render/ordinates/past.h"
#include "scene/camera.h"

/* A map for air_environment_choice.importance: ORD_IMPORTANCE_TEXELS to out, mixed with that of the
 * picture before where past (or NULL) has one. *out_made is false, and out untouched, for a view
 * without perspective or one that sees nothing of the domain. */
air_status ord_importance_make(const ord_domain *domain, const air_camera_view *view, size_t width,
                               size_t height, ord_past *past, float *out, bool *out_made);

#endif
