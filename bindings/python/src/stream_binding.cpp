#include "arrays.h"
#include "bindings.h"
#include "locked.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <earpoint/stream.h>

namespace earpoint::python {
namespace py = pybind11;
namespace {

using Numbers = std::vector<double>;
using Samples = py::array_t<float>;

/// Whether the array is [2, samples] of float32 and the samples of a channel lie side by side: then
/// the engine reads or writes it where it is.
bool is_block(const py::array& block) {
  return py::isinstance<Samples>(block) && block.ndim() == 2 && block.shape(0) == 2 &&
         (block.flags() & py::detail::npy_api::NPY_ARRAY_ALIGNED_) != 0 &&
         (block.shape(1) <= 1 || block.strides(1) == static_cast<py::ssize_t>(sizeof(float)));
}

/// The block itself, or a copy in the engine's form.
py::array readable(const py::array& block) {
  if (is_block(block)) return block;
  if (block.dtype().kind() != 'f' || block.ndim() != 2 || block.shape(0) != 2) {
    throw py::value_error("block: expected float32 of shape (2, samples), found " +
                          shape_text(block));
  }
  auto copy = PlainSamples::ensure(block);
  if (!copy) throw py::error_already_set();
  return copy;
}

/// The addresses of a block: its first byte, and the one after its last.
std::pair<std::uintptr_t, std::uintptr_t> extent_of(const py::array& block) {
  const auto left = reinterpret_cast<std::uintptr_t>(block.data());
  const auto [low, high] = std::minmax({left, left + block.strides(0)});
  return {low, high + block.shape(1) * sizeof(float)};
}

void check_writable(const py::array& out, const py::array& block) {
  if (!is_block(out) || out.shape(1) != block.shape(1)) {
    throw py::value_error(fmt::format(
        "out: expected float32 of shape (2, {}), a channel's samples side by side, found {}",
        block.shape(1), shape_text(out)));
  }
  if (!out.writeable()) throw py::value_error("out: is read-only");
  const bool is_same = out.data() == block.data() && out.strides(0) == block.strides(0);
  const auto [from, to] = extent_of(out);
  const auto [begin, end] = extent_of(block);
  if (!is_same && from < end && begin < to) {
    throw py::value_error("out: overlaps the block; give the block itself or another array");
  }
}

py::array process(Locked<Stream>& locked, const py::array& given,
                  const std::optional<py::array>& out) {
  const py::array block = readable(given);
  const py::ssize_t frames = block.shape(1);
  py::array result = out ? *out : py::array(Samples({static_cast<py::ssize_t>(2), frames}));
  check_writable(result, block);
  const auto* from = static_cast<const std::byte*>(block.data());
  auto* to = static_cast<std::byte*>(result.mutable_data());
  const std::array<const float*, 2> in{reinterpret_cast<const float*>(from),
                                       reinterpret_cast<const float*>(from + block.strides(0))};
  const std::array<float*, 2> rendered{reinterpret_cast<float*>(to),
                                       reinterpret_cast<float*>(to + result.strides(0))};
  locked.run([&](Stream& stream) { stream.process(in.data(), rendered.data(), frames); });
  return result;
}

void see(Locked<Stream>& locked, const std::optional<py::array>& picture,
         const std::optional<Numbers>& box) {
  const std::optional<Box> seen = box_of(box);
  if (!picture) {
    locked.run([&](Stream& stream) { stream.see_nothing(seen); });
    return;
  }
  const Image image = image_of(*picture);
  locked.run([&](Stream& stream) { stream.see(image, seen); });
}

std::optional<std::array<double, 3>> speaker(Locked<Stream>& locked) {
  const auto found = locked.run([](Stream& stream) { return stream.speaker_m(); });
  if (!found) return std::nullopt;
  return std::array{found->x, found->y, found->z};
}

}  // namespace

void bind_stream(py::module_& module) {
  py::class_<Locked<Stream>>(module, "Stream")
      .def("process", &process)
      .def("see", &see)
      .def("place_speaker",
           [](Locked<Stream>& locked, const std::optional<Numbers>& mouth) {
             const auto mouth_m = place_of(mouth, "speaker");
             locked.run([&](Stream& stream) { stream.place_speaker(mouth_m); });
           })
      .def("move_to",
           [](Locked<Stream>& locked, const Numbers& numbers) {
             const Pose pose = pose_of(numbers);
             locked.run([&](Stream& stream) { stream.move_to(pose); });
           })
      .def("latency",
           [](Locked<Stream>& locked) {
             return locked.run([](Stream& stream) { return stream.latency_samples(); });
           })
      .def("speaker", &speaker)
      .def("reset",
           [](Locked<Stream>& locked) { locked.run([](Stream& stream) { stream.reset(); }); });
}

}  // namespace earpoint::python
