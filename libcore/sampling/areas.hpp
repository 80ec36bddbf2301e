// SPDX-License-Identifier: Apache-2.0
// Areas of simple shapes within boxes, to double precision.
#pragma once

namespace triad {

// The share of the box [0, width] x [0, height] in which normal_x * x + normal_y * y < offset, for a normal of any
// length: the box clipped to the half-plane (Sutherland and Hodgman, CACM 17(1), 1974).
double half_plane_share(double width, double height, double normal_x, double normal_y, double offset);

// The area of the unit disc about the origin within [x0, x1] x [y0, y1]: by the area of the disc below and left of a
// corner, at the box's four corners.
double unit_disc_area(double x0, double y0, double x1, double y1);

}  // namespace triad
