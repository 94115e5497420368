#pragma once

#include <string>
#include <string_view>

#include <earpoint/pose.h>
#include <earpoint/scene/scene.h>

namespace earpoint {

/// Reads "X,Y,Z[,yaw=DEG][,pitch=DEG][,roll=DEG]".
/// @param flag  what errors call the text
/// @throws InputError
Pose parse_pose(std::string_view flag, const std::string& text);

/// Reads "LX,LY,LZ[,absorption=A][,scattering=S]": a box with a corner at the origin.
/// @throws InputError
Scene parse_shoebox(std::string_view flag, const std::string& text);

}  // namespace earpoint
