#pragma once

#include <array>
#include <string_view>
#include <vector>

#include <earpoint/core/random.h>
#include <earpoint/generate/floor_map.h>
#include <earpoint/pose.h>
#include <earpoint/scene/people.h>
#include <earpoint/scene/ray_caster.h>

namespace earpoint {

/// A person who is to stand in a scene.
struct PlannedPerson {
  const FigureModel* figure = nullptr;  ///< owned by the library it was drawn from
  FloorPoint at;
  double yaw_rad = 0.0;

  /// @return where the mouth is, the floor being at height 0, and where it speaks to
  [[nodiscard]] Pose world_from_mouth() const;
};

/// Two people who talk, and the places from which they are seen and heard.
struct ConversationPlan {
  std::array<PlannedPerson, 2> people;  ///< one of either gender
  std::vector<Pose> viewpoints;         ///< world_from_listener; level
};

/// What conversations look like.
struct ConversationOptions {
  int viewpoints = 4;              ///< > 1
  double height_m = 1.5;           ///< of the viewpoints
  double least_distance_m = 0.8;   ///< between the people
  double most_distance_m = 3.0;    ///< between the people
  double viewpoint_reach_m = 2.5;  ///< of a viewpoint from the middle between the people
  double sitting_share = 0.35;     ///< of the people
  /// The share of conversations with one viewpoint from which a wall or furniture hides a speaker.
  double hidden_share = 0.4;
  /// The share of the viewpoints, the first one aside, that stand in other rooms where the scene
  /// has such places: neither speaker is seen from there.
  double other_room_share = 0.0;
  double other_room_reach_m = 5.0;  ///< of those from the middle between the people
  double height_spread_m = 0.0;     ///< viewpoints are up to that higher or lower than height_m
};

/// Draws a conversation: two people at free places who see each other, turned more or less to each
/// other, and viewpoints near them that look at the middle between their heads. Nobody stands in
/// furniture, a wall or another person, and no viewpoint is further on foot than 1.8 times its
/// reach: not behind a closed door. Those in other rooms may be, and look anywhere.
/// @param floor   of the scene without people; its floor lies at height 0
/// @param caster  of the same scene
/// @param figures people of the age of the voices
/// @throws InputError if the scene has no room for it
ConversationPlan plan_conversation(const FloorMap& floor, const RayCaster& caster,
                                   const FigureLibrary& figures, FigureSplit split,
                                   const ConversationOptions& options, std::string_view scene,
                                   RandomStream& random);

/// @return whether nothing of the scene lies between two points
bool sees(const RayCaster& caster, const Vector3& from, const Vector3& to);

}  // namespace earpoint
