#pragma once

#include "ray_walk.h"

#include <span>
#include <vector>

#include <earpoint/core/parallel.h>

namespace earpoint {

/// Walks the rays of all sources, after two surveys by a few rays without listeners that find how
/// fast the energy of each source falls.
/// @param setup  its `rays` leave every source, those of the survey apart
/// @return  [source]; the same for any number of threads. The first one's `rays_cast` holds the
///          surveys'.
std::vector<WalkTally> walk_sources(const WalkSetup& setup, std::span<const Source> sources,
                                    ThreadPool& pool);

}  // namespace earpoint
