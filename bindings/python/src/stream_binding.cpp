#include "arrays.h"
#include "bindings.h"
#include "stream_door.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pybind11/stl.h>

namespace earpoint::python {
namespace py = pybind11;
namespace {

using Numbers = std::vector<double>;
using Samples = py::array_t<float>;

/// Whether the array is [2, samples] of float32 and the samples of a channel lie side by side: then
/// the engine reads or writes it where it is.
bool is_block(const py::array& block) {
  return py::isinstance<Samples>(block) && block.ndim() == 2 && block.shape(0) == 2 &&
         (block.shape(1) <= 1 || block.strides(1) == static_cast<py::ssize_t>(sizeof(float)));
}

std::string found_text(const py::array& block) {
  return fmt::format("{} of shape ({})", py::str(block.dtype()).cast<std::string>(),
                     fmt::join(block.shape(), block.shape() + block.ndim(), ", "));
}

/// The block itself, or a copy in the engine's form.
py::array readable(const py::array& block) {
  if (is_block(block)) return block;
  if (block.dtype().kind() != 'f' || block.ndim() != 2 || block.shape(0) != 2) {
    throw py::value_error("block: expected float32 of shape (2, samples), found " +
                          found_text(block));
  }
  auto copy = py::array_t<float, py::array::c_style | py::array::forcecast>::ensure(block);
  if (!copy) throw py::error_already_set();
  return copy;
}

/// First and last byte of a block.
std::pair<std::uintptr_t, std::uintptr_t> extent_of(const py::array& block) {
  const auto first = reinterpret_cast<std::uintptr_t>(block.data());
  std::uintptr_t low = first;
  std::uintptr_t high = first + block.shape(1) * sizeof(float);
  const std::uintptr_t second = first + block.strides(0);
  low = std::min(low, second);
  high = std::max(high, second + block.shape(1) * sizeof(float));
  return {low, high};
}

void check_writable(const py::array& out, const py::array& block) {
  if (!is_block(out) || out.shape(1) != block.shape(1)) {
    throw py::value_error(fmt::format(
        "out: expected float32 of shape (2, {}), a channel's samples side by side, found {}",
        block.shape(1), found_text(out)));
  }
  if (!out.writeable()) throw py::value_error("out: is read-only");
  const bool is_same = out.data() == block.data() && out.strides(0) == block.strides(0);
  const auto [from, to] = extent_of(out);
  const auto [begin, end] = extent_of(block);
  if (!is_same && from < end && begin < to) {
    throw py::value_error("out: overlaps the block; give the block itself or another array");
  }
}

py::array process(StreamDoor& door, const py::array& given, const std::optional<py::array>& out) {
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
  without_lock([&] {
    door.alone([&](Stream& stream) { stream.process(in.data(), rendered.data(), frames); });
  });
  return result;
}

void see(StreamDoor& door, const std::optional<py::array>& picture,
         const std::optional<Numbers>& box) {
  const std::optional<Box> seen = box_of(box);
  if (!picture) {
    without_lock([&] { door.alone([&](Stream& stream) { stream.see_nothing(seen); }); });
    return;
  }
  const Image image = image_of(*picture);
  without_lock([&] { door.alone([&](Stream& stream) { stream.see(image, seen); }); });
}

std::optional<std::array<double, 3>> speaker(StreamDoor& door) {
  const auto found =
      without_lock([&] { return door.alone([](Stream& stream) { return stream.speaker_m(); }); });
  if (!found) return std::nullopt;
  return std::array{found->x, found->y, found->z};
}

}  // namespace

void bind_stream(py::module_& module) {
  py::class_<StreamDoor>(module, "Stream")
      .def("process", &process)
      .def("see", &see)
      .def("place_speaker",
           [](StreamDoor& door, const std::optional<Numbers>& mouth) {
             const auto mouth_m = place_of(mouth, "speaker");
             without_lock(
                 [&] { door.alone([&](Stream& stream) { stream.place_speaker(mouth_m); }); });
           })
      .def("move_to",
           [](StreamDoor& door, const Numbers& numbers) {
             const Pose pose = pose_of(numbers);
             without_lock([&] { door.alone([&](Stream& stream) { stream.move_to(pose); }); });
           })
      .def("latency",
           [](StreamDoor& door) {
             return without_lock([&] {
               return door.alone([](Stream& stream) { return stream.latency_samples(); });
             });
           })
      .def("speaker", &speaker)
      .def("reset", [](StreamDoor& door) {
        without_lock([&] { door.alone([](Stream& stream) { stream.reset(); }); });
      });
}

}  // namespace earpoint::python
