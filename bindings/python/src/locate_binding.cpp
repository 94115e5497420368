#include "bindings.h"

#include "locate_report.h"
#include "speaker_search.h"

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <pybind11/stl.h>

#include <earpoint/core/progress.h>

namespace earpoint::python {
namespace py = pybind11;
namespace {

/// What `earpoint locate --json` prints.
std::string locate_json(const SourceArguments& source, const std::string& model,
                        const std::string& detector, bool is_3d) {
  SilentProgress silent;
  const LocateResult result =
      locate({.source = source, .model = model, .detector = detector, .quiet = true}, silent);
  return json_of(result, is_3d).dump();
}

}  // namespace

void bind_locate(py::module_& module) {
  module.def("locate", [](const std::vector<std::string>& inputs, const std::string& speaker_box,
                          const std::string& speaker_boxes, std::optional<double> fov_deg,
                          const std::string& recording, const std::string& model,
                          const std::string& detector, bool is_3d) {
    SourceArguments source;
    source.inputs = inputs;
    source.speaker_box = speaker_box;
    source.speaker_boxes = speaker_boxes;
    source.fov_deg = fov_deg;
    source.recording = recording;
    return without_lock([&] { return locate_json(source, model, detector, is_3d); });
  });
}

}  // namespace earpoint::python
