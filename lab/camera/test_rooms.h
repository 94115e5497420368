#pragma once

#include <array>
#include <string>

#include <earpoint/scene/scene.h>

namespace earpoint {

/// Rooms with known contents, for tests and measurements.

/// Adds a closed axis-aligned box as an instance of its own, normals outward, and the unit square
/// of the texture on every face.
/// @return the instance
int add_box(Scene& scene, const std::string& name, InstanceKind kind, const Vector3& low,
            const Vector3& high, const Look& look);

/// Adds a ball as an instance of its own, with smooth normals.
/// @param rings  from pole to pole; 4 rings^2 triangles
/// @return the instance
int add_ball(Scene& scene, const std::string& name, const Vector3& centre, double radius_m,
             int rings, const Look& look);

/// Adds a rectangle without thickness.
/// @param corner  its first corner; along, across: its edges
/// @param repeat  how often the texture repeats along the edges
/// @return the instance
int add_rectangle(Scene& scene, const std::string& name, const Vector3& corner,
                  const Vector3& along, const Vector3& across, const Look& look,
                  std::array<float, 2> repeat = {1.0F, 1.0F});

/// A room of 6 m x 4.5 m x 2.6 m with planks on the floor, a carpet, a window in the wall x = 6 m,
/// a ceiling lamp, and furniture put together from boxes and balls.
Scene furnished_room();

/// A flat look of one colour.
Look plain_look(float red, float green, float blue);

}  // namespace earpoint
