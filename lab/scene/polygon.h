#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <earpoint/vector3.h>

namespace earpoint {

/// Cuts a polygon into triangles by clipping ears; it need not be convex, but should be flat.
///
/// @param corners  in order around it; fewer than 3 give nothing
/// @return indices into `corners`, turning as the polygon does; corners.size() - 2 of them, of
///         which some have no area where corners lie on one line
std::vector<std::array<std::uint32_t, 3>> triangulate(const std::vector<Vector3>& corners);

}  // namespace earpoint
