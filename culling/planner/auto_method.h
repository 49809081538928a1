// "--method auto": picks a method for a scene from what the methods say about themselves.
#pragma once
#include <span>
#include <string>

#include "culling/culler.h"

namespace culld {

struct MethodChoice {
  const Method* method = nullptr;
  std::string why;  ///< one line
};

/// Never worse than a superset: only methods of class `conservative` are considered.
/// ERROR: kUnsupported: no conservative method of `methods` accepts the scene.
Result<MethodChoice> chooseMethod(const SceneProfile& profile,
                                  std::span<const Method* const> methods);

}  // namespace culld
