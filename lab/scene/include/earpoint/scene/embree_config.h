#pragma once

namespace earpoint {

/// How Embree's devices are set up here, so that the same seed gives the same bytes: a tree is
/// built by one thread, since one built by several may differ from run to run; and rays are traced
/// with AVX2 even where there is more, since with other instructions a ray through an edge may meet
/// the other one of its two triangles. Processors without AVX2 take what they have.
/// @return what rtcNewDevice() takes
[[nodiscard]] const char* embree_config();

}  // namespace earpoint
