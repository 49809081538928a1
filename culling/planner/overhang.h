// Is a scene 2.5D, as streets of houses are: one surface over each place of the ground? Estimated
// from sampled triangles; methods that are made for such scenes ask it.
#pragma once
#include "culling/scene/scene_snapshot.h"

namespace culld {

/// Of the blocking surfaces, each as large as its shadow at noon, the share that faces down well
/// above the ground: some percent for eaves and bridges, nearly a half for caves and storeys.
/// y is up, as in glTF. 0 for a scene without such surfaces. Deterministic.
/// COST: at most some milliseconds: about 32 triangles of each of at most 4096 objects.
double overhangOf(const SceneSnapshot& scene);

}  // namespace culld
