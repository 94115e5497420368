#pragma once

#include "light_guide.h"
#include "lights.h"
#include "patches.h"
#include "ray_tracer.h"
#include "surfaces.h"

namespace earpoint {

/// The parts of a scene that light sampling needs, together.
struct LitScene {
  const Surfaces& surfaces;
  const RayTracer& tracer;
  const Patches& patches;
  const Lights& lights;
  const LightGuide& guide;
  Rgb sky;  ///< radiance of what lies outside
};

}  // namespace earpoint
