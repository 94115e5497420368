#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/scene/scene.h>

namespace CLI {
class App;
}

namespace earpoint {

/// Which scene a command works on: a model file, a box, or a home drawn from a seed.
struct SceneArgument {
  std::filesystem::path file;
  std::string shoebox;
  std::optional<std::uint64_t> home_seed;
  std::filesystem::path materials;  ///< of a file's surfaces; empty: the standard table
  std::string up_axis;              ///< of a file; empty: as its format has it
  double unit_m = 1.0;              ///< of a file
  bool close_ceiling = false;       ///< of a file
};

/// Adds SCENE, --shoebox, --home, --materials, --up, --unit and --close-ceiling.
/// @param argument  filled when the command line is parsed; must live that long
void add_scene_argument(CLI::App& command, SceneArgument& argument);

struct NamedScene {
  Scene scene;
  Vector3 origin_m;                   ///< of the scene, in the user's coordinates
  std::vector<std::string> warnings;  ///< one line each, for standard error
};

/// @throws InputError if no scene or several are named, or it cannot be read
NamedScene read_scene(const SceneArgument& argument);

}  // namespace earpoint
