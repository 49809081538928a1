// What the files of this folder give to the table in families.cpp.
#pragma once
#include "tests/cases/case_builder.h"

namespace culld::cases {

// camera_cases.cpp
Sight fieldOfView(CaseBuilder& builder, double yfov_deg);
Sight imageSide(CaseBuilder& builder, double side_px);
Sight imageWidth(CaseBuilder& builder, double width_px);
Sight farOverNear(CaseBuilder& builder, double ratio);
Sight farOverNearMatrices(CaseBuilder& builder, double ratio);
Sight offCentre(CaseBuilder& builder, double shift_half_images);
Sight obliqueNear(CaseBuilder& builder, double tilt);
Sight orthographicDepth(CaseBuilder& builder, double range_over_distance);
Sight mirroredView(CaseBuilder& builder, double x_scale);
void badCameras(CaseBuilder& builder, double number);

// transform_cases.cpp
Sight planet(CaseBuilder& builder, double offset_m);
Sight distance(CaseBuilder& builder, double distance_m);
Sight thingScale(CaseBuilder& builder, double ratio);
Sight coordinateScale(CaseBuilder& builder, double scale);
Sight uniformScale(CaseBuilder& builder, double scale);
Sight flattened(CaseBuilder& builder, double scale);
Sight sheared(CaseBuilder& builder, double factor);
void deepHierarchy(CaseBuilder& builder, double depth);
void manyInstances(CaseBuilder& builder, double count);
void emptyScene(CaseBuilder& builder, double kind);

// shape_cases.cpp
Sight slivers(CaseBuilder& builder, double aspect);
Sight tJunction(CaseBuilder& builder, double offset);
Sight largeTriangle(CaseBuilder& builder, double size);
Sight degenerate(CaseBuilder& builder, double count);
void pinhole(CaseBuilder& builder, double side_px);
void needleHole(CaseBuilder& builder, double width_px);
void notANumber(CaseBuilder& builder, double share);
void infinite(CaseBuilder& builder, double share);
void nestedBoxes(CaseBuilder& builder, double apart);
void coplanar(CaseBuilder& builder, double apart);
void trianglesInAPixel(CaseBuilder& builder, double count);

// eye_cases.cpp
void eyeAtSurface(CaseBuilder& builder, double distance);
void eyeAtEdge(CaseBuilder& builder, double distance);
void eyeAtVertex(CaseBuilder& builder, double distance);
void eyeInside(CaseBuilder& builder, double distance);
void boxThroughNear(CaseBuilder& builder, double share_before);
void wallThroughNear(CaseBuilder& builder, double angle_deg);

}  // namespace culld::cases
