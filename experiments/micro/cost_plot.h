#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

namespace earpoint {

/// Draws the growth of the cost that trace_bench has measured: core-seconds per pair over
/// triangles, rays and pairs, both axes logarithmic.
/// @param report  with over_triangles, over_rays and over_pairs
void draw_costs(const nlohmann::json& report, const std::string& path);

}  // namespace earpoint
