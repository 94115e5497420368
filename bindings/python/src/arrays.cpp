#include "arrays.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <earpoint/synthesis/earpoint_path.h>

namespace earpoint::python {
namespace py = pybind11;
namespace {

/// Integers would be taken for samples far beyond full scale.
void check_samples(const py::array& sound, const std::string& name) {
  if (sound.dtype().kind() != 'f') {
    throw py::value_error(fmt::format(
        "{}: expected float samples from -1 to 1, found {}; divide 16-bit samples by 32768", name,
        shape_text(sound)));
  }
  if (sound.ndim() < 1 || sound.ndim() > 2) {
    throw py::value_error(fmt::format("{}: expected an array [channels, samples], found {}", name,
                                      shape_text(sound)));
  }
  // Sound files are often read as [samples, channels].
  if (sound.ndim() == 2 && sound.shape(0) > sound.shape(1) && sound.shape(1) > 0 &&
      sound.shape(1) <= 2) {
    throw py::value_error(
        fmt::format("{}: expected an array [channels, samples], found {}; transpose it with .T",
                    name, shape_text(sound)));
  }
}

void expect_count(std::size_t found, std::size_t expected, const std::string& name,
                  const char* what) {
  if (found == expected) return;
  throw py::value_error(fmt::format("{}: expected {}, found {} numbers", name, what, found));
}

}  // namespace

std::string shape_text(const py::array& array) {
  return fmt::format("{} of shape ({})", py::str(array.dtype()).cast<std::string>(),
                     fmt::join(array.shape(), array.shape() + array.ndim(), ", "));
}

Waveform waveform_of(const py::array& sound, int sample_rate_hz, const std::string& name) {
  if (sample_rate_hz <= 0) {
    throw py::value_error(
        fmt::format("rate: expected a sample rate in Hz, found {}", sample_rate_hz));
  }
  check_samples(sound, name);
  const auto samples = PlainSamples::ensure(sound);
  if (!samples) throw py::error_already_set();
  const py::ssize_t channels = sound.ndim() == 2 ? sound.shape(0) : 1;
  const py::ssize_t count = sound.shape(sound.ndim() - 1);
  Waveform wave(static_cast<int>(channels), count, sample_rate_hz);
  std::copy_n(samples.data(), wave.planar().size(), wave.planar().begin());
  return wave;
}

py::array_t<float> array_of(Waveform sound) {
  auto* kept = new Waveform(std::move(sound));
  const py::capsule owner(kept, [](void* memory) { delete static_cast<Waveform*>(memory); });
  return py::array_t<float>(
      {static_cast<py::ssize_t>(kept->channels()), static_cast<py::ssize_t>(kept->samples())},
      kept->planar().data(), owner);
}

Image image_of(const py::array& picture) {
  if (picture.ndim() != 3 || picture.shape(2) != 3 ||
      !picture.dtype().is(py::dtype::of<std::uint8_t>()) || picture.size() == 0) {
    throw py::value_error(fmt::format(
        "image: expected uint8 of shape (height, width, 3), RGB, found {}", shape_text(picture)));
  }
  const auto pixels = py::array_t<std::uint8_t, py::array::c_style>::ensure(picture);
  Image image(static_cast<int>(picture.shape(1)), static_cast<int>(picture.shape(0)), 3);
  std::copy_n(pixels.data(), image.pixels().size(), image.pixels().begin());
  return image;
}

py::array_t<std::uint8_t> channels_first(const Image& picture) {
  py::array_t<std::uint8_t> planes({picture.channels(), picture.height(), picture.width()});
  std::uint8_t* next = planes.mutable_data();
  for (int channel = 0; channel < picture.channels(); ++channel) {
    for (int y = 0; y < picture.height(); ++y) {
      for (int x = 0; x < picture.width(); ++x) *next++ = picture.at(x, y, channel);
    }
  }
  return planes;
}

Vector3 place_of(const std::vector<double>& numbers, const std::string& name) {
  expect_count(numbers.size(), 3, name, "x, y, z in metres");
  return {numbers[0], numbers[1], numbers[2]};
}

std::optional<Vector3> place_of(const std::optional<std::vector<double>>& numbers,
                                const std::string& name) {
  if (!numbers) return std::nullopt;
  return place_of(*numbers, name);
}

std::optional<Box> box_of(const std::optional<std::vector<double>>& numbers) {
  if (!numbers) return std::nullopt;
  expect_count(numbers->size(), 4, "speaker_box", "x_min, y_min, x_max, y_max");
  return Box{(*numbers)[0], (*numbers)[1], (*numbers)[2], (*numbers)[3]};
}

Pose pose_of(const std::vector<double>& numbers) {
  expect_count(numbers.size(), 6, "pose", "x, y, z in metres and yaw, pitch, roll in degrees");
  constexpr std::array<const char*, 3> kAngles = {"yaw", "pitch", "roll"};
  for (std::size_t i = 0; i < kAngles.size(); ++i) check_angle_deg(numbers[3 + i], kAngles[i]);
  return {{numbers[0], numbers[1], numbers[2]},
          quaternion_from_euler({radians_from_degrees(numbers[3]), radians_from_degrees(numbers[4]),
                                 radians_from_degrees(numbers[5])})};
}

}  // namespace earpoint::python
