#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/core/image.h>

namespace earpoint {

/// Where the active speaker is seen in the source picture over time.
class SpeakerTrack {
 public:
  /// The picture's size in pixels, where it is known.
  using PictureSize = std::optional<std::array<int, 2>>;

  /// One box for the whole clip.
  /// @param box      normalised to the picture; with numbers beyond 2 in pixels
  /// @param picture  needed for pixels
  /// @throws InputError if the box is empty or leaves the picture
  explicit SpeakerTrack(const Box& box, const PictureSize& picture = std::nullopt);

  /// Reads `time_s,x0,y0,x1,y1` (that header first; times grow). All boxes are in pixels if one has
  /// a number beyond 2, else normalised.
  /// @throws InputError naming the line
  static SpeakerTrack from_csv(const std::filesystem::path& path,
                               const PictureSize& picture = std::nullopt);
  /// The same from text; `name` stands for the file in messages.
  static SpeakerTrack parse_csv(const std::string& text, const std::string& name,
                                const PictureSize& picture = std::nullopt);

  /// @return the box whose time is nearest
  [[nodiscard]] Box at(double time_s) const;

 private:
  struct Row {
    double time_s = 0.0;
    Box box;
  };
  SpeakerTrack() = default;

  std::vector<Row> rows_;
};

}  // namespace earpoint
