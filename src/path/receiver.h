/* receiver.h: from which directions a receiver takes light, and how they are drawn. */
#ifndef AIR_PATH_RECEIVER_H
#define AIR_PATH_RECEIVER_H

#include "path/path.h"

/* The density per solid angle with which a receiver draws directions; 0 where it gets no light. */
float air_receiver_sample_pdf(const air_path_receiver *receiver, air_vec3 dir);
/* Draws one from two numbers and, for receivers that draw evenly in part, a third; false if it
 * brings no light. */
bool air_receiver_sample(const air_path_receiver *receiver, air_f32x4 u, air_vec3 *out_dir,
                         float *out_pdf);

#endif
