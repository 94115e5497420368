#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <earpoint/image.h>
#include <earpoint/pose.h>
#include <earpoint/waveform.h>

namespace earpoint::python {

/// What Python passes and gets: NumPy arrays, tuples and None, checked here. A caller's mistake
/// (shape, type) throws pybind11::value_error, which Python sees as ValueError, and says what was
/// expected and what was found.

/// Float32 in C's order, of any array of numbers: copied if it is anything else, or not aligned.
using PlainSamples =
    pybind11::array_t<float, pybind11::array::c_style | pybind11::array::forcecast |
                                 pybind11::detail::npy_api::NPY_ARRAY_ALIGNED_>;

/// What an array is, for messages: "float32 of shape (2, 480)".
[[nodiscard]] std::string shape_text(const pybind11::array& array);

/// @param sound  [channels, samples], or [samples] for one channel; float32 or float64, -1 to 1
/// @param name   the argument, for messages
/// @return       a copy
[[nodiscard]] Waveform waveform_of(const pybind11::array& sound, int sample_rate_hz,
                                   const std::string& name);

/// Takes the sound's memory: nothing is copied. @return float32, [channels, samples]
[[nodiscard]] pybind11::array_t<float> array_of(Waveform sound);

/// The same for numbers of any type and shape.
template <typename T>
[[nodiscard]] pybind11::array_t<T> array_of(std::vector<T> values,
                                            const std::vector<pybind11::ssize_t>& shape) {
  auto* kept = new std::vector<T>(std::move(values));
  const pybind11::capsule owner(kept,
                                [](void* memory) { delete static_cast<std::vector<T>*>(memory); });
  return pybind11::array_t<T>(shape, kept->data(), owner);
}

/// @param picture  [height, width, 3], uint8, RGB
[[nodiscard]] Image image_of(const pybind11::array& picture);

/// @return uint8, [channels, height, width], as PyTorch has pictures
[[nodiscard]] pybind11::array_t<std::uint8_t> channels_first(const Image& picture);

/// Three numbers, metres. @param name  the argument, for messages
[[nodiscard]] Vector3 place_of(const std::vector<double>& numbers, const std::string& name);
[[nodiscard]] std::optional<Vector3> place_of(const std::optional<std::vector<double>>& numbers,
                                              const std::string& name);

/// x_min, y_min, x_max, y_max, fractions of the picture or its pixels.
[[nodiscard]] std::optional<Box> box_of(const std::optional<std::vector<double>>& numbers);

/// @param numbers  x, y, z in metres, yaw, pitch, roll in degrees
/// @throws InputError if an angle is not finite or beyond a hundred turns
[[nodiscard]] Pose pose_of(const std::vector<double>& numbers);

}  // namespace earpoint::python
