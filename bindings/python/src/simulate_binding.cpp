#include "bindings.h"

#include "simulate_run.h"

#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <earpoint/core/progress.h>
#include <earpoint/generate/generation_summary.h>

namespace earpoint::python {
namespace py = pybind11;
namespace {

/// Takes an option out of those that are given: misspelt ones are left, and refused.
/// @throws pybind11::type_error if it is of another type
template <typename Value>
void take(const py::dict& options, const char* name, Value& value) {
  if (!options.contains(name)) return;
  const py::object given = options.attr("pop")(name);
  if (given.is_none()) return;
  try {
    value = given.cast<Value>();
  } catch (const py::cast_error&) {
    throw py::type_error(
        fmt::format("simulate(): option '{}' cannot be {}", name, std::string(py::repr(given))));
  }
}

void take(const py::dict& options, const char* name, std::optional<std::filesystem::path>& value) {
  std::optional<std::string> given;
  take(options, name, given);
  if (given) value = *given;
}

SimulateOptions options_of(const std::string& out, const py::dict& options) {
  SimulateOptions what;
  GenerationOptions& generation = what.generation;
  generation.folder = out;
  std::vector<std::string> scenes;
  take(options, "scene", scenes);
  what.scenes.assign(scenes.begin(), scenes.end());
  take(options, "scenes", generation.order.scenes);
  take(options, "materials", what.materials);
  take(options, "up", what.up_axis);
  take(options, "unit", what.unit_m);
  take(options, "close_ceiling", what.close_ceiling);
  take(options, "conversations", generation.order.conversations);
  take(options, "split", what.split);
  take(options, "speech", what.speech);
  take(options, "seed", generation.seed);
  take(options, "viewpoints", generation.conversation.viewpoints);
  take(options, "other_rooms", generation.conversation.other_room_share);
  take(options, "other_rooms_reach", generation.conversation.other_room_reach_m);
  take(options, "height_spread", generation.conversation.height_spread_m);
  take(options, "rays", generation.quality.rays);
  take(options, "rate", generation.quality.sample_rate_hz);
  take(options, "duration", generation.quality.duration_s);
  take(options, "path_prefix", generation.path_prefix);
  take(options, "released_speech", what.released_speech);
  take(options, "heard", generation.write_heard);
  take(options, "jobs", what.jobs);
  take(options, "shard", what.shard);
  for (const auto& [name, value] : options) {
    throw py::type_error("simulate() has no option '" + py::str(name).cast<std::string>() + "'");
  }
  return what;
}

/// @return the summary as JSON, and what the importer of scenes warned of
std::pair<std::string, std::vector<std::string>> run(const std::string& out,
                                                     const py::dict& options) {
  SimulateOptions what = options_of(out, options);
  return without_lock([&] {
    SilentProgress silent;
    std::mutex mutex;
    std::vector<std::string> lines;
    const auto warn = [&](const std::filesystem::path& file, const std::string& warning) {
      const std::lock_guard guard(mutex);
      lines.push_back(file.string() + ": " + warning);
    };
    const GenerationSummary summary = simulate(std::move(what), warn, silent);
    return std::pair{json_of(summary), std::move(lines)};
  });
}

}  // namespace

void bind_simulate(py::module_& module) { module.def("simulate", &run); }

}  // namespace earpoint::python
