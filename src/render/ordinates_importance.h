/* ordinates_importance.h: which directions of the sky a camera sees by scattering in the media. */
#ifndef AIR_RENDER_ORDINATES_IMPORTANCE_H
#define AIR_RENDER_ORDINATES_IMPORTANCE_H

#include "render/ordinates_domain.h"
#include "scene/camera.h"

/* AIR_IMPORTANCE_TEXELS, whose header does not go with that of with_ordinates.c. */
enum { ORD_IMPORTANCE_TEXELS = 512 };

/* A map for air_environment_choice.importance: ORD_IMPORTANCE_TEXELS to out. previous: that of the
 * picture before, of which most is kept, so that directions move slowly; or NULL. out may be
 * previous. *out_made is false, and out untouched, for a view without perspective or one that sees
 * nothing of the domain. */
air_status ord_importance_make(const ord_domain *domain, const air_camera_view *view, size_t width,
                               size_t height, const float *previous, float *out, bool *out_made);

#endif
