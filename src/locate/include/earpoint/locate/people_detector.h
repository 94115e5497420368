#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/image.h>

namespace earpoint {

/// A person found in a picture.
struct DetectedPerson {
  Box box;             ///< around what is visible of the person, in fractions of the picture
  double score = 0.0;  ///< how sure the detector is, 0 to 1
};

/// Finds people in single pictures. One caller at a time.
class PeopleDetector {
 public:
  virtual ~PeopleDetector() = default;

  /// The people in a picture, the surest first; boxes overlap only where people do.
  /// @param picture  sRGB, three channels, of any size
  /// @throws std::logic_error if the picture is empty or has another number of channels
  [[nodiscard]] virtual std::vector<DetectedPerson> detect(const Image& picture) = 0;

  /// Which detector this is, for people to read, e.g. "people.safetensors (Earpoint)".
  [[nodiscard]] virtual std::string name() const = 0;

 protected:
  PeopleDetector() = default;
  PeopleDetector(const PeopleDetector&) = default;
  PeopleDetector& operator=(const PeopleDetector&) = default;
};

/// Makes a detector out of a file: a weight file of the project's own network (.safetensors), or a
/// network that OpenCV runs (.onnx), where Earpoint was built with OpenCV.
/// @param file     nothing: the project's own network that is shipped as people.safetensors;
///                 "nanodet": the one that `./dev assets --people` has installed
/// @param threads  > 0
/// @throws InputError if the file is missing, of another kind or damaged, or needs OpenCV and this
///         build is without
[[nodiscard]] std::unique_ptr<PeopleDetector> make_people_detector(
    const std::optional<std::filesystem::path>& file = std::nullopt, int threads = 1);

}  // namespace earpoint
