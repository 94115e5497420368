#include "scene_argument.h"

#include "flag_checks.h"
#include "trace_arguments.h"

#include <CLI/CLI.hpp>

#include <earpoint/error.h>
#include <earpoint/scene/homes.h>
#include <earpoint/scene/import.h>
#include <earpoint/scene/model_pack.h>

namespace earpoint {
namespace {

void check_that_one_is_named(const SceneArgument& argument) {
  const int named = (argument.file.empty() ? 0 : 1) + (argument.shoebox.empty() ? 0 : 1) +
                    (argument.home_seed ? 1 : 0);
  if (named == 1) return;
  throw InputError("scene", named == 0 ? "none is given" : "several are given",
                   "give one of SCENE, --shoebox and --home");
}

void check_that_file_options_have_a_file(const SceneArgument& argument) {
  const auto refuse = [](const char* flag) {
    throw InputError(flag, "applies only to a scene that is read from a file", "leave it out");
  };
  if (!argument.materials.empty()) refuse("--materials");
  if (!argument.up_axis.empty()) refuse("--up");
  if (argument.unit_m != 1.0) refuse("--unit");
  if (argument.close_ceiling) refuse("--close-ceiling");
}

NamedScene read_scene_file(const SceneArgument& argument) {
  ImportOptions options{.unit_m = argument.unit_m, .close_ceiling = argument.close_ceiling};
  if (!argument.up_axis.empty()) {
    options.up_axis = argument.up_axis == "y" ? UpAxis::y : UpAxis::z;
  }
  std::optional<MaterialTable> table;
  if (!argument.materials.empty()) {
    table = load_material_table(argument.materials);
    options.materials = &*table;
  }
  ImportedScene imported = import_scene(argument.file, options);
  return {std::move(imported.scene), imported.origin_m, imported.report.warnings()};
}

}  // namespace

void add_scene_argument(CLI::App& command, SceneArgument& argument) {
  command.add_option("scene", argument.file, "Model to read: .glb, .gltf, .obj or .ply")
      ->type_name("SCENE");
  command.add_option(
      "--shoebox", argument.shoebox,
      "An empty room instead of a file, one corner at the origin: LX,LY,LZ[,absorption=A]"
      "[,scattering=S], metres and fractions of energy");
  command
      .add_option("--home", argument.home_seed,
                  "A furnished home instead of a file, generated from this seed with the installed "
                  "furniture")
      ->check(whole_number());
  command.add_option("--materials", argument.materials,
                     "JSON table of acoustic materials for the file's surfaces");
  command.add_option("--up", argument.up_axis, "Axis that points up in the file")
      ->check(CLI::IsMember({"y", "z"}));
  command.add_option("--unit", argument.unit_m, "Length of the file's unit, metres")
      ->capture_default_str();
  command.add_flag("--close-ceiling", argument.close_ceiling,
                   "Add a ceiling where the file has none");
}

NamedScene read_scene(const SceneArgument& argument) {
  check_that_one_is_named(argument);
  if (!argument.file.empty()) return read_scene_file(argument);
  check_that_file_options_have_a_file(argument);
  if (argument.home_seed) {
    const FurnitureLibrary library(installed_models().furniture);
    return {make_home(*argument.home_seed, {}, library).scene, {}, {}};
  }
  return {parse_shoebox("--shoebox", argument.shoebox), {}, {}};
}

}  // namespace earpoint
