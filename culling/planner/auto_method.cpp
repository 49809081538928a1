#include "culling/planner/auto_method.h"

namespace culld {
namespace {

// Below this a frustum test of everything takes microseconds, and drawing occluders cannot pay.
constexpr std::uint64_t kFewObjects = 256;

/// What a method must be able to use, cheapest first: boxes only, then the scene's triangles.
constexpr std::string_view kBoxes = "boxes";
constexpr std::string_view kTriangles = "triangles";

struct Search {
  const Method* found = nullptr;
  std::string refusals;  ///< "; NAME: why not" of each that was asked and declined
};

Search firstThatAccepts(const SceneProfile& profile, std::span<const Method* const> methods,
                        std::string_view needs) {
  Search search;
  for (const Method* method : methods) {
    const MethodInfo info = method->info();
    if (info.guarantee != Guarantee::kConservative || info.needs != needs) continue;
    if (auto accepted = method->accepts(profile); accepted) {
      search.found = method;
      return search;
    } else {
      search.refusals += "; " + std::string(info.name) + ": " + accepted.error().message;
    }
  }
  return search;
}

MethodChoice chosen(const Method& method, const std::string& why) {
  return {&method, std::string(method.info().name) + ": " + why};
}

}  // namespace

Result<MethodChoice> chooseMethod(const SceneProfile& profile,
                                  std::span<const Method* const> methods) {
  const std::string objects = std::to_string(profile.objects) + " objects";
  const std::string blocking = std::to_string(profile.blocking_triangles) + " blocking triangles";
  std::string why_not;
  if (profile.objects < kFewObjects) {
    why_not = objects + ", fewer than " + std::to_string(kFewObjects) + ": occluders cannot pay";
  } else if (profile.blocking_triangles == 0) {
    why_not = "no blocking triangles: nothing can hide anything";
  } else {
    const Search search = firstThatAccepts(profile, methods, kTriangles);
    if (search.found != nullptr) return chosen(*search.found, objects + " and " + blocking);
    why_not = objects + " and " + blocking + ", but no method that uses them" + search.refusals;
  }
  const Search search = firstThatAccepts(profile, methods, kBoxes);
  if (search.found != nullptr) return chosen(*search.found, why_not);
  return Error{ErrorCode::kUnsupported,
               "no conservative method is for this scene (" + why_not + ")" + search.refusals};
}

}  // namespace culld
