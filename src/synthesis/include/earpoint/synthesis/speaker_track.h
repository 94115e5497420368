#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <earpoint/image.h>

namespace earpoint {

/// Where the active speaker is seen in the source picture over time.
class SpeakerTrack {
 public:
  /// One moment; without a box the speaker is not in the picture.
  struct Row {
    double time_s = 0.0;
    std::optional<Box> box;

    friend bool operator==(const Row&, const Row&) = default;
  };

  /// The picture's size in pixels, where it is known.
  using PictureSize = std::optional<std::array<int, 2>>;

  /// One box for the whole clip.
  /// @param box      normalised to the picture; with numbers beyond 2 in pixels
  /// @param picture  needed for pixels
  /// @throws InputError if the box is empty or leaves the picture
  explicit SpeakerTrack(const Box& box, const PictureSize& picture = std::nullopt);

  /// @param rows  not empty, times grow, boxes normalised
  explicit SpeakerTrack(std::vector<Row> rows);

  /// Reads `time_s,x0,y0,x1,y1` (that header first; times grow). All boxes are in pixels if one has
  /// a number beyond 2, else normalised.
  ///
  /// Or what `earpoint locate -o` writes, `time_s,track,x0,y0,x1,y1,speaking,voice`, a row for
  /// every person: the speaker is the one with the largest `speaking`, or somebody outside the
  /// picture where the rest of `voice` is larger; while `voice` is below one half, who spoke
  /// before.
  /// @throws InputError naming the line
  static SpeakerTrack from_csv(const std::filesystem::path& path,
                               const PictureSize& picture = std::nullopt);
  /// The same from text; `name` stands for the file in messages.
  static SpeakerTrack parse_csv(const std::string& text, const std::string& name,
                                const PictureSize& picture = std::nullopt);

  /// @return the box whose time is nearest; nothing if the speaker is not in the picture then
  [[nodiscard]] std::optional<Box> at(double time_s) const;

  [[nodiscard]] std::span<const Row> rows() const { return rows_; }

  /// The same where moments without a box take that of the nearest moment with one.
  /// @return nothing if no moment has one
  [[nodiscard]] std::optional<SpeakerTrack> held() const;

 private:
  std::vector<Row> rows_;
};

}  // namespace earpoint
