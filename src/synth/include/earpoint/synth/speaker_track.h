#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <earpoint/core/image.h>

namespace earpoint {

/// Where the active speaker is seen in the source picture over time.
class SpeakerTrack {
 public:
  /// One box for the whole clip.
  /// @throws InputError if the box is empty or leaves the picture
  explicit SpeakerTrack(const Box& box);

  /// Reads `time_s,x0,y0,x1,y1` (that header first; normalised to the picture; times grow).
  /// @throws InputError naming the line
  static SpeakerTrack from_csv(const std::filesystem::path& path);
  /// The same from text; `name` stands for the file in messages.
  static SpeakerTrack parse_csv(const std::string& text, const std::string& name);

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
