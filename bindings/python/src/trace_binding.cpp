#include "arrays.h"
#include "bindings.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <earpoint/audio/decay.h>
#include <earpoint/error.h>
#include <earpoint/trace.h>

namespace earpoint::python {
namespace py = pybind11;
namespace {

using Numbers = std::vector<double>;

TraceMicrophone microphone_named(const std::string& name) {
  if (name == "ears") return TraceMicrophone::ears;
  if (name == "omni") return TraceMicrophone::omni;
  throw py::value_error(fmt::format("microphone: expected 'ears' or 'omni', found '{}'", name));
}

py::array_t<float> response(const TraceScene& scene, const Numbers& source, const Numbers& listener,
                            const std::string& microphone, bool talks, int rate, double duration_s,
                            int rays, std::uint64_t seed, int threads) {
  const TraceRequest request{.source = pose_of(source),
                             .listener = pose_of(listener),
                             .microphone = microphone_named(microphone),
                             .talks = talks,
                             .sample_rate_hz = rate,
                             .duration_s = duration_s,
                             .rays = rays,
                             .seed = seed,
                             .threads = threads};
  return array_of(without_lock([&] { return scene.response(request); }));
}

/// Nothing where the decay does not reach far enough.
template <typename Measure>
std::optional<double> if_it_decays(const Measure& measure, std::span<const float> samples,
                                   int rate) {
  try {
    return measure(samples, rate);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

/// T30, EDT and C50 of every channel.
std::vector<std::array<std::optional<double>, 3>> reverberation(const py::array& samples,
                                                                int rate) {
  const Waveform wave = waveform_of(samples, rate, "response");
  return without_lock([&] {
    std::vector<std::array<std::optional<double>, 3>> measured;
    for (int channel = 0; channel < wave.channels(); ++channel) {
      const auto sound = wave.channel(channel);
      measured.push_back({if_it_decays(reverberation_time_t30_s, sound, rate),
                          if_it_decays(early_decay_time_s, sound, rate),
                          if_it_decays(clarity_c50_db, sound, rate)});
    }
    return measured;
  });
}

}  // namespace

void bind_trace(py::module_& module) {
  py::class_<TraceScene>(module, "Scene")
      .def_static("open",
                  [](const std::string& file) {
                    return without_lock([&] { return TraceScene::open(file); });
                  })
      .def_static(
          "box",
          [](const Numbers& lengths, double absorption, double scattering) {
            const Vector3 lengths_m = place_of(lengths, "lengths");
            if (!(lengths_m.x > 0.0 && lengths_m.y > 0.0 && lengths_m.z > 0.0)) {
              throw py::value_error("lengths: expected three lengths above 0, in metres");
            }
            return without_lock([&] { return TraceScene::box(lengths_m, absorption, scattering); });
          })
      .def("warnings", &TraceScene::warnings)
      .def("response", &response);
  module.def("reverberation", &reverberation);
}

}  // namespace earpoint::python
