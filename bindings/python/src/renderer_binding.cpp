#include "arrays.h"
#include "bindings.h"
#include "locked.h"

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <earpoint/core/csv.h>
#include <earpoint/core/file.h>
#include <earpoint/renderer.h>
#include <earpoint/stream.h>
#include <earpoint/synthesis/earpoint_path.h>

namespace earpoint::python {
namespace py = pybind11;
namespace {

using Numbers = std::vector<double>;

/// A request, and the picture that it points to.
struct OwnedRequest {
  std::optional<Image> picture;
  RenderRequest request;

  const RenderRequest& pointed() {
    request.picture = picture ? &*picture : nullptr;
    return request;
  }
};

std::vector<PathPoint> path_from_rows(const std::vector<Numbers>& rows) {
  std::vector<PathPoint> path;
  for (const Numbers& row : rows) {
    if (row.size() != 7) {
      throw py::value_error(
          fmt::format("path: expected rows of time in s, x, y, z in m and yaw, pitch, roll in "
                      "degrees, found {} numbers",
                      row.size()));
    }
    path.push_back({row[0], pose_of({row.begin() + 1, row.end()})});
  }
  return path;
}

std::vector<PathPoint> path_from_file(const std::string& file) {
  static constexpr std::array<std::string_view, 7> kColumns = {
      "time_s", "x", "y", "z", "yaw_deg", "pitch_deg", "roll_deg"};
  const std::string text = read_text_file(file);
  (void)EarpointPath::parse_csv(text, file);  // for its messages, which name lines
  std::vector<Numbers> rows;
  for (NumberRow& row : parse_number_csv(text, file, kColumns)) {
    rows.push_back(std::move(row.values));
  }
  return path_from_rows(rows);
}

OwnedRequest request_of(const std::optional<py::array>& image,
                        const std::optional<Numbers>& speaker, const std::optional<Numbers>& box,
                        const Numbers& pose, const py::object& path,
                        const std::pair<bool, bool>& extend_and_limit, double gain_db) {
  OwnedRequest owned;
  if (image) owned.picture = image_of(*image);
  owned.request.speaker_box = box_of(box);
  owned.request.speaker_m = place_of(speaker, "speaker");
  owned.request.target = pose_of(pose);
  if (py::isinstance<py::str>(path)) {
    owned.request.path = path_from_file(path.cast<std::string>());
  } else if (!path.is_none()) {
    owned.request.path = path_from_rows(path.cast<std::vector<Numbers>>());
  }
  owned.request.extend_band = extend_and_limit.first;
  owned.request.limit = extend_and_limit.second;
  owned.request.gain_db = gain_db;
  return owned;
}

std::unique_ptr<Locked<Renderer>> open_renderer(const std::string& model, double fov_deg,
                                                std::optional<double> texture,
                                                std::optional<std::string> hrtf, int threads) {
  return without_lock([&] {
    return std::make_unique<Locked<Renderer>>(
        Renderer::open(model, {.horizontal_fov_rad = radians_from_degrees(fov_deg),
                               .texture = texture,
                               .hrtf = std::move(hrtf),
                               .threads = threads}));
  });
}

py::array_t<float> render(Locked<Renderer>& locked, const py::array& audio, int rate,
                          const std::optional<py::array>& image,
                          const std::optional<Numbers>& speaker, const std::optional<Numbers>& box,
                          const Numbers& pose, const py::object& path,
                          const std::pair<bool, bool>& extend_and_limit, double gain_db) {
  const Waveform sound = waveform_of(audio, rate, "audio");
  if (sound.channels() != 1 && sound.channels() != 2) {
    throw py::value_error(
        fmt::format("audio: expected one or two channels, found {}", sound.channels()));
  }
  OwnedRequest owned = request_of(image, speaker, box, pose, path, extend_and_limit, gain_db);
  return array_of(
      locked.run([&](Renderer& renderer) { return renderer.render(sound, owned.pointed()); }));
}

std::vector<std::string> warnings(Locked<Renderer>& locked, const py::array& audio, int rate,
                                  const std::optional<py::array>& image,
                                  const std::optional<Numbers>& speaker,
                                  const std::optional<Numbers>& box, const Numbers& pose,
                                  const py::object& path) {
  const Waveform sound = waveform_of(audio, rate, "audio");
  OwnedRequest owned = request_of(image, speaker, box, pose, path, {true, true}, 0.0);
  return locked.run([&](Renderer& renderer) { return renderer.warnings(sound, owned.pointed()); });
}

std::unique_ptr<Locked<Stream>> stream(Locked<Renderer>& locked, int rate, bool extend_band,
                                       bool limit, std::optional<int> phase_rounds) {
  return locked.run([&](Renderer& renderer) {
    return std::make_unique<Locked<Stream>>(renderer.stream({.sample_rate_hz = rate,
                                                             .extend_band = extend_band,
                                                             .limit = limit,
                                                             .phase_rounds = phase_rounds}));
  });
}

}  // namespace

void bind_renderer(py::module_& module) {
  py::class_<Locked<Renderer>>(module, "Renderer")
      .def(py::init(&open_renderer))
      .def("render", &render)
      .def("warnings", &warnings)
      .def("stream", &stream)
      .def("model", [](Locked<Renderer>& locked) {
        return locked.run([](Renderer& renderer) { return std::string(renderer.model()); });
      });
}

}  // namespace earpoint::python
